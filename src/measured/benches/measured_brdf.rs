//! Time of a measured material: making it, and values of whole lobes.
//!
//! `BRDFIT_MERL=FILE.binary cargo bench -p brdfit-measured --bench measured_brdf` times a file of your own (in the page cache
//! after the first run); without it one is made in memory. The lobes are those of 64 x 64 directions on the angular map.

use std::hint::black_box;

use brdfit_brdf::{Brdf, Directions, direction};
use brdfit_measured::{Dimensions, MeasuredBrdf, MerlFile, SamplePosition, cosines};
use criterion::{Criterion, Throughput, criterion_group, criterion_main};

/// A file with as many missing cells as a genuine one: those below the horizon.
fn made(dimensions: Dimensions) -> MerlFile {
    let centre = SamplePosition::Centre;
    MerlFile::from_fn("made", dimensions, |channel, h, d, p| {
        let (cos_i, cos_o) = cosines(
            dimensions.theta_h_sample(h, centre),
            dimensions.theta_d_sample(d, centre),
            dimensions.phi_d_sample(p, centre),
        );
        if cos_i.min(cos_o) > 0.0 { 0.1 + channel as f64 + cos_i * cos_o } else { -1.0 }
    })
    .expect("finite values")
}

/// The hemisphere as an image: theta_o by the distance from the middle; the corners are below the horizon.
fn image(size: u32) -> Directions {
    let at = |n: u32| (f64::from(n) + 0.5) / f64::from(size) * 2.0 - 1.0;
    (0..size)
        .flat_map(|y| (0..size).map(move |x| (at(x), at(y))))
        .map(|(x, y)| direction(libm::hypot(x, y) * std::f64::consts::FRAC_PI_2, libm::atan2(y, x)))
        .collect()
}

fn measured(c: &mut Criterion) {
    let open = || {
        std::env::var_os("BRDFIT_MERL")
            .map_or_else(|| made(Dimensions::HALF_TURN), |path| MerlFile::open(path.as_ref()).expect("a MERL file"))
    };
    let mut group = c.benchmark_group("measured");
    group.sample_size(20);
    let file = open();
    group.bench_function("make", |b| b.iter(|| black_box(MeasuredBrdf::new(&file, SamplePosition::Centre))));
    let model = MeasuredBrdf::new(&file, SamplePosition::Centre).expect("valid cells");
    let i = direction(0.7, 0.0);
    for size in [64, 256, 1024] {
        let o = image(size);
        let lobes = model.towards(&o);
        let mut values = [0, 1, 2].map(|_| vec![0.0; o.len()]);
        group.throughput(Throughput::Elements(o.len() as u64));
        group.bench_function(format!("lobe of {size} x {size}"), |b| {
            b.iter(|| {
                let [r, g, b] = &mut values;
                lobes.values(&i, 0, [r, g, b]);
                black_box(&values);
            })
        });
    }
    let o = image(64);
    group.throughput(Throughput::Elements(o.len() as u64));
    group.bench_function("64 x 64 values in double precision", |b| {
        b.iter(|| (0..o.len()).map(|n| model.value(&i, &o.get(n))[1]).sum::<f64>())
    });
    let shading = model.batch();
    let o = [0.6_f32, 0.0, 0.8].map(|v| vec![v; 4096]);
    let o = o.each_ref().map(Vec::as_slice);
    let u = [0.754_877_67, 0.569_840_3]
        .map(|step| (0..4096).map(|n| (0.5 + f64::from(n) * step).fract() as f32).collect::<Vec<_>>());
    let mut i = [0, 1, 2].map(|_| vec![0.0; 4096]);
    group.bench_function("shading: sample", |b| {
        b.iter(|| shading.sample(black_box(o), u.each_ref().map(Vec::as_slice), i.each_mut().map(Vec::as_mut_slice)))
    });
    let (mut values, mut density) = ([0, 1, 2].map(|_| vec![0.0; 4096]), vec![0.0; 4096]);
    let i = i.each_ref().map(Vec::as_slice);
    group.bench_function("shading: evaluate", |b| {
        b.iter(|| shading.evaluate(black_box(i), o, values.each_mut().map(Vec::as_mut_slice), &mut density))
    });
    group.finish();
}

criterion_group!(benches, measured);
criterion_main!(benches);
