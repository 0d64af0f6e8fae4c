//! Time of the full pass over a file, and of its parts.
//!
//! `BRDFIT_MERL=FILE.binary cargo bench -p brdfit-measured` times a file of your own (in the page cache after the first run);
//! without it a file is made in a temporary folder.

use std::hint::black_box;
use std::path::PathBuf;

use brdfit_measured::{Dimensions, MerlFile, SamplePosition, cosines, write_merl};
use criterion::{Criterion, criterion_group, criterion_main};
use sha2::{Digest, Sha256};

/// A file with as many missing cells as a genuine one: those below the horizon.
fn make(path: &std::path::Path) {
    let dimensions = Dimensions::HALF_TURN;
    let mut bytes = Vec::new();
    let centre = SamplePosition::Centre;
    write_merl(&mut bytes, dimensions, |channel, h, d, p| {
        let (cos_i, cos_o) = cosines(
            dimensions.theta_h_sample(h, centre),
            dimensions.theta_d_sample(d, centre),
            dimensions.phi_d_sample(p, centre),
        );
        if cos_i.min(cos_o) > 0.0 { 0.1 + channel as f64 + cos_i * cos_o } else { -1.0 }
    })
    .expect("finite values");
    std::fs::write(path, bytes).expect("a writable temporary folder");
}

fn scan(c: &mut Criterion) {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = std::env::var_os("BRDFIT_MERL").map_or_else(
        || {
            let path = folder.path().join("made.binary");
            make(&path);
            path
        },
        PathBuf::from,
    );
    let open = || MerlFile::open(&path).expect("a MERL file");
    let mut group = c.benchmark_group("file");
    group.sample_size(20);
    group.bench_function("open and scan", |b| b.iter(|| black_box(open().scan())));
    group.bench_function("open and slices", |b| b.iter(|| black_box(open().slices(SamplePosition::Edge))));
    let file = open();
    group.bench_function("scan, mapped before", |b| b.iter(|| black_box(file.scan())));
    group.bench_function("SHA-256 alone, mapped before", |b| b.iter(|| black_box(Sha256::digest(file.bytes()))));
    group.finish();
}

criterion_group!(benches, scan);
criterion_main!(benches);
