//! Local bandwidth of signals of which it is known, and what must hold for every signal.

use std::f64::consts::{PI, TAU};

use brdfit_bandwidth::{AngularMap, Border, Estimator, Rule, position_to_direction, samples_per_unit};
use proptest::prelude::*;

/// Kronecker's sequence of the golden ratio of dimension three: deterministic, even.
fn points(count: u32) -> impl Iterator<Item = [f64; 3]> {
    const STEPS: [f64; 3] = [0.819_172_513_396_164_4, 0.671_043_606_703_789_3, 0.549_700_477_901_970_3];
    (1..=count).map(|n| STEPS.map(|step| (0.5 + f64::from(n) * step).fract()))
}

/// log2(estimate / truth) at interior pixels of sine gratings, sorted: frequency log-uniform in 1/32 .. 0.45 cycles per pixel, every
/// orientation and phase.
fn octaves_on_gratings(estimator: &Estimator) -> Vec<f64> {
    const SIZE: usize = 256;
    let mut all = Vec::new();
    for [a, b, c] in points(100) {
        let frequency = libm::exp2(-5.0 + a * (5.0 + libm::log2(0.45)));
        let (x, y) = (frequency * libm::cos(TAU * b), frequency * libm::sin(TAU * b));
        let value = |n: usize| libm::sin(TAU * ((n % SIZE) as f64 * x + (n / SIZE) as f64 * y + c)) as f32;
        let image: Vec<f32> = (0..SIZE * SIZE).map(value).collect();
        let map = estimator.local_bandwidth(&image, SIZE, SIZE);
        for row in map.chunks(SIZE).skip(SIZE / 4).take(SIZE / 2).step_by(3) {
            let interior = row[SIZE / 4..3 * SIZE / 4].iter().step_by(3);
            all.extend(interior.map(|&found| libm::log2(f64::from(found).max(1e-9) / frequency)));
        }
    }
    all.sort_by(f64::total_cmp);
    all
}

fn quantile(sorted: &[f64], share: f64) -> f64 {
    sorted[(share * (sorted.len() - 1) as f64).round() as usize]
}

#[test]
fn gratings_read_right() {
    for reflections in [true, false] {
        let octaves = octaves_on_gratings(&Estimator { reflections, ..Estimator::default() });
        let [low, median, high] = [0.05, 0.5, 0.95].map(|share| quantile(&octaves, share));
        println!("gratings, reflections {reflections}: {median:+.3} octaves, 5 to 95 %: {low:+.3} to {high:+.3}");
        assert!(median.abs() < 0.05, "{median}");
        assert!(low > -0.65 && high < 0.4, "{low} {high}");
    }
}

#[test]
fn the_epsilon_rule_reads_high() {
    for epsilon in [0.01, 0.1] {
        let estimator = Estimator { rule: Rule::Epsilon(epsilon), reflections: false, ..Estimator::default() };
        let median = quantile(&octaves_on_gratings(&estimator), 0.5);
        println!("gratings, epsilon {epsilon}: {median:+.2} octaves");
        assert!(median > 1.0, "{median}");
    }
}

#[test]
fn constant_images_have_none() {
    for (rows, columns) in [(64, 64), (1, 1), (100, 7), (512, 1024)] {
        for value in [0.0, 1.0, 0.3, -7e8, 1.2e-12] {
            for reflections in [true, false] {
                let estimator = Estimator { reflections, ..Estimator::default() };
                let map = estimator.local_bandwidth(&vec![value; rows * columns], rows, columns);
                assert!(map.len() == rows * columns && map.iter().all(|&texel| texel == 0.0), "{value}");
            }
        }
    }
}

/// Images of noise, more or less of it, with an edge and a slope.
fn image(rows: usize, columns: usize) -> impl Strategy<Value = Vec<f32>> {
    let noise = prop::collection::vec(-1.0_f32..1.0, rows * columns);
    (noise, 0.2_f32..1.0, 0..columns).prop_map(move |(mut image, share, edge)| {
        for (n, value) in image.iter_mut().enumerate() {
            *value = *value * share * share + if n % columns < edge { 1.0 } else { 0.01 * (n / columns) as f32 };
        }
        image
    })
}

fn mirrored(image: &[f32], columns: usize, left_right: bool) -> Vec<f32> {
    if left_right {
        image.chunks(columns).flat_map(|row| row.iter().rev()).copied().collect()
    } else {
        image.chunks(columns).rev().flatten().copied().collect()
    }
}

/// Without the threshold under which bands do not count, at which a rounding can make the difference.
const CONTINUOUS: Estimator =
    Estimator { rule: Rule::Percentile(95.0), delta: 0.0, reflections: true, border: Border::Reflect };

/// That two maps agree but for rounding: to 1e-5 in 999 of 1000 pixels, to 1e-3 in those where the spectrum is nearly empty about
/// the percentile.
fn agree(a: &[f32], b: &[f32]) -> bool {
    let mut errors: Vec<f32> = a.iter().zip(b).map(|(a, b)| (a / b - 1.0).abs()).collect();
    errors.sort_by(f32::total_cmp);
    errors[errors.len() * 999 / 1000] < 1e-5 && errors[errors.len() - 1] < 1e-3
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn powers_of_two_change_nothing(image in image(32, 64), exponent in -20..20_i32) {
        let estimator = Estimator::default();
        let scaled: Vec<f32> = image.iter().map(|x| x * 2.0_f32.powi(exponent)).collect();
        prop_assert_eq!(estimator.local_bandwidth(&image, 32, 64), estimator.local_bandwidth(&scaled, 32, 64));
    }

    #[test]
    fn scale_and_sign_change_nothing(image in image(32, 64), scale in -9.0_f32..9.0) {
        prop_assume!(scale.abs() > 1e-3);
        let scaled: Vec<f32> = image.iter().map(|x| x * scale).collect();
        prop_assert!(agree(&CONTINUOUS.local_bandwidth(&image, 32, 64), &CONTINUOUS.local_bandwidth(&scaled, 32, 64)));
    }

    #[test]
    fn mirrored_images_have_mirrored_maps(image in image(32, 64), left_right: bool, periodic: bool) {
        let border = if periodic { Border::Periodic } else { Border::Reflect };
        let estimator = Estimator { border, ..Estimator::default() };
        let ours = estimator.local_bandwidth(&mirrored(&image, 64, left_right), 32, 64);
        prop_assert_eq!(ours, mirrored(&estimator.local_bandwidth(&image, 32, 64), 64, left_right));
    }

    #[test]
    fn maps_are_bounded(image in image(16, 16), reflections: bool) {
        let estimator = Estimator { reflections, ..Estimator::default() };
        let largest = (estimator.kappa() * 0.5_f64.sqrt()) as f32 * 1.000_001;
        let map = estimator.local_bandwidth(&image, 16, 16);
        prop_assert!(map.iter().all(|texel| (0.0..=largest).contains(texel)));
    }
}

fn chirp(rows: usize, columns: usize) -> Vec<f32> {
    let value = |r: f64, c: f64| 1.5 + libm::sin(c * (0.1 + 0.004 * c) + 0.3 * r);
    (0..rows * columns).map(|n| value((n / columns) as f64, (n % columns) as f64) as f32).collect()
}

#[test]
fn other_sides_are_extended_as_the_border_says() {
    let (rows, columns) = (100, 37);
    let image = chirp(rows, columns);
    for border in [Border::Reflect, Border::Periodic] {
        let place = |n: usize, count: usize| match border {
            Border::Reflect if n >= count => 2 * count - 1 - n,
            _ => n % count,
        };
        let extended: Vec<f32> =
            (0..128 * 64).map(|n| image[place(n / 64, rows) * columns + place(n % 64, columns)]).collect();
        let estimator = Estimator { border, ..Estimator::default() };
        let whole = estimator.local_bandwidth(&extended, 128, 64);
        let cropped: Vec<f32> = whole.chunks(64).take(rows).flat_map(|row| &row[..columns]).copied().collect();
        assert_eq!(estimator.local_bandwidth(&image, rows, columns), cropped);
    }
}

#[test]
fn the_number_of_threads_changes_nothing() {
    let image = chirp(512, 1024);
    let maps = [1, 3].map(|threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| Estimator::default().local_bandwidth(&image, 512, 1024))
    });
    assert_eq!(maps[0], maps[1]);
}

/// A lamp of constant brightness varies at its edges alone, where it goes dark.
#[test]
fn an_area_light_has_bandwidth_at_its_edges() {
    const SIDE: usize = 128;
    let light = vec![3.0_f32; SIDE * SIDE];
    let map = Estimator::default().bandwidth_in_the_dark(&light, SIDE, SIDE);
    let at = |row: usize, column: usize| map[row * SIDE + column];
    let edges = [at(0, SIDE / 2), at(SIDE - 1, SIDE / 2), at(SIDE / 2, 0), at(SIDE / 2, SIDE - 1)];
    let inside = (SIDE / 4..3 * SIDE / 4).map(|n| at(n, SIDE / 2).max(at(SIDE / 2, n))).fold(0.0, f32::max);
    println!("area light: {edges:.3?} at the edges, at most {inside:.4} inside, cycles per sample");
    assert!(edges.iter().all(|&edge| edge > 0.1), "{edges:?}");
    assert!(inside < 0.02, "{inside}");
    // an oblong one too, of no particular size
    let (rows, columns) = (70, 200);
    let map = Estimator::default().bandwidth_in_the_dark(&vec![1.0; rows * columns], rows, columns);
    assert_eq!(map.len(), rows * columns);
    assert!(map[35 * columns] > 5.0 * map[35 * columns + 100], "{} {}", map[35 * columns], map[35 * columns + 100]);
}

#[test]
fn samples_per_unit_of_known_mappings() {
    let close = |found: f64, expected: f64| assert!((found / expected - 1.0).abs() < 1e-9, "{found} {expected}");
    // a texture on a plane: 4 samples per metre along one side, 9 along the other, however it lies and is sheared
    close(samples_per_unit([0.25, 0.0, 0.0], [0.0, 1.0 / 9.0, 0.0]), 6.0);
    close(samples_per_unit([0.0, 0.2, 0.15], [1.0 / 9.0, 0.0, 0.0]), 6.0);
    close(samples_per_unit([0.25, 0.0, 0.0], [0.7, 1.0 / 9.0, 0.0]), 6.0);
    // a latitude-longitude map of 512 x 256 samples at theta: 256/pi samples per radian down, over sin theta across
    let (theta, phi) = (1.1_f64, 0.4_f64);
    let (st, ct) = (libm::sin(theta), libm::cos(theta));
    let (sp, cp) = (libm::sin(phi), libm::cos(phi));
    let along_row = [-st * sp, st * cp, 0.0].map(|x| x * TAU / 512.0);
    let along_column = [ct * cp, ct * sp, -st].map(|x| x * PI / 256.0);
    close(samples_per_unit(along_row, along_column), 256.0 / PI / st.sqrt());
}

#[test]
fn the_angular_map_has_the_samples_per_radian_of_its_derivatives() {
    let (map, h) = (AngularMap::new(128), 1e-5);
    for (row, column) in [(64, 64), (20, 70), (100, 30), (63, 2)] {
        let [u, v] = map.position(row, column);
        let slope = |du: f64, dv: f64| {
            let ends = [1.0, -1.0].map(|sign| position_to_direction([u + sign * h * du, v + sign * h * dv]));
            let by_sample = (ends[0] - ends[1]) / (2.0 * h) * (2.0 / 128.0);
            [by_sample.x, by_sample.y, by_sample.z]
        };
        let expected = samples_per_unit(slope(1.0, 0.0), slope(0.0, 1.0));
        assert!((map.cycles_per_radian(row, column) / expected - 1.0).abs() < 1e-8);
    }
}
