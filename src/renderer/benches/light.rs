//! Time per direction of drawing from a light and of looking it up, 1024 directions at a time, one thread.

use brdfit_renderer::{Light, LightBandwidth, Procedural, sobol};
use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use std::hint::black_box;

const COUNT: usize = 1024;

fn light(criterion: &mut Criterion) {
    let light = Procedural::Sky.light(Light::SIZE);
    let bandwidth = LightBandwidth::new(&light);
    let (mut u, mut v) = (vec![0.0; COUNT], vec![0.0; COUNT]);
    sobol::fill(1, 0, [&mut u, &mut v]);
    // uniform over the sphere: the look-up with the fewest cache hits
    let uniform: [Vec<f32>; 3] = {
        let d = u.iter().zip(&v).map(|(&u, &v)| {
            let (z, phi) = (1.0 - 2.0 * u, std::f32::consts::TAU * v);
            let flat = (1.0 - z * z).sqrt();
            [flat * phi.cos(), flat * phi.sin(), z]
        });
        let d: Vec<[f32; 3]> = d.collect();
        std::array::from_fn(|k| d.iter().map(|d| d[k]).collect())
    };
    let d = [&uniform[0][..], &uniform[1], &uniform[2]];
    let footprint = vec![1e-3; COUNT];
    let [mut x, mut y, mut z, mut w] = [0; 4].map(|_| vec![0.0; COUNT]);

    let mut group = criterion.benchmark_group("light");
    group.throughput(Throughput::Elements(COUNT as u64));
    let mut seed = 0_u32;
    group.bench_function("points", |bencher| {
        bencher.iter(|| {
            seed = seed.wrapping_add(1);
            sobol::fill(sobol::mix(seed), 0, [&mut x, &mut y]);
        });
    });
    group.bench_function("sample", |bencher| {
        bencher.iter(|| light.sample_many(black_box([&u, &v]), [&mut x, &mut y, &mut z]));
    });
    group.bench_function("evaluate", |bencher| {
        bencher.iter(|| light.evaluate_many(black_box(d), [&mut x, &mut y, &mut z], &mut w));
    });
    group.bench_function("prefiltered", |bencher| {
        bencher.iter(|| light.prefiltered_many(black_box(d), &footprint, [&mut x, &mut y, &mut z]));
    });
    group.bench_function("bandwidth", |bencher| bencher.iter(|| bandwidth.at_many(black_box(d), &mut w)));
    group.finish();

    let mut group = criterion.benchmark_group("preparation");
    group.sample_size(10);
    group.bench_function("light", |bencher| bencher.iter(|| Procedural::Sky.light(Light::SIZE)));
    group.bench_function("bandwidth of the light", |bencher| bencher.iter(|| LightBandwidth::new(&light)));
    group.finish();
}

criterion_group!(benches, light);
criterion_main!(benches);
