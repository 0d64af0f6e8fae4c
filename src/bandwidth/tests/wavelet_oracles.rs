//! The transform and the local bandwidth against PyWavelets: `data-fixtures/wavelet.json`, whose description has the conventions.

use std::path::Path;

use brdfit_bandwidth::{Bands, Border, Estimator, Pyramid, Real, analyse, synthesise};
use serde::Deserialize;

type Line = Vec<f64>;
type Image = Vec<Line>;

#[derive(Deserialize)]
struct Fixture {
    lines: Vec<(String, usize, String, Line, Line, Line)>,
    pyramid: Image,
    levels: Vec<(String, usize, String, Image)>,
    signals: Vec<(String, Image)>,
    bandwidth: Vec<Bandwidth>,
}

#[derive(Deserialize)]
struct Bandwidth {
    name: String,
    border: String,
    reflections: String,
    map: Image,
    probes: Vec<Line>,
}

fn fixture() -> Fixture {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../data-fixtures/wavelet.json");
    serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap()
}

fn border(name: &str) -> Border {
    match name {
        "periodic" => Border::Periodic,
        "symmetric" => Border::Reflect,
        other => panic!("{other}"),
    }
}

const BORDERS: [Border; 2] = [Border::Periodic, Border::Reflect];

/// A precision, with the largest deviation that is allowed in it in units of the largest input.
trait Precision: Real + Into<f64> {
    const BAR: f64;

    fn all(values: &[f64]) -> Vec<Self> {
        values.iter().map(|&value| Self::from_f64(value)).collect()
    }
}

impl Precision for f32 {
    const BAR: f64 = 1e-5;
}

impl Precision for f64 {
    const BAR: f64 = 1e-12;
}

fn largest<T: Precision>(values: &[T]) -> f64 {
    values.iter().map(|&value| value.into().abs()).fold(0.0, f64::max)
}

fn distance<T: Precision, U: Precision>(ours: &[T], theirs: &[U]) -> f64 {
    assert_eq!(ours.len(), theirs.len());
    ours.iter().zip(theirs).map(|(&a, &b)| (a.into() - b.into()).abs()).fold(0.0, f64::max)
}

fn assert_within<T: Precision>(what: &str, found: f64) {
    println!("{what}: largest deviation {found:.1e} of the largest input, {:.0e} allowed", T::BAR);
    assert!(found < T::BAR, "{what}: {found:e}");
}

fn lines<T: Precision>() {
    let [mut there, mut back]: [f64; 2] = [0.0; 2];
    for (_, n, name, x, low, high) in fixture().lines {
        let (x, scale) = (T::all(&x), largest(&x));
        let (mut a, mut b) = (vec![T::default(); n / 2], vec![T::default(); n / 2]);
        analyse(&x, border(&name), &mut a, &mut b, &mut vec![T::default(); n + 2]);
        there = there.max(distance(&a, &low).max(distance(&b, &high)) / scale);
        let mut rebuilt = vec![T::default(); n];
        synthesise(&a, &b, border(&name), &mut rebuilt);
        back = back.max(distance(&rebuilt, &x) / scale);
    }
    assert_within::<T>("one dimension, analysis", there);
    assert_within::<T>("one dimension, reconstruction", back);
}

fn pyramid<T: Precision>() {
    let fixture = fixture();
    let image = T::all(&fixture.pyramid.concat());
    let [mut there, mut back]: [f64; 2] = [0.0; 2];
    for way in BORDERS {
        let mut pyramid = Pyramid::default();
        pyramid.analyse(&image, 32, 32, way);
        assert_eq!(pyramid.levels.len(), 3);
        let mut compared = 0;
        for (_, level, band, theirs) in fixture.levels.iter().filter(|row| border(&row.0) == way) {
            let Bands { rows, columns, horizontal, vertical, diagonal } = &pyramid.levels[level - 1];
            assert_eq!((*rows, *columns), (32 >> level, 32 >> level));
            let ours = match band.as_str() {
                "H" => horizontal,
                "V" => vertical,
                "D" => diagonal,
                "A" => &pyramid.approximation,
                other => panic!("{other}"),
            };
            there = there.max(distance(ours, &theirs.concat()) / largest(&image));
            compared += 1;
        }
        assert_eq!(compared, 10);
        back = back.max(distance(&pyramid.synthesise(way), &image) / largest(&image));
    }
    assert_within::<T>("three levels in two dimensions, analysis", there);
    assert_within::<T>("three levels in two dimensions, reconstruction", back);
}

#[test]
fn one_dimension_is_that_of_pywavelets() {
    lines::<f64>();
    lines::<f32>();
}

#[test]
fn two_dimensions_are_those_of_pywavelets() {
    pyramid::<f64>();
    pyramid::<f32>();
}

/// A deterministic image without structure.
fn noise(count: usize) -> Vec<f64> {
    (0..count)
        .map(|n| (0.5 + n as f64 * 0.754_877_666_246_692_7).fract() - (n as f64 * 0.569_840_290_998_053_2).fract())
        .collect()
}

#[test]
fn every_shape_is_rebuilt() {
    for (rows, columns) in [(8, 8), (8, 64), (128, 16), (512, 1024)] {
        let image = noise(rows * columns);
        for border in BORDERS {
            let mut pyramid = Pyramid::default();
            pyramid.analyse(&image, rows, columns, border);
            assert!(distance(&pyramid.synthesise(border), &image) < 1e-13, "{rows} x {columns}");
        }
    }
}

#[test]
fn the_periodic_transform_keeps_the_energy() {
    let energy = |values: &[f64]| values.iter().map(|x| x * x).sum::<f64>();
    for (rows, columns) in [(64, 64), (16, 256)] {
        let image = noise(rows * columns);
        let mut pyramid = Pyramid::default();
        pyramid.analyse(&image, rows, columns, Border::Periodic);
        let detail: f64 =
            pyramid.levels.iter().map(|b| energy(&b.horizontal) + energy(&b.vertical) + energy(&b.diagonal)).sum();
        let ratio = (detail + energy(&pyramid.approximation)) / energy(&image);
        assert!((ratio - 1.0).abs() < 1e-13, "{ratio}");
    }
}

/// Large images are transformed by all threads and with the widest vectors: bit for bit what rows and columns one at a time give.
#[test]
fn large_images_are_rows_and_then_columns() {
    let (rows, columns) = (512, 1024);
    let image: Vec<f32> = f32::all(&noise(rows * columns));
    for border in BORDERS {
        let mut pyramid = Pyramid::default();
        pyramid.analyse(&image, rows, columns, border);
        let split = |line: &[f32]| {
            let half = line.len() / 2;
            let (mut low, mut high) = (vec![0.0; half], vec![0.0; half]);
            analyse(line, border, &mut low, &mut high, &mut vec![0.0; line.len() + 2]);
            (low, high)
        };
        let (low, high): (Vec<_>, Vec<_>) = image.chunks(columns).map(split).unzip();
        let Bands { horizontal, vertical, diagonal, .. } = &pyramid.levels[0];
        for column in [0, 1, 77, 300, 511] {
            let of = |plane: &[f32]| -> Vec<f32> { plane.chunks(columns / 2).map(|row| row[column]).collect() };
            let along = |lines: &[Vec<f32>]| split(&lines.iter().map(|line| line[column]).collect::<Vec<f32>>());
            assert_eq!(of(vertical), along(&low).1);
            assert_eq!((of(horizontal), of(diagonal)), along(&high));
        }
    }
}

/// Single precision against double: 1e-4, relative.
#[test]
fn local_bandwidths_are_those_of_pywavelets() {
    let fixture = fixture();
    let (mut worst, mut zeros) = (0.0_f64, 0);
    for Bandwidth { name, border: way, reflections, map, probes } in fixture.bandwidth {
        let signal = &fixture.signals.iter().find(|signal| signal.0 == name).unwrap().1;
        let values: Vec<f32> = signal.concat().iter().map(|&value| (value / 4096.0) as f32).collect();
        let reflections = match reflections.as_str() {
            "none" => false,
            "four" => true,
            other => panic!("{other}"),
        };
        let estimator = Estimator { reflections, border: border(&way), ..Estimator::default() };
        let ours = estimator.local_bandwidth(&values, 64, 64);
        let strided = map
            .iter()
            .zip((0..64).step_by(3))
            .flat_map(|(row, r)| row.iter().zip((0..64).step_by(3)).map(move |(&theirs, c)| (r, c, theirs)));
        let probes = probes.iter().map(|probe| (probe[0] as usize, probe[1] as usize, probe[probe.len() - 1]));
        for (r, c, theirs) in strided.chain(probes) {
            let found = f64::from(ours[r * 64 + c]);
            if theirs == 0.0 {
                assert_eq!(found, 0.0, "{name} {way} {reflections} at {r}, {c}");
                zeros += 1;
            } else {
                let error = (found / theirs - 1.0).abs();
                assert!(error < 1e-4, "{name} {way} {reflections} at {r}, {c}: {found} instead of {theirs}");
                worst = worst.max(error);
            }
        }
    }
    assert!(zeros > 0, "no pixel far from the blob");
    println!("local bandwidth: largest deviation {worst:.1e}, relative, 1e-4 allowed");
}
