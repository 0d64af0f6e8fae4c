//! Smith's `G1` of one distribution as a piecewise cubic, for evaluations by the million.

use crate::shifted_gamma::ShiftedGamma;
use crate::smith::SmithG1;
use wide::f64x4;

/// Width of an interval in `ln cot theta`.
const STEP: f64 = 1.0 / 32.0;

/// `mu Lambda` as a function of `ln mu`, `mu = cot theta`, on intervals of 1/32, cubic in each (four-point Lagrange).
///
/// In this variable the curve is equally smooth at every roughness, up to the horizon. Largest relative error of `G1`
/// against the quadrature, over alpha in [1e-6, 1], p in [0, 2] and all of (0, pi/2): 5e-8 (test below). Building it takes
/// some 500 quadratures.
#[derive(Clone, Debug)]
pub struct G1Curve {
    /// Number of the first interval, counted from `ln mu = 0`.
    first: i32,
    /// Cubic coefficients per interval, constant first.
    intervals: Vec<[f64; 4]>,
    /// Below the first interval `mu Lambda = low[0] + low[1] mu`.
    low: [f64; 2],
}

impl G1Curve {
    /// Tabulates the masking function of a distribution.
    pub fn new(distribution: &ShiftedGamma) -> Self {
        let smith = SmithG1::new(distribution);
        let ln_alpha = libm::log(distribution.alpha());
        // Below: mu Lambda is linear in mu to 1e-9. Above: a0 > 60, mu Lambda is below 1e-20 mu.
        let first = ((ln_alpha - 8.0).min(-2.0) / STEP).floor() as i32;
        let last = (0.5 * (libm::log(60.0) + ln_alpha) / STEP).ceil() as i32;
        let samples: Vec<f64> =
            (first - 1..=last + 2).map(|n| smith.mu_lambda(libm::exp(f64::from(n) * STEP))).collect();
        let intervals = samples.windows(4).map(cubic_through).collect();
        let (mu_a, mu_b) = (libm::exp(f64::from(first - 1) * STEP), libm::exp(f64::from(first) * STEP));
        let slope = (samples[1] - samples[0]) / (mu_b - mu_a);
        Self { first, intervals, low: [samples[1] - slope * mu_b, slope] }
    }

    /// Where in the table a direction lies, `ln(cot theta)` in steps: depends on the direction alone, so that a fixed set of
    /// directions computes it once for all materials.
    pub fn position(cos_theta: f64, sin_theta: f64) -> f64 {
        libm::log(cos_theta / sin_theta) / STEP
    }

    /// `mu Lambda` at a position, with `mu = cos theta / sin theta`.
    #[inline]
    fn mu_lambda(&self, position: f64, cos_theta: f64, sin_theta: f64) -> f64 {
        let floor = position.floor();
        let interval = floor - f64::from(self.first);
        if interval < 0.0 {
            return self.low[0] + self.low[1] * cos_theta / sin_theta;
        }
        match self.intervals.get(interval as usize) {
            Some([c0, c1, c2, c3]) => {
                let t = position - floor;
                ((c3 * t + c2) * t + c1) * t + c0
            }
            None => 0.0,
        }
    }

    /// `G1 / cos theta` from the cosine and sine of theta (cosine above zero) and their [`Self::position`].
    #[inline]
    pub fn g1_over_cos(&self, cos_theta: f64, sin_theta: f64, position: f64) -> f64 {
        1.0 / (cos_theta + sin_theta * self.mu_lambda(position, cos_theta, sin_theta))
    }

    /// `mu Lambda` of four directions: `G1 / cos theta = 1 / (cos theta + sin theta mu Lambda)`.
    #[inline]
    pub fn four_mu_lambdas(&self, positions: [f64; 4], cos_theta: f64x4, sin_theta: f64x4) -> f64x4 {
        let (cos, sin) = (cos_theta.to_array(), sin_theta.to_array());
        f64x4::from(std::array::from_fn(|n| self.mu_lambda(positions[n], cos[n], sin[n])))
    }

    /// `G1` at theta in radians.
    pub fn g1(&self, theta: f64) -> f64 {
        let (cos, sin) = (libm::cos(theta), libm::sin(theta));
        if cos <= 0.0 {
            0.0
        } else if sin <= 0.0 {
            1.0
        } else {
            cos * self.g1_over_cos(cos, sin, Self::position(cos, sin))
        }
    }
}

/// Coefficients in `t` in [0, 1] of the cubic through four samples at `t = -1, 0, 1, 2`.
fn cubic_through(y: &[f64]) -> [f64; 4] {
    let [a, b, c, d] = [y[0], y[1], y[2], y[3]];
    [b, -a / 3.0 - b / 2.0 + c - d / 6.0, 0.5 * (a + c) - b, 0.5 * (b - c) + (d - a) / 6.0]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn follows_the_quadrature_everywhere() {
        let mut worst: f64 = 0.0;
        for alpha in [1e-6, 1e-5, 1e-4, 1e-3, 0.01, 0.1, 0.5, 1.0] {
            for p in [0.0, 0.4, 0.9, 1.0, 1.5, 2.0] {
                let distribution = ShiftedGamma::new(alpha, p).unwrap();
                let (curve, smith) = (G1Curve::new(&distribution), SmithG1::new(&distribution));
                for n in 1..400 {
                    // dense towards the horizon: cot theta from 1e2 down to 1e-12
                    let theta = libm::atan(libm::exp(-4.6 + f64::from(n) * 0.081));
                    let exact = smith.g1(theta);
                    worst = worst.max((curve.g1(theta) / exact - 1.0).abs());
                }
                assert_eq!((curve.g1(0.0), curve.g1(2.0)), (1.0, 0.0));
            }
        }
        println!("largest relative error of the tabulated G1: {worst:.2e}");
        assert!(worst < 5e-8, "{worst}");
    }
}
