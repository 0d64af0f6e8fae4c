//! What renderers sample and evaluate of a measured material: a file made of a GGX lobe on a diffuse floor.

#[path = "../../brdf/tests/checks/mod.rs"]
mod checks;

use brdfit_brdf::{Brdf, Direction, GgxMaterial, HalfDifference, direction};
use brdfit_measured::{Dimensions, MeasuredBrdf, MerlFile, SamplePosition};
use checks::{check_draws, evaluated, furnace};
use std::f64::consts::TAU;

fn ggx() -> GgxMaterial {
    GgxMaterial::without_fresnel([0.3, 0.2, 0.1], [0.4, 0.3, 0.6], 0.05).unwrap()
}

fn measured(dimensions: Dimensions) -> MeasuredBrdf {
    let centre = SamplePosition::Centre;
    let file = MerlFile::from_fn("made", dimensions, |channel, h, d, p| {
        let angles = HalfDifference {
            theta_h: dimensions.theta_h_sample(h, centre),
            theta_d: dimensions.theta_d_sample(d, centre),
            phi_d: dimensions.phi_d_sample(p, centre),
        };
        let (i, o) = angles.to_directions();
        if i.z.min(o.z) > 0.0 { ggx().value(&i, &o)[channel] } else { -1.0 }
    });
    MeasuredBrdf::new(&file.unwrap(), centre).unwrap()
}

#[test]
fn draws_follow_the_density() {
    let model = measured(Dimensions::HALF_TURN);
    check_draws("measured", &*model.batch());
}

#[test]
fn values_are_those_in_double_precision() {
    for dimensions in [Dimensions::HALF_TURN, Dimensions::FULL_TURN] {
        let model = measured(dimensions);
        let mut pairs = [0, 1].map(|_| [0; 3].map(|_| Vec::new()));
        for n in 0..20_000 {
            let [a, b, c] = [0.819_172_513, 0.671_043_606, 0.549_700_477].map(|step| (f64::from(n) * step).fract());
            for (v, to) in [direction(1.5 * a, 0.0), direction(1.5 * b, TAU * c)].into_iter().zip(&mut pairs) {
                for (to, v) in to.iter_mut().zip([v.x, v.y, v.z]) {
                    to.push(v as f32);
                }
            }
        }
        let [i, o] = pairs;
        let (values, density) = evaluated(&*model.batch(), &i, &o);
        let mut worst: f64 = 0.0;
        for n in 0..i[0].len() {
            let at = |v: &[Vec<f32>; 3]| Direction::new(v[0][n].into(), v[1][n].into(), v[2][n].into());
            for (channel, exact) in values.iter().zip(model.value(&at(&i), &at(&o))) {
                worst = worst.max((f64::from(channel[n]) / exact - 1.0).abs());
            }
            assert!(density[n] > 0.0);
        }
        println!("{dimensions}: largest relative error {worst:.1e}");
        assert!(worst < 1e-4, "{worst}");
    }
}

/// Against quadrature over half vectors.
#[test]
fn weights_average_to_the_albedo() {
    let model = measured(Dimensions::HALF_TURN);
    let shading = model.batch();
    for theta in [0.05, 0.8, 1.3, 1.5] {
        let eye = direction(theta, 0.4);
        // midpoint rule over half vectors, in theta_h = pi/2 s^3, where the lobe is resolved
        let (rings, azimuths) = (1000, 200);
        let (mut i, mut weights) = ([0; 3].map(|_| Vec::new()), Vec::new());
        for ring in 0..rings {
            let s = (f64::from(ring) + 0.5) / f64::from(rings);
            let theta_h = std::f64::consts::FRAC_PI_2 * s.powi(3);
            let width = 3.0 * std::f64::consts::FRAC_PI_2 * s * s / f64::from(rings);
            for n in 0..azimuths {
                let h = direction(theta_h, TAU * (f64::from(n) + 0.5) / f64::from(azimuths));
                let drawn = h * (2.0 * eye.dot(&h)) - eye;
                for (i, v) in i.iter_mut().zip([drawn.x, drawn.y, drawn.z]) {
                    i.push(v as f32);
                }
                let area = libm::sin(theta_h) * width * TAU / f64::from(azimuths);
                weights.push(area * 4.0 * eye.dot(&h).max(0.0) * drawn.z.max(0.0));
            }
        }
        let o = [eye.x, eye.y, eye.z].map(|v| vec![v as f32; weights.len()]);
        let (values, _) = evaluated(&*shading, &i, &o);
        let (found, largest) = furnace(&*shading, theta, 200_000);
        for c in 0..3 {
            let expected: f64 = values[c].iter().zip(&weights).map(|(&value, weight)| f64::from(value) * weight).sum();
            println!("{theta} {c}: {:+.1e}, largest weight {largest:.1}", found[c] / expected - 1.0);
            assert!((found[c] / expected - 1.0).abs() < 5e-3, "{theta} {c}: {} {expected}", found[c]);
        }
        assert!(largest < 20.0, "{theta}: {largest}");
    }
}
