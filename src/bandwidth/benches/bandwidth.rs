//! Time of the wavelet transform, of a map of local bandwidths, and of single lobes.
//!
//! `cargo bench -p brdfit-bandwidth`; lobes on one thread, the rest as the library does it.

use std::hint::black_box;

use brdfit_bandwidth::{Border, Estimator, LobeEstimator, LobeGrid, LobeMemory, LobeOptions, Pyramid};
use brdfit_brdf::{Brdf, SgdMaterial, SgdParameters, direction};
use brdfit_measured::{Dimensions, Grid, MeasuredBrdf, MerlFile, SamplePosition};
use criterion::{Criterion, Throughput, criterion_group, criterion_main};

/// A wave that gets shorter from the left to the right.
fn chirp(size: usize) -> Vec<f32> {
    let at = |n: usize| (n % size) as f32 / size as f32;
    (0..size * size).map(|n| libm::sinf(at(n) * (10.0 + 150.0 * at(n)) + at(n / size))).collect()
}

fn signals(criterion: &mut Criterion) {
    for size in [256, 1024] {
        let image = chirp(size);
        let mut pyramid = Pyramid::default();
        let mut group = criterion.benchmark_group("analyse");
        group.throughput(Throughput::Elements(image.len() as u64));
        group.bench_function(format!("{size} x {size}, single precision"), |bencher| {
            bencher.iter(|| pyramid.analyse(black_box(&image), size, size, Border::Reflect));
        });
        group.finish();
    }
    let image = chirp(512);
    let mut group = criterion.benchmark_group("local bandwidth");
    group.sample_size(20).throughput(Throughput::Elements(image.len() as u64));
    group.bench_function("512 x 512", |bencher| {
        bencher.iter(|| Estimator::default().local_bandwidth(black_box(&image), 512, 512));
    });
    group.finish();
}

/// An SGD material of which the channels differ.
fn material(alpha: f64, p: f64) -> SgdMaterial {
    let channel = |c: f64| SgdParameters { rho_d: 0.1, rho_s: 0.4 * c, alpha: alpha * c, p, f0: 0.3, f1: 0.05 };
    SgdMaterial::new([channel(1.0), channel(1.1), channel(1.2)]).expect("inside of the domain")
}

/// A glossy material on a MERL grid.
fn measured() -> MeasuredBrdf {
    let (dimensions, position) = (Dimensions::HALF_TURN, SamplePosition::Centre);
    let grid = Grid::new(dimensions, position);
    let file = MerlFile::from_fn("made", dimensions, |channel, h, d, phi| {
        if !grid.usable().contains(dimensions.index(h, d, phi)) {
            return -1.0;
        }
        let tan = libm::tan(dimensions.theta_h_sample(h, position)) / 0.1;
        0.1 + (channel + 1) as f64 * libm::exp(-tan * tan)
    });
    MeasuredBrdf::new(&file.expect("finite values"), position).expect("valid cells")
}

fn lobes(criterion: &mut Criterion) {
    let (rough, sharp, measured) = (material(0.3, 1.0), material(7e-5, 0.3), measured());
    let materials: [(&str, &dyn Brdf); 3] = [("rough", &rough), ("sharp", &sharp), ("measured", &measured)];
    let (grid, i) = (LobeGrid::default(), direction(0.7, 0.0));
    let mut group = criterion.benchmark_group("lobe");
    group.sample_size(20);
    for (name, brdf) in materials {
        let lobes = LobeEstimator::new(brdf, &grid, true, LobeOptions::default());
        let mut memory = LobeMemory::default();
        let resolution = lobes.estimate(&i, &mut memory).resolution;
        group.bench_function(format!("{name}, {resolution} x {resolution}"), |bencher| {
            bencher.iter(|| lobes.estimate(black_box(&i), &mut memory));
        });
    }
    group.finish();
}

criterion_group!(benches, signals, lobes);
criterion_main!(benches);
