//! Importance sampling of a measured material.

use brdfit_brdf::{Direction, Ggx, GgxMixture, HalfDifference, HalfVectorSampler, HalfVectorTable, direction, reflect};
use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, PI};

/// Half vectors of a GGX distribution as wide as the measured one, mixed with a cosine lobe by their albedos (one-sample
/// balance heuristic): the density is above zero wherever `f` is.
#[derive(Clone, Debug)]
pub(crate) struct Sampling {
    mixture: GgxMixture,
    /// Probability of the proxy; the rest goes to the cosine lobe.
    specular: f64,
    /// Diffuse part of the values, 1/sr.
    floor: f64,
}

/// `tan^2 theta_h` of the first bins of theta_h, and of 89 degrees: beyond, the cosine lobe draws.
const RANGE: [f64; 2] = [1e-10, 3283.0];
/// Angles theta_d, radians, over which the distribution of half vectors is averaged.
const THETA_D: [f64; 5] = [0.1, 0.3, 0.5, 0.7, 0.9];
/// At least this share of a value counts as part of the lobe.
const LEAST: f64 = 0.05;

/// Rows of the slice over theta_h, and azimuths of the half vector per half turn, in the estimates.
const ROWS: usize = 90;
const AZIMUTHS: usize = 16;

/// Largest angle at which a slice is reliable: 75 degrees, in radians.
const SLICE_END: f64 = 75.0 / 90.0 * FRAC_PI_2;

impl Sampling {
    /// Estimates width and shares from the mean over channels of `f(i, o)`.
    pub(crate) fn new(f: impl Fn(&Direction, &Direction) -> f64) -> Self {
        // retro-reflection, where D cos^2 theta_h is the specular part but for masking
        let middle = |row: usize| ((row as f64 + 0.5) / ROWS as f64).powi(2) * FRAC_PI_2;
        let slice: Vec<(f64, f64)> = (0..ROWS)
            .map(middle)
            .filter(|&theta_h| theta_h < SLICE_END)
            .map(|theta_h| {
                let h = direction(theta_h, 0.0);
                (theta_h, f(&h, &h))
            })
            .collect();
        let floor = lowest_decile(slice.iter().map(|entry| entry.1));
        let Some(proxy) = proxy(&slice, floor) else {
            return Self::with(Ggx::new(1.0), 0.0, floor);
        };
        let albedo = albedo_at_45_degrees(f, middle);
        let specular = if albedo > 0.0 { (1.0 - PI * floor / albedo).clamp(0.1, 0.95) } else { 0.0 };
        Self::with(proxy, specular, floor)
    }

    fn with(proxy: Ggx, specular: f64, floor: f64) -> Self {
        Self { mixture: GgxMixture::new([proxy; 3], [specular, 0.0, 0.0]), specular, floor }
    }

    /// For renderers: half vectors of the measured values themselves, mixed with the cosine lobe in the same shares. `f` as in
    /// [`Sampling::new`].
    pub(crate) fn half_vectors(&self, f: impl Fn(&Direction, &Direction) -> f64) -> HalfVectorSampler {
        // i and o equally high: f cos theta_i cos theta_o cos theta_h of what lies above the floor, per unit of tan^2 theta_h
        let density = |tan_square: f64| {
            let lobe = |theta_d: f64| {
                let theta_h = libm::atan(tan_square.sqrt());
                let (i, o) = HalfDifference { theta_h, theta_d, phi_d: FRAC_PI_2 }.to_directions();
                let (f, cos_d) = (f(&i, &o), libm::cos(theta_d));
                (f - self.floor).max(LEAST * f) * cos_d * cos_d
            };
            let secant_square = 1.0 + tan_square;
            THETA_D.map(lobe).iter().sum::<f64>() / (secant_square * secant_square * secant_square)
        };
        let normals = (self.specular > 0.0).then(|| HalfVectorTable::new(density, RANGE[0], RANGE[1])).flatten();
        HalfVectorSampler::new(normals, self.specular)
    }

    /// As [`brdfit_brdf::Brdf::sample`].
    pub(crate) fn sample(&self, i: &Direction, u: [f64; 3]) -> Option<Direction> {
        self.mixture.sample(i, u)
    }

    /// As [`brdfit_brdf::Brdf::pdf`].
    pub(crate) fn pdf(&self, i: &Direction, o: &Direction) -> f64 {
        self.mixture.pdf(i, o)
    }
}

/// The diffuse floor: the value that a tenth of the slice does not exceed.
fn lowest_decile(values: impl Iterator<Item = f64>) -> f64 {
    let mut sorted: Vec<f64> = values.collect();
    sorted.sort_by(f64::total_cmp);
    sorted[sorted.len() / 10]
}

/// The proxy whose median of `tan^2 theta_h` is that of the normals behind a slice of (theta_h, f) at the middles of the
/// rows: what is above the floor, by `cos^3 theta_h dw_h`. `None` where nothing is.
fn proxy(slice: &[(f64, f64)], floor: f64) -> Option<Ggx> {
    let weights: Vec<f64> = slice
        .iter()
        .map(|&(theta_h, f)| {
            // a row is sqrt(theta_h) wide but for a constant
            let (sin, cos) = libm::sincos(theta_h);
            (f - floor).max(0.0) * cos * cos * cos * sin * theta_h.sqrt()
        })
        .collect();
    let half = 0.5 * weights.iter().sum::<f64>();
    let mut below = 0.0;
    for (row, weight) in weights.into_iter().enumerate() {
        if weight > 0.0 && below + weight >= half {
            let x = (row as f64 + (half - below) / weight) / ROWS as f64;
            return Some(Ggx::new(libm::tan(x * x * FRAC_PI_2)));
        }
        below += weight;
    }
    None
}

/// The directional albedo at 45 degrees, by the half vector: `dw_o = 4 cos theta_d dw_h`.
fn albedo_at_45_degrees(f: impl Fn(&Direction, &Direction) -> f64, middle: impl Fn(usize) -> f64) -> f64 {
    let i = direction(FRAC_PI_4, 0.0);
    let mut sum = 0.0;
    for row in 0..ROWS {
        let theta_h = middle(row);
        let width = PI * (row as f64 + 0.5) / (ROWS * ROWS) as f64;
        let solid_angle = libm::sin(theta_h) * width * 2.0 * PI / AZIMUTHS as f64;
        for azimuth in 0..AZIMUTHS {
            let h = direction(theta_h, (azimuth as f64 + 0.5) / AZIMUTHS as f64 * PI);
            let o = reflect(&i, &h);
            let cos_d = i.dot(&h);
            if cos_d > 0.0 && o.z > 0.0 {
                sum += f(&i, &o) * 4.0 * cos_d * o.z * solid_angle;
            }
        }
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;
    use brdfit_brdf::NormalDistribution;

    #[test]
    fn the_proxy_of_a_ggx_lobe_has_its_width() {
        for alpha in [0.01, 0.05, 0.3] {
            let ggx = Ggx::new(alpha);
            let sampling = Sampling::new(|i, o| {
                let h = (i + o).normalize();
                0.05 + 0.05 * ggx.d_at(libm::acos(h.z)) / (i.z * o.z)
            });
            let found = sampling.mixture.proxies()[0].alpha();
            println!("alpha {alpha}: {found:.4}, share {:.3}", sampling.specular);
            assert!((found / alpha).ln().abs() < 0.25, "{alpha}: {found}");
            assert!((0.3..0.9).contains(&sampling.specular));
        }
    }

    #[test]
    fn what_has_no_lobe_is_sampled_by_the_cosine() {
        for constant in [0.0, 0.2] {
            assert_eq!(Sampling::new(|_, _| constant).specular, 0.0);
        }
    }
}
