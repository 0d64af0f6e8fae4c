//! Measured materials as BRDFs: on files made of known functions, and on the measured ones.

mod data;

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use brdfit_brdf::{Brdf, Direction, Directions, HalfDifference, direction};
use brdfit_measured::{
    AlbedoPlan, Dimensions, Grid, MeasuredBrdf, MerlFile, Reason, SamplePosition, ValueFault, cosines,
};

const POSITIONS: [SamplePosition; 2] = [SamplePosition::Edge, SamplePosition::Centre];
const GRIDS: [Dimensions; 2] = [Dimensions::HALF_TURN, Dimensions::FULL_TURN];

/// Kronecker's sequence of the golden ratio of dimension four: deterministic, even.
fn points(count: u32) -> impl Iterator<Item = [f64; 4]> {
    const STEPS: [f64; 4] =
        [0.856_674_883_854_502_9, 0.733_891_856_627_126_5, 0.628_706_721_079_063_3, 0.538_597_257_078_071_4];
    (1..=count).map(|n| STEPS.map(|step| (0.5 + f64::from(n) * step).fract()))
}

/// Pairs of directions over both hemispheres, a third of them with a half vector near the normal.
fn pairs(count: u32) -> impl Iterator<Item = (Direction, Direction)> {
    points(count).enumerate().map(|(n, [a, b, c, d])| {
        let i = direction(libm::acos(1.0 - 0.999 * a), TAU * b);
        let near = |spread: f64| {
            let o = Direction::new(-i.x, -i.y, i.z) + direction(FRAC_PI_2 * c, TAU * d) * spread;
            o.normalize()
        };
        let o = match n % 3 {
            0 => near(0.1),
            1 => near(1e-4),
            _ => direction(libm::acos(1.0 - 0.999 * c), TAU * d),
        };
        (i, o)
    })
}

/// A file of a function of (channel, theta_h, theta_d, phi_d) at its samples.
fn tabulated(dimensions: Dimensions, position: SamplePosition, f: impl Fn(usize, f64, f64, f64) -> f64) -> MerlFile {
    let grid = Grid::new(dimensions, position);
    MerlFile::from_fn("made", dimensions, |c, h, d, p| {
        if !grid.usable().contains(dimensions.index(h, d, p)) {
            return -1.0;
        }
        f(
            c,
            dimensions.theta_h_sample(h, position),
            dimensions.theta_d_sample(d, position),
            dimensions.phi_d_sample(p, position),
        )
    })
    .unwrap()
}

/// One incident direction at a time, eight outgoing ones around one that matters.
fn by_lobes(model: &MeasuredBrdf, i: &Direction, o: &Direction) -> ([f32; 3], Direction) {
    let o: Directions = [*o; 9].into_iter().collect();
    let (mut r, mut g, mut b) = ([9.0; 9], [9.0; 9], [9.0; 9]);
    model.towards(&o).values(i, 0, [&mut r, &mut g, &mut b]);
    assert_eq!((r[0], g[0], b[0]), (r[8], g[8], b[8]), "the rest of a block differs from a block");
    ([r[3], g[3], b[3]], o.get(3))
}

#[test]
fn a_constant_stays_that_constant_exactly() {
    let constants = [0.1, 0.3, 7.0].map(|f: f64| f64::from(f as f32));
    for (dimensions, position) in GRIDS.into_iter().flat_map(|d| POSITIONS.map(|p| (d, p))) {
        let file = tabulated(dimensions, position, |c, _, _, _| constants[c]);
        let model = MeasuredBrdf::new(&file, position).unwrap();
        for (i, o) in pairs(3000) {
            let expected = if o.z > 0.0 { constants } else { [0.0; 3] };
            assert_eq!(model.value(&i, &o), expected);
            assert_eq!(by_lobes(&model, &i, &o).0.map(f64::from), expected);
        }
    }
}

#[test]
fn both_directions_must_be_above_the_horizon() {
    let file = tabulated(Dimensions::HALF_TURN, SamplePosition::Edge, |_, _, _, _| 1.0);
    let model = MeasuredBrdf::new(&file, SamplePosition::Edge).unwrap();
    let (above, level, below) = (direction(0.4, 1.0), Direction::new(1.0, 0.0, 0.0), direction(1.8, 1.0));
    for (i, o) in [(above, level), (level, above), (above, below), (below, above), (below, below)] {
        assert_eq!(model.value(&i, &o), [0.0; 3]);
        assert_eq!(by_lobes(&model, &i, &o).0, [0.0; 3]);
        assert_eq!(model.pdf(&i, &o), 0.0);
    }
}

/// Every sample has another value; the angles of the samples give them back.
#[test]
fn samples_are_reproduced() {
    let noise = |h: usize, d: usize, p: usize| 1.0 + ((h * 7919 + d * 104_729 + p * 1299) % 1009) as f64 / 1009.0;
    for (dimensions, position) in GRIDS.into_iter().flat_map(|d| POSITIONS.map(|p| (d, p))) {
        let bins = dimensions.phi_d();
        let mirrored = |p: usize| if position == SamplePosition::Edge { (bins - p) % bins } else { bins - 1 - p };
        let file = MerlFile::from_fn("noise", dimensions, |_, h, d, p| noise(h, d, p.min(mirrored(p)))).unwrap();
        let model = MeasuredBrdf::new(&file, position).unwrap();
        let mut seen = 0;
        for (h, d) in (1..90).step_by(3).flat_map(|h| (1..90).step_by(4).map(move |d| (h, d))) {
            for p in (0..bins).step_by(7) {
                let angles = HalfDifference {
                    theta_h: dimensions.theta_h_sample(h, position),
                    theta_d: dimensions.theta_d_sample(d, position),
                    phi_d: dimensions.phi_d_sample(p, position),
                };
                let (i, o) = angles.to_directions();
                if i.z.min(o.z) > 1e-9 {
                    let expected = noise(h, d, p.min(mirrored(p)));
                    assert!((model.value(&i, &o)[0] / expected - 1.0).abs() < 1e-6, "{h} {d} {p}");
                    let (fast, o) = by_lobes(&model, &i, &o);
                    assert!((f64::from(fast[0]) / model.value(&i, &o)[0] - 1.0).abs() < 1e-4, "{h} {d} {p}");
                    seen += 1;
                }
            }
        }
        assert!(seen > 10_000);
    }
}

/// The error of trilinear interpolation is an eighth of the second differences, summed over the axes.
#[test]
fn smooth_functions_are_reproduced_within_the_interpolation_error() {
    for dimensions in GRIDS {
        for position in POSITIONS {
            // even in phi_d; with half the period where opposite directions share a bin
            let turns = if dimensions.is_folded() { 2.0 } else { 1.0 };
            let f = |c: usize, h: f64, d: f64, p: f64| {
                1.0 + (c as f64 + 1.0) * (h / FRAC_PI_2).sqrt() * libm::sin(d) * (2.0 + libm::cos(turns * p))
            };
            let model = MeasuredBrdf::new(&tabulated(dimensions, position, f), position).unwrap();
            let mut worst: f64 = 0.0;
            for (i, o) in pairs(20_000).filter(|(i, o)| i.z.min(o.z) > 0.1) {
                let angles = HalfDifference::from_directions(&i, &o);
                let last = 88.5;
                let outside = angles.theta_h < dimensions.theta_h_sample(0, position)
                    || angles.theta_d < dimensions.theta_d_sample(0, position)
                    || angles.theta_h > (last / 90.0_f64).powi(2) * FRAC_PI_2;
                if outside {
                    continue;
                }
                let value = model.value(&i, &o);
                for c in 0..3 {
                    let exact = f(c, angles.theta_h, angles.theta_d, angles.phi_d);
                    worst = worst.max((value[c] - exact).abs());
                }
            }
            println!("{dimensions} {position}: {worst:.1e}");
            // (c + 1) (pi/180)^2 / 8 (3 + turns^2) at most
            assert!(worst < 3.0 * 3.81e-5 * (3.0 + turns * turns) + 1e-6, "{dimensions} {position}: {worst}");
        }
    }
}

#[test]
fn reciprocity_and_mirror_symmetry_are_exact() {
    let noise = |c: usize, h: usize, d: usize, p: usize| ((c + h * 7919 + d * 104_729 + p * 1299) % 1009) as f64;
    for dimensions in GRIDS {
        let file = MerlFile::from_fn("noise", dimensions, noise).unwrap();
        let model = MeasuredBrdf::new(&file, SamplePosition::Centre).unwrap();
        let mirrored = |v: &Direction| Direction::new(v.x, -v.y, v.z);
        for (i, o) in pairs(5000) {
            let value = model.value(&i, &o);
            assert_eq!(value, model.value(&mirrored(&i), &mirrored(&o)));
            assert_eq!(by_lobes(&model, &i, &o).0, by_lobes(&model, &mirrored(&i), &mirrored(&o)).0);
            if dimensions.is_folded() {
                assert_eq!(value, model.value(&o, &i));
            }
        }
    }
}

#[test]
fn files_without_a_usable_cell_are_refused() {
    let file = MerlFile::from_fn("nothing.binary", Dimensions::HALF_TURN, |_, _, _, _| -1.0).unwrap();
    let error = MeasuredBrdf::new(&file, SamplePosition::Edge).unwrap_err();
    assert!(matches!(error.reason(), Reason::Values(ValueFault::NoValidCells)));
    assert!(error.to_string().starts_with("nothing.binary: "), "{error}");
}

/// The estimate of the directional albedo by sampling.
fn estimate(model: &MeasuredBrdf, theta_i: f64, count: u32) -> [f64; 3] {
    let i = direction(theta_i, 0.0);
    let mut sums = [0.0; 3];
    for [a, b, c, _] in points(count) {
        if let Some(o) = model.sample(&i, [a, b, c]) {
            let weight = o.z / model.pdf(&i, &o);
            for (sum, f) in sums.iter_mut().zip(model.value(&i, &o)) {
                *sum += f * weight;
            }
        }
    }
    sums.map(|sum| sum / f64::from(count))
}

/// f = cos theta_i cos theta_o has the albedo (2 pi / 3) cos theta_i.
#[test]
fn sampling_finds_a_known_albedo() {
    let f = |_, h, d, p| {
        let (cos_i, cos_o) = cosines(h, d, p);
        cos_i * cos_o
    };
    let centre = SamplePosition::Centre;
    let model = MeasuredBrdf::new(&tabulated(Dimensions::HALF_TURN, centre, f), centre).unwrap();
    for theta_i in [0.1, 0.7, 1.2] {
        let exact = 2.0 * PI / 3.0 * libm::cos(theta_i);
        let found = estimate(&model, theta_i, 50_000);
        println!("{theta_i}: {:.1e}", found[0] / exact - 1.0);
        assert!((found[0] / exact - 1.0).abs() < 3e-3, "{theta_i}: {found:?} {exact}");
    }
}

#[test]
fn measured_files_have_their_albedo_and_fast_values() {
    let Some(data) = data::folder() else { return };
    let centre = SamplePosition::Centre;
    let angles = [0.2, 0.6, 1.0];
    let plan = AlbedoPlan::new(Dimensions::HALF_TURN, centre, &angles);
    for path in data::measured(&data) {
        let file = MerlFile::open(&path).unwrap();
        let name = path.file_stem().unwrap().to_string_lossy();
        let model = MeasuredBrdf::new(&file, centre).unwrap();
        let expected = plan.integrate(|cell| file.rgb(cell).map(|rgb| rgb[1]));
        for (&theta_i, expected) in angles.iter().zip(expected) {
            let found = estimate(&model, theta_i, 50_000)[1];
            println!("{name} {theta_i}: {:+.4}", found / expected - 1.0);
            assert!((found / expected - 1.0).abs() < 0.03, "{name} {theta_i}: {found} {expected}");
        }
        let mut errors = Vec::new();
        for (i, o) in pairs(30_000) {
            let (fast, o) = by_lobes(&model, &i, &o);
            for (fast, value) in fast.into_iter().zip(model.value(&i, &o)) {
                errors.push((f64::from(fast) - value).abs() / value.max(1e-6));
            }
        }
        errors.sort_by(f64::total_cmp);
        // The last ones lie just beside a sample that is thousands of times darker than the next.
        let [median, most, all] =
            [500, 999, 1000].map(|share| errors[(errors.len() * share / 1000).min(errors.len() - 1)]);
        println!("{name}: single precision: median {median:.1e}, 99.9 % {most:.1e}, all {all:.1e}");
        assert!(median < 1e-6 && most < 1e-4 && all < 1e-2, "{name}: {median} {most} {all}");
    }
}
