//! Time per direction of drawing and of evaluating what renderers need, on one thread, the three channels together.
//!
//! The directions that are evaluated are half drawn from the material and half from the cosine, as with light samples beside.

use brdfit_brdf::{Brdf, GgxMaterial, Lambert, SgdMaterial, SgdParameters, direction};
use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use std::hint::black_box;

const COUNT: usize = 4096;

fn batch(criterion: &mut Criterion) {
    let sgd = |alpha| {
        let channel = |p| SgdParameters { rho_d: 0.1, rho_s: 0.4, alpha, p, f0: 0.3, f1: 0.05 };
        SgdMaterial::new([channel(0.4), channel(0.6), channel(0.8)]).expect("inside of the domain")
    };
    let ggx = GgxMaterial::without_fresnel([0.1; 3], [0.4; 3], 0.1).expect("inside of the domain");
    let (sharp, broad) = (sgd(1e-4), sgd(0.1));
    for (name, model) in [("sgd sharp", &sharp as &dyn Brdf), ("sgd broad", &broad), ("ggx", &ggx)] {
        let mut group = criterion.benchmark_group(name);
        group.bench_function("prepare", |bencher| bencher.iter(|| drop(model.batch())));
        group.throughput(Throughput::Elements(COUNT as u64));
        let batch = model.batch();
        let eye = direction(0.7, 0.3);
        let o = [eye.x, eye.y, eye.z].map(|v| vec![v as f32; COUNT]);
        let o = o.each_ref().map(Vec::as_slice);
        let u = [0.754_877_67, 0.569_840_3]
            .map(|step| (0..COUNT).map(|n| (0.5 + n as f64 * step).fract() as f32).collect::<Vec<_>>());
        let u = u.each_ref().map(Vec::as_slice);
        let mut i = [0; 3].map(|_| vec![0.0; COUNT]);
        group.bench_function("sample", |bencher| {
            bencher.iter(|| batch.sample(black_box(o), u, i.each_mut().map(Vec::as_mut_slice)));
        });
        let cosine = Lambert { albedo: [1.0; 3] };
        let mut lights = [0; 3].map(|_| vec![0.0; COUNT]);
        cosine.batch().sample(o, u, lights.each_mut().map(Vec::as_mut_slice));
        for (i, lights) in i.iter_mut().zip(&lights) {
            i[COUNT / 2..].copy_from_slice(&lights[COUNT / 2..]);
        }
        let i = i.each_ref().map(Vec::as_slice);
        let (mut values, mut density) = ([0; 3].map(|_| vec![0.0; COUNT]), vec![0.0; COUNT]);
        group.bench_function("evaluate", |bencher| {
            bencher.iter(|| batch.evaluate(black_box(i), o, values.each_mut().map(Vec::as_mut_slice), &mut density));
        });
        group.finish();
    }
}

criterion_group!(benches, batch);
criterion_main!(benches);
