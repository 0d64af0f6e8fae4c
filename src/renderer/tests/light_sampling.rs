//! Directions drawn from a light follow its density: chi-square tests.

use brdfit_renderer::{Light, Procedural, Vec3, octahedral, sobol};

#[path = "checks/chi_square.rs"]
mod chi_square;

use chi_square::{SIGNIFICANCE, p_value};

const N: usize = 64;
/// Bins along a side, blocks of 4 x 4 texels.
const BINS: usize = 16;

fn bin(d: Vec3) -> usize {
    let [column, row] = octahedral::direction_to_square(d).map(|x| ((x * BINS as f32) as usize).min(BINS - 1));
    row * BINS + column
}

/// The density integrated over each bin: by the midpoint rule on 4 x 4 places per texel, exact because the density times the
/// solid angle per area is constant in a texel.
fn expected(light: &Light) -> Vec<f64> {
    let fine = 4 * N;
    let mut mass = vec![0.0; BINS * BINS];
    for k in 0..fine * fine {
        let place = [k % fine, k / fine].map(|x| (x as f32 + 0.5) / fine as f32);
        let d = octahedral::square_to_direction(place);
        let area = f64::from(octahedral::solid_angle_per_area(d)) / (fine * fine) as f64;
        mass[bin(d)] += f64::from(light.density(d)) * area;
    }
    mass
}

fn single_texel() -> Light {
    let mut texels = vec![[0.01; 3]; N * N];
    texels[0] = [500.0, 400.0, 100.0];
    texels[20 * N + 40] = [0.0, 0.0, 300.0];
    Light::from_octahedral(N, texels).expect("a light")
}

#[test]
fn samples_follow_the_density() {
    let draws = 200_000;
    let lights = Procedural::ALL.map(|kind| (format!("{kind:?}"), kind.light(N)));
    for (name, light) in lights.into_iter().chain([("single texels".to_owned(), single_texel())]) {
        let mut counts = vec![0; BINS * BINS];
        for n in 0..draws {
            counts[bin(light.sample(chi_square::independent(n)))] += 1;
        }
        let p = p_value(&counts, &expected(&light), draws.into());
        assert!(p > SIGNIFICANCE, "{name}: p = {p}");
    }
}

/// The same test refuses a wrong density: that of another light.
#[test]
fn the_test_can_fail() {
    let (light, other) = (Procedural::Studio.light(N), Procedural::Sky.light(N));
    let mut counts = vec![0; BINS * BINS];
    for n in 0..20_000 {
        counts[bin(light.sample(chi_square::independent(n)))] += 1;
    }
    assert!(p_value(&counts, &expected(&other), 20_000.0) < 1e-6);
}

/// The mean of radiance over density is the integral of the radiance, for low-discrepancy points.
#[test]
fn estimates_are_unbiased() {
    for kind in Procedural::ALL {
        let light = kind.light(N);
        let fine = 8 * N;
        let exact: f64 = (0..fine * fine)
            .map(|k| octahedral::square_to_direction([k % fine, k / fine].map(|x| (x as f32 + 0.5) / fine as f32)))
            .map(|d| f64::from(light.radiance(d)[1] * octahedral::solid_angle_per_area(d)))
            .sum::<f64>()
            / (fine * fine) as f64;
        let count = 1 << 16;
        let (mut u, mut v) = (vec![0.0; count], vec![0.0; count]);
        sobol::fill(sobol::seed([3, 5], 0, 1), 0, [&mut u, &mut v]);
        let mut d = [0; 3].map(|_| vec![0.0; count]);
        light.sample_many([&u, &v], d.each_mut().map(|x| x.as_mut_slice()));
        let mut values = [0; 4].map(|_| vec![0.0; count]);
        let [r, g, b, density] = &mut values;
        light.evaluate_many([&d[0], &d[1], &d[2]], [r, g, b], density);
        assert!(density.iter().all(|&density| density > 0.0));
        let mean = g.iter().zip(density).map(|(g, density)| f64::from(*g / *density)).sum::<f64>() / count as f64;
        assert!((mean / exact - 1.0).abs() < 2e-3, "{kind:?}: {mean} {exact}");
    }
}
