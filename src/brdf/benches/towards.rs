//! Time per direction of preparing and of evaluating the lobes of an SGD material, all three channels together.

use brdfit_brdf::{Brdf, Directions, SgdMaterial, SgdParameters, direction};
use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use std::f64::consts::FRAC_PI_2;
use std::hint::black_box;

/// One hemisphere in the angular map: rows along the azimuth, columns along theta.
fn hemisphere(side: u32) -> Directions {
    (0..side * side)
        .map(|n| {
            let (row, column) = (f64::from(n / side), f64::from(n % side));
            direction((column + 0.5) / f64::from(side) * FRAC_PI_2, row / f64::from(side) * std::f64::consts::PI)
        })
        .collect()
}

fn towards(criterion: &mut Criterion) {
    let o = hemisphere(180);
    let i = direction(0.7, 0.0);
    for (name, alpha) in [("sharp", 1e-4), ("glossy", 1e-2), ("matte", 0.3)] {
        let channel = |p| SgdParameters { rho_d: 0.1, rho_s: 0.4, alpha, p, f0: 0.3, f1: 0.05 };
        let material = SgdMaterial::new([channel(0.4), channel(0.6), channel(0.8)]).expect("inside of the domain");
        let mut group = criterion.benchmark_group(name);
        group.throughput(Throughput::Elements(o.len() as u64));
        group.bench_function("prepare", |bencher| bencher.iter(|| drop(material.towards(black_box(&o)))));
        let lobes = material.towards(&o);
        let mut values = [0; 3].map(|_| vec![0.0; o.len()]);
        group.bench_function("evaluate", |bencher| {
            bencher.iter(|| lobes.values(black_box(&i), 0, values.each_mut().map(|channel| channel.as_mut_slice())));
        });
        group.finish();
    }
}

criterion_group!(benches, towards);
criterion_main!(benches);
