//! What renderers sample and evaluate, against the models in double precision and against quadrature.

mod checks;

use brdfit_brdf::{
    Brdf, Direction, GgxMaterial, Lambert, MicrofacetParameters, NormalDistribution, SgdMaterial, SgdParameters,
    direction, reflect,
};
use checks::{check_draws, evaluated, furnace};
use std::f64::consts::TAU;

fn sgd(alpha: [f64; 3], rho_d: f64) -> SgdMaterial {
    let channel =
        |c: usize| SgdParameters { rho_d, rho_s: 0.4, alpha: alpha[c], p: [0.4, 0.9, 1.6][c], f0: 0.3, f1: 0.05 };
    SgdMaterial::new([0, 1, 2].map(channel)).unwrap()
}

fn ggx() -> GgxMaterial {
    GgxMaterial::without_fresnel([0.1, 0.2, 0.0], [0.4, 0.3, 0.6], 0.1).unwrap()
}

/// Three GGX channels with a Fresnel term.
fn coloured_ggx(alpha: [f64; 3], rho_d: f64) -> GgxMaterial {
    let channel = |c: usize| MicrofacetParameters { rho_d, rho_s: 0.8, shape: [alpha[c]], f0: 0.3, f1: 0.05 };
    GgxMaterial::new([0, 1, 2].map(channel)).unwrap()
}

#[test]
fn draws_of_sgd_follow_the_density() {
    check_draws("sharp", &*sgd([1e-4; 3], 0.05).batch());
    check_draws("three widths", &*sgd([1e-4, 0.003, 0.2], 0.2).batch());
    check_draws("broad", &*sgd([0.3, 0.5, 0.9], 0.0).batch());
}

#[test]
fn draws_of_other_models_follow_the_density() {
    check_draws("ggx", &*ggx().batch());
    check_draws("coloured ggx", &*coloured_ggx([0.003, 0.05, 0.6], 0.1).batch());
    check_draws("sharp ggx", &*coloured_ggx([1e-4; 3], 0.0).batch());
    check_draws("broad ggx", &*coloured_ggx([2.0; 3], 0.3).batch());
    check_draws("lambert", &*Lambert { albedo: [0.5; 3] }.batch());
}

/// A model with the default.
struct Plain(GgxMaterial);

impl Brdf for Plain {
    fn value(&self, i: &Direction, o: &Direction) -> [f64; 3] {
        self.0.value(i, o)
    }

    fn sample(&self, i: &Direction, u: [f64; 3]) -> Option<Direction> {
        self.0.sample(i, u)
    }

    fn pdf(&self, i: &Direction, o: &Direction) -> f64 {
        self.0.pdf(i, o)
    }
}

#[test]
fn draws_of_any_model_follow_the_density() {
    check_draws("one by one", &*Plain(ggx()).batch());
}

#[test]
fn weights_average_to_the_albedo() {
    for (alpha, rho_d) in
        [([1e-4; 3], 0.05), ([1e-4, 0.003, 0.2], 0.2), ([0.3, 0.5, 0.9], 0.0), ([1e-6, 1e-5, 1e-3], 0.0)]
    {
        let material = sgd(alpha, rho_d);
        let batch = material.batch();
        for theta in [0.05, 0.6, 1.2, 1.5, 1.55] {
            let (found, largest) = furnace(&*batch, theta, 200_000);
            for c in 0..3 {
                let channel = material.channel(c);
                let expected = channel.directional_albedo(&channel.distribution().masking(), theta);
                println!("{alpha:?} {theta} {c}: {:+.1e}, largest weight {largest:.1}", found[c] / expected - 1.0);
                assert!((found[c] / expected - 1.0).abs() < 5e-3, "{alpha:?} {theta} {c}: {} {expected}", found[c]);
            }
            assert!(largest < 60.0, "{alpha:?} {theta}: {largest}");
        }
    }
}

fn ring(theta: f64, count: u32) -> impl Iterator<Item = Direction> {
    (0..count).map(move |n| direction(theta, TAU * f64::from(n) / f64::from(count)))
}

/// Pairs around the mirror direction, from the core to the tail, and across the hemisphere.
fn pairs(alpha: f64) -> ([Vec<f32>; 3], [Vec<f32>; 3]) {
    let (mut i, mut o) = ([0; 3].map(|_| Vec::new()), [0; 3].map(|_| Vec::new()));
    for cos in [1.0, 0.9, 0.5, 0.1, 0.02] {
        let from = direction(libm::acos(cos), 0.7);
        let around = (0..60).flat_map(|n| {
            let theta_h = 0.02 * alpha * libm::exp2(0.25 * f64::from(n));
            ring(theta_h.min(1.5), 7).map(|h| reflect(&from, &h)).collect::<Vec<_>>()
        });
        let across = (0..40).flat_map(|n| ring(f64::from(n) * 0.039, 9).collect::<Vec<_>>());
        for to in around.chain(across).filter(|to| to.z > 0.02) {
            for (axis, (a, b)) in [(from.x, to.x), (from.y, to.y), (from.z, to.z)].into_iter().enumerate() {
                i[axis].push(a as f32);
                o[axis].push(b as f32);
            }
        }
    }
    (i, o)
}

fn at(v: &[Vec<f32>; 3], n: usize) -> Direction {
    Direction::new(v[0][n].into(), v[1][n].into(), v[2][n].into())
}

/// The rounded directions are taken as they are, not scaled to length one.
#[test]
fn values_are_those_in_double_precision() {
    let mut worst = [0.0_f64; 2];
    for alpha in [1e-6, 1e-4, 1e-2, 0.2, 1.0] {
        let material = sgd([alpha; 3], 0.0);
        let (i, o) = pairs(alpha);
        let (values, _) = evaluated(&*material.batch(), &i, &o);
        for n in 0..i[0].len() {
            let exact = material.value(&at(&i, n), &at(&o, n));
            let peak =
                material.value(&at(&i, n), &Direction::new((-i[0][n]).into(), (-i[1][n]).into(), i[2][n].into()));
            for c in 0..3 {
                let share = exact[c] / peak[c];
                if share > 1e-30 {
                    let depth = usize::from(share < 1e-3);
                    worst[depth] = worst[depth].max((f64::from(values[c][n]) / exact[c] - 1.0).abs());
                } else {
                    assert!(f64::from(values[c][n]) < 1e-29 * peak[c]);
                }
            }
        }
    }
    println!("sgd: largest relative errors down to 1e-3 and 1e-30 of the mirror direction: {worst:?}");
    assert!(worst[0] < 6e-5 && worst[1] < 1e-4, "{worst:?}");
    let (i, o) = pairs(0.01);
    for model in [&ggx() as &dyn Brdf, &Lambert { albedo: [0.1, 0.5, 1.0] }, &Plain(ggx())] {
        let (values, _) = evaluated(&*model.batch(), &i, &o);
        for n in 0..i[0].len() {
            let exact = model.value(&at(&i, n), &at(&o, n));
            for c in 0..3 {
                assert!((f64::from(values[c][n]) / exact[c] - 1.0).abs() < 1e-4, "{} {}", values[c][n], exact[c]);
            }
        }
    }
}

#[test]
fn nothing_is_reflected_below_the_horizon_and_entries_are_independent() {
    let (sharp, lambert) = (sgd([1e-4, 0.01, 0.3], 0.1), Lambert { albedo: [0.5; 3] });
    for model in [&sharp as &dyn Brdf, &ggx(), &lambert, &Plain(ggx())] {
        let batch = model.batch();
        let (mut i, mut o) = pairs(0.01);
        for n in (0..i[0].len()).step_by(5) {
            if n % 2 == 0 { i[2][n] *= -1.0 } else { o[2][n] *= -1.0 }
        }
        let (values, density) = evaluated(&*batch, &i, &o);
        for n in 0..i[0].len() {
            let above = n % 5 != 0;
            assert!(values.iter().all(|channel| (channel[n] > 0.0) == above) && (density[n] > 0.0) == above);
        }
        for (first, count) in [(0, 1), (3, 7), (5, 8), (9, 17), (1, 0)] {
            let part = |all: &[Vec<f32>; 3]| all.each_ref().map(|v| v[first..first + count].to_vec());
            let (some, some_density) = evaluated(&*batch, &part(&i), &part(&o));
            assert_eq!((some, some_density), (part(&values), density[first..first + count].to_vec()));
        }
    }
}

#[test]
fn the_whole_domain_gives_numbers() {
    for (alpha, p) in [(1e-12, 2.0), (1e-6, -89.0), (1.0, -80.0), (100.0, 19.0), (100.0, -89.0), (0.01, 19.0)] {
        let channel = |rho_s| SgdParameters { rho_d: 0.1, rho_s, alpha, p, f0: 0.2, f1: -0.1 };
        let material = SgdMaterial::new([channel(0.5), channel(0.0), channel(0.3)]).unwrap();
        let batch = material.batch();
        for theta in [0.0, 1.0, 1.57] {
            let (albedo, largest) = furnace(&*batch, theta, 1000);
            assert!(
                albedo.iter().all(|albedo| albedo.is_finite()) && largest.is_finite(),
                "alpha {alpha} p {p}: {albedo:?}"
            );
        }
    }
}
