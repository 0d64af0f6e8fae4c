//! RGL files: against an independent reader, an analytic material, and the properties of any BRDF.

#[path = "../../brdf/tests/checks/mod.rs"]
mod checks;
mod data;

use std::f64::consts::{FRAC_PI_2, TAU};
use std::path::{Path, PathBuf};

use brdfit_brdf::{Brdf, Direction, Directions, HalfDifference, Symmetry, direction};
use brdfit_measured::{CHANNELS, Dimensions, HealthChecks, Info, Reason, SamplePosition, Summary};
use checks::{check_draws, evaluated, furnace};
use serde::Deserialize;
use sha2::{Digest, Sha256};

/// The roughness and the reflectance at normal incidence of `ggx_rgb.bsdf`.
const ALPHA: f64 = 0.3;
const F0: [f64; CHANNELS] = [0.9, 0.5, 0.2];

fn fixture(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../data-fixtures").join(name)
}

fn brdf(path: &Path) -> Box<dyn Brdf> {
    brdfit_measured::open(path, None).and_then(|measurement| measurement.brdf()).unwrap()
}

fn ggx() -> Box<dyn Brdf> {
    brdf(&fixture("ggx_rgb.bsdf"))
}

fn summary(path: &Path) -> Summary {
    match brdfit_measured::open(path, None).unwrap().info(&HealthChecks::default()).info {
        Info::Summary(summary) => *summary,
        Info::Cells(_) => panic!("{} has no cells", path.display()),
    }
}

/// GGX with Smith's masking and Schlick's Fresnel term, as the writer tabulates it: Walter et al. 2007, equations 33 and 34.
fn analytic(i: &Direction, o: &Direction) -> [f64; CHANNELS] {
    let h = (i + o).normalize();
    let square = ALPHA * ALPHA;
    let d = square / (std::f64::consts::PI * ((square - 1.0) * h.z * h.z + 1.0).powi(2));
    let g1 = |cos: f64| 2.0 / (1.0 + (1.0 + square * (1.0 / (cos * cos) - 1.0)).sqrt());
    let lobe = d * g1(i.z) * g1(o.z) / (4.0 * i.z * o.z);
    F0.map(|f0| lobe * (f0 + (1.0 - f0) * (1.0 - i.dot(&h)).powi(5)))
}

/// Pairs of directions up to `steepest` degrees, evenly spread (Kronecker's sequence).
fn pairs(count: u32, steepest: f64) -> impl Iterator<Item = (Direction, Direction)> {
    (0..count).map(move |n| {
        let [a, b, c] = [0.819_172_513, 0.671_043_606, 0.549_700_477].map(|step| (0.5 + f64::from(n) * step).fract());
        let theta = |x: f64| (steepest * x).to_radians();
        (direction(theta(a), 1.0), direction(theta(b), 1.0 + TAU * c))
    })
}

#[test]
fn values_are_those_of_the_independent_reader() {
    #[derive(Deserialize)]
    struct File {
        name: String,
        sha256: String,
        rows: Vec<[f64; 9]>,
    }
    #[derive(Deserialize)]
    struct Vectors {
        files: Vec<File>,
    }
    let vectors: Vectors = serde_json::from_slice(&std::fs::read(fixture("rgl.json")).unwrap()).unwrap();
    assert_eq!(vectors.files.len(), 7);
    let data = data::genuine();
    let places = |name: &str| [Some(fixture(name)), data.as_ref().map(|folder| folder.join("measured").join(name))];
    for File { name, sha256, rows } in vectors.files {
        let Some(path) = places(&name).into_iter().flatten().find(|path| path.exists()) else { continue };
        let hash = Sha256::digest(std::fs::read(&path).unwrap());
        assert_eq!(hash.iter().map(|byte| format!("{byte:02x}")).collect::<String>(), sha256, "{name}");
        let brdf = brdf(&path);
        let mut worst: f64 = 0.0;
        for [ix, iy, iz, ox, oy, oz, rgb @ ..] in rows {
            let found = brdf.value(&Direction::new(ix, iy, iz), &Direction::new(ox, oy, oz));
            for (found, expected) in found.into_iter().zip(rgb) {
                worst = worst.max((found - expected).abs() / expected.abs().max(1e-4));
            }
        }
        println!("{name}: largest relative difference from the independent reader {worst:.1e}");
        assert!(worst < 2e-6, "{name}: {worst}");
    }
}

/// The tables of `ggx_rgb.bsdf` are coarse: 16 theta_i, 32 x 32 half vectors, 16 x 16 colours.
#[test]
fn an_analytic_material_comes_back() {
    let (brdf, mut errors) = (ggx(), Vec::new());
    for (i, o) in pairs(5000, 60.0) {
        for (found, exact) in brdf.value(&i, &o).into_iter().zip(analytic(&i, &o)) {
            errors.push((found / exact - 1.0).abs());
        }
    }
    errors.sort_by(f64::total_cmp);
    let [median, most, worst] = [500, 990, 999].map(|share| errors[errors.len() * share / 1000]);
    println!("GGX up to 60 degrees: median {median:.1e}, 99 % {most:.1e}, 99.9 % {worst:.1e}");
    assert!(median < 5e-4 && most < 0.02 && worst < 0.08, "{median} {most} {worst}");
}

#[test]
fn the_material_is_isotropic_and_black_below_the_horizon() {
    let brdf = ggx();
    assert_eq!(brdf.symmetry(), Symmetry::Isotropic);
    for (i, o) in pairs(300, 85.0) {
        let turned = |v: &Direction| direction(libm::acos(v.z), libm::atan2(v.y, v.x) + 2.0);
        let (here, there) = (brdf.value(&i, &o), brdf.value(&turned(&i), &turned(&o)));
        assert!((here[0] / there[0] - 1.0).abs() < 1e-9, "{here:?} {there:?}");
        let below = Direction::new(o.x, o.y, -o.z);
        assert_eq!((brdf.value(&i, &below), brdf.value(&below, &i)), ([0.0; 3], [0.0; 3]));
        assert_eq!((brdf.pdf(&i, &below), brdf.pdf(&below, &i)), (0.0, 0.0));
        assert!(brdf.pdf(&i, &o) > 0.0);
    }
}

/// Values of both batch evaluations against those in double precision.
#[test]
fn batches_evaluate_the_same() {
    let data = data::folder();
    let names =
        ["chm_mint", "cc_ibiza_sunset", "paper_white", "vch_silk_blue"].map(|word| format!("measured/{word}_rgb.bsdf"));
    let measured = data.iter().flat_map(|folder| names.iter().map(|name| folder.join(name)));
    for path in std::iter::once(fixture("ggx_rgb.bsdf")).chain(measured) {
        let (brdf, mut errors) = (brdf(&path), Vec::new());
        let (i, o): (Vec<Direction>, Vec<Direction>) = pairs(4000, 85.0).unzip();
        let components =
            |all: &[Direction]| [0, 1, 2].map(|n: usize| all.iter().map(|v| v[n] as f32).collect::<Vec<f32>>());
        let (values, density) = evaluated(&*brdf.batch(), &components(&i), &components(&o));
        assert!(density.iter().all(|&density| density > 0.0));
        let directions: Directions = o.iter().copied().collect();
        let lobes = brdf.towards(&directions);
        for n in 0..i.len() {
            let exact = brdf.value(&i[n], &directions.get(n));
            let mut one = [[0.0_f32; 1]; 3];
            lobes.values(&i[n], n, one.each_mut().map(<[f32; 1]>::as_mut_slice));
            let scale = exact.iter().fold(1e-3, |largest: f64, value| largest.max(value.abs()));
            for channel in 0..CHANNELS {
                errors.push((f64::from(one[channel][0]) - exact[channel]).abs() / scale);
                errors.push((f64::from(values[channel][n]) - exact[channel]).abs() / scale);
            }
        }
        errors.sort_by(f64::total_cmp);
        let [median, most, worst] =
            [500, 999, 1000].map(|share| errors[(errors.len() * share / 1000).min(errors.len() - 1)]);
        println!("{}: single precision: median {median:.1e}, 99.9 % {most:.1e}, all {worst:.1e}", path.display());
        assert!(median < 3e-6 && most < 1e-3 && worst < 0.02, "{}: {median} {most} {worst}", path.display());
    }
}

#[test]
fn draws_follow_the_density() {
    check_draws("GGX table", &*ggx().batch());
    let Some(data) = data::folder() else { return };
    check_draws("satin", &*brdf(&data.join("measured/satin_rosaline_rgb.bsdf")).batch());
}

/// The paper's sampler in double precision: counts in boxes of theta_o and phi_o against the integral of the density.
#[test]
fn samples_fall_as_often_as_the_density_says() {
    const BOXES: [usize; 2] = [12, 12];
    const COUNT: usize = 100_000;
    let place = |o: &Direction| {
        let azimuth = libm::atan2(o.y, o.x) / TAU + 0.5;
        let at = |x: f64, n: usize| ((x * n as f64) as usize).min(n - 1);
        at(libm::acos(o.z.clamp(-1.0, 1.0)) / FRAC_PI_2, BOXES[0]) * BOXES[1] + at(azimuth, BOXES[1])
    };
    let brdf = ggx();
    for theta_i in [0.4, 1.1] {
        let i = direction(theta_i, 0.7);
        let (mut counts, mut expected, mut state) = (vec![0.0; 144], vec![0.0; 144], 1_u64);
        let mut random = || {
            // SplitMix64 (Steele et al. 2014)
            state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
            let z = (state ^ (state >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
            let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
            ((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
        };
        for _ in 0..COUNT {
            if let Some(o) = brdf.sample(&i, [random(), random(), random()]) {
                counts[place(&o)] += 1.0;
            }
        }
        let steps = 600;
        for (a, b) in (0..steps).flat_map(|a| (0..steps).map(move |b| (a, b))) {
            let theta = (f64::from(a) + 0.5) / f64::from(steps) * FRAC_PI_2;
            let o = direction(theta, (f64::from(b) + 0.5) / f64::from(steps) * TAU);
            let solid_angle = libm::sin(theta) * FRAC_PI_2 * TAU / f64::from(steps * steps);
            expected[place(&o)] += brdf.pdf(&i, &o) * solid_angle * COUNT as f64;
        }
        let whole = expected.iter().sum::<f64>() / COUNT as f64;
        let kept: Vec<(f64, f64)> = counts.into_iter().zip(expected).filter(|pair| pair.1 > 20.0).collect();
        let square: f64 = kept.iter().map(|(count, mean)| (count - mean).powi(2) / mean).sum();
        let freedom = kept.len() as f64;
        // Wilson and Hilferty 1931
        let deviate = ((square / freedom).cbrt() - (1.0 - 2.0 / (9.0 * freedom))) / (2.0 / (9.0 * freedom)).sqrt();
        println!(
            "theta_i {theta_i}: chi-square {square:.0} in {freedom} boxes, deviate {deviate:.2}, integral {whole:.4}"
        );
        assert!(deviate < 4.0 && (0.5..1.001).contains(&whole), "{theta_i}: {deviate} {whole}");
    }
}

/// The directional albedo by samples is that by an even grid of outgoing directions.
#[test]
fn samples_weigh_as_much_as_they_stand_for() {
    let brdf = ggx();
    for theta_i in [0.3, 1.0] {
        let i = direction(theta_i, 0.5);
        let (mut sampled, count) = (0.0, 40_000);
        for n in 0..count {
            let u = [0.819_172_513, 0.671_043_606, 0.549_700_477].map(|step| (0.5 + f64::from(n) * step).fract());
            if let Some(o) = brdf.sample(&i, u) {
                sampled += brdf.value(&i, &o)[0] * o.z / brdf.pdf(&i, &o) / f64::from(count);
            }
        }
        let (mut summed, mut incoming, steps) = (0.0, 0.0, 400);
        for (a, b) in (0..steps).flat_map(|a| (0..steps).map(move |b| (a, b))) {
            let theta = (f64::from(a) + 0.5) / f64::from(steps) * FRAC_PI_2;
            let o = direction(theta, (f64::from(b) + 0.5) / f64::from(steps) * TAU);
            let solid_angle = libm::sin(theta) * FRAC_PI_2 * TAU / f64::from(steps * steps);
            summed += brdf.value(&i, &o)[0] * o.z * solid_angle;
            incoming += brdf.value(&o, &i)[0] * o.z * solid_angle;
        }
        let shaded = furnace(&*brdf.batch(), theta_i, 40_000).0[0];
        println!("{theta_i}: albedo {summed:.5} by summation, {sampled:.5} by samples");
        println!("{theta_i}: under uniform light {incoming:.5} by summation, {shaded:.5} by samples");
        assert!((sampled / summed - 1.0).abs() < 2e-3, "{theta_i}: {sampled} {summed}");
        assert!((shaded / incoming - 1.0).abs() < 5e-3, "{theta_i}: {shaded} {incoming}");
    }
}

/// Slices and cells hold the mean of both orders at the centres, never negative.
#[test]
fn slices_and_cells_are_reciprocal() {
    let measurement = brdfit_measured::open(&fixture("ggx_rgb.bsdf"), Some(SamplePosition::Centre)).unwrap();
    let (brdf, centre, d) = (measurement.brdf().unwrap(), SamplePosition::Centre, Dimensions::HALF_TURN);
    assert_eq!((measurement.dimensions(), measurement.source().sample_position), (d, centre));
    let at = |h: usize, t: usize, p: usize| {
        let angles = HalfDifference {
            theta_h: d.theta_h_sample(h, centre),
            theta_d: d.theta_d_sample(t, centre),
            phi_d: d.phi_d_sample(p, centre),
        };
        let (i, o) = angles.to_directions();
        let (there, back) = (brdf.value(&i, &o), brdf.value(&o, &i));
        [0, 1, 2].map(|c: usize| f64::midpoint(there[c].max(0.0), back[c].max(0.0)))
    };
    let (cells, survey) = (measurement.cells().unwrap(), measurement.survey(false).unwrap());
    let mut checked = 0;
    for cell in (0..d.cells()).step_by(6007) {
        let (h, t, p) = d.bins(cell);
        for (c, expected) in at(h, t, p).into_iter().enumerate() {
            if survey.valid.contains(cell) {
                assert!((cells.value(c, cell) - expected).abs() <= 1e-12 * expected, "{h} {t} {p}");
                checked += 1;
            } else {
                assert_eq!(cells.value(c, cell), -1.0);
            }
        }
    }
    assert!(checked > 400 && survey.valid.count() == 1_096_216, "{checked} {}", survey.valid.count());
    let slices = measurement.slices();
    assert_eq!(slices.position, centre);
    let row: Vec<f64> = (0..180).map(|p| at(12, 0, p)[1]).collect();
    let mean = row.iter().sum::<f64>() / 180.0;
    assert!((slices.measured_h[1][12].unwrap() / mean - 1.0).abs() < 1e-12);
    assert!(slices.measured_d[2].iter().all(Option::is_some));
}

#[test]
fn another_sample_position_is_refused() {
    let refused = brdfit_measured::open(&fixture("ggx_rgb.bsdf"), Some(SamplePosition::Edge)).unwrap_err();
    assert!(matches!(refused.reason(), Reason::SamplePosition { .. }) && refused.is_invalid_input(), "{refused}");
}

#[test]
fn the_summary_says_what_is_in_the_file() {
    let summary = summary(&fixture("ggx_rgb.bsdf"));
    assert_eq!((summary.name.as_str(), summary.format.as_str()), ("ggx_rgb.bsdf", "rgl"));
    assert_eq!((summary.measured_theta_i_deg.len(), summary.description.as_str()), (16, "GGX, made"));
    let shapes: Vec<_> = summary.tables.iter().map(|table| (table.name.as_str(), table.shape.clone())).collect();
    assert!(shapes.contains(&("vndf", vec![1, 16, 32, 32])) && shapes.contains(&("rgb", vec![1, 16, 3, 16, 16])));
    // the material itself is reciprocal; what is left is its tabulation
    assert!(summary.non_reciprocity < 0.01, "{}", summary.non_reciprocity);
    assert!(summary.channels[0].max > summary.channels[2].max && summary.channels.iter().all(|range| range.min > 0.0));
}

/// The six measured materials are not reciprocal: from 1 % for paper to tens of percent for colour-shifting films.
#[test]
fn measured_files_are_not_reciprocal() {
    let Some(data) = data::genuine() else { return };
    let name = |word: &str| data.join("measured").join(format!("{word}_rgb.bsdf"));
    let of = |word: &str| summary(&name(word)).non_reciprocity;
    let found =
        ["paper_white", "satin_rosaline", "vch_silk_blue", "irid_flake_paint1", "cc_ibiza_sunset", "chm_mint"].map(of);
    println!("non-reciprocity: {found:.4?}");
    assert!(found[0] < 0.03 && found[5] > 0.1 && found.iter().all(|&value| (0.005..0.5).contains(&value)), "{found:?}");
}

/// The `.binary` files of the test data were resampled from the `.bsdf` files by another program and rounded to 13 bits.
#[test]
fn cells_are_those_of_the_resampled_files() {
    let Some(data) = data::genuine() else { return };
    for path in data::measured(&data) {
        let name = path.file_stem().unwrap().to_string_lossy().into_owned();
        let open = |path: &Path, position| brdfit_measured::open(path, position).unwrap();
        let resampled = open(&path, Some(SamplePosition::Centre));
        let original = open(&data.join("measured").join(format!("{name}_rgb.bsdf")), None);
        let (valid, a, b) =
            (resampled.survey(false).unwrap().valid, resampled.cells().unwrap(), original.cells().unwrap());
        let mut errors: Vec<f64> = (valid.iter().step_by(7))
            .filter(|&cell| b.value(1, cell) >= 0.0)
            .map(|cell| (a.value(1, cell) - b.value(1, cell)).abs() / a.value(1, cell).max(1e-3))
            .collect();
        errors.sort_by(f64::total_cmp);
        let [median, most, all] =
            [500, 999, 1000].map(|share| errors[(errors.len() * share / 1000).min(errors.len() - 1)]);
        println!("{name}: against the resampled file: median {median:.1e}, 99.9 % {most:.1e}, largest {all:.1e}");
        // the largest lie beside the narrowest peaks and where both directions graze
        assert!(median < 4e-5 && most < 1e-3 && all < 0.1, "{name}: {median} {most} {all}");
    }
}
