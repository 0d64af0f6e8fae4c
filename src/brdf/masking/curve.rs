//! Smith's `G1` of one distribution as a piecewise polynomial, for evaluations by the million.

use crate::distributions::shifted_gamma::ShiftedGamma;
use crate::masking::smith::SmithG1;
use wide::f64x4;

/// Width of an interval in `ln cot theta`.
const STEP: f64 = 1.0 / 16.0;
/// Added to positions, so that all are above zero and truncation rounds them down.
const OFFSET: f64 = 1024.0;

/// `mu Lambda` as a function of `ln mu`, `mu = cot theta`, on intervals of 1/16, quintic in each (six-point Lagrange).
///
/// In this variable the curve is equally smooth at every roughness, up to the horizon. Largest relative error of `G1`
/// against the quadrature, over alpha in [1e-6, 1], p in [0, 2] and all of (0, pi/2): 5e-8 (test below). Building it takes
/// some 200 quadratures.
#[derive(Clone, Debug)]
pub struct G1Curve {
    /// Position of the first interval.
    first: i32,
    /// Coefficients per interval, constant first.
    intervals: Vec<[f64; 6]>,
    /// Below the first interval `mu Lambda = low[0] + low[1] mu`.
    low: [f64; 2],
}

impl G1Curve {
    /// Tabulates the masking function of a distribution.
    pub fn new(distribution: &ShiftedGamma) -> Self {
        let smith = SmithG1::new(distribution);
        let ln_alpha = libm::log(distribution.alpha());
        // Below: mu Lambda is linear in mu to 1e-8. Above: a0 > 60, mu Lambda is below 1e-20 mu.
        let first = ((ln_alpha - 9.5) / STEP).floor() as i32;
        let last = (0.5 * (libm::log(60.0) + ln_alpha) / STEP).ceil() as i32;
        let node = |n: i32| libm::exp(f64::from(n) * STEP);
        let samples: Vec<f64> = (first - 2..=last + 3).map(|n| smith.mu_lambda(node(n))).collect();
        let intervals = samples.windows(6).map(quintic_through).collect();
        let slope = (samples[2] - samples[1]) / (node(first) - node(first - 1));
        Self { first: first + OFFSET as i32, intervals, low: [samples[2] - slope * node(first), slope] }
    }

    /// Where in the table a direction lies, `ln(cot theta)` in steps: depends on the direction alone, so that a fixed set of
    /// directions computes it once for all materials. For cosines and sines of at least 1e-30.
    pub fn position(cos_theta: f64, sin_theta: f64) -> f64 {
        libm::log(cos_theta / sin_theta) * (1.0 / STEP) + OFFSET
    }

    /// [`Self::position`] from `log2(cot theta)`.
    pub(crate) fn position_from_log2(log2_cot: f64) -> f64 {
        log2_cot * (std::f64::consts::LN_2 / STEP) + OFFSET
    }

    /// `mu = cot theta` between which the curve is neither linear nor zero.
    pub(crate) fn range(&self) -> [f64; 2] {
        [0, self.intervals.len()].map(|n| libm::exp((f64::from(self.first) + n as f64 - OFFSET) * STEP))
    }

    /// `mu Lambda` at a position, with `mu = cos theta / sin theta`.
    #[inline]
    pub(crate) fn mu_lambda(&self, position: f64, cos_theta: f64, sin_theta: f64) -> f64 {
        let cell = position as i32;
        let interval = cell - self.first;
        if interval < 0 {
            return self.low[0] + self.low[1] * cos_theta / sin_theta;
        }
        match self.intervals.get(interval as usize) {
            Some([c0, c1, c2, c3, c4, c5]) => {
                let t = position - f64::from(cell);
                ((((c5 * t + c4) * t + c3) * t + c2) * t + c1) * t + c0
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

/// Coefficients in `t` in [0, 1] of the quintic through six samples at `t = -2, .., 3`.
fn quintic_through(y: &[f64]) -> [f64; 6] {
    let [a, b, c, d, e, f] = [y[0], y[1], y[2], y[3], y[4], y[5]];
    [
        c,
        a / 20.0 - b / 2.0 - c / 3.0 + d - e / 4.0 + f / 30.0,
        -a / 24.0 + 2.0 * (b + d) / 3.0 - 1.25 * c - e / 24.0,
        -a / 24.0 - b / 24.0 + 5.0 * c / 12.0 - 7.0 * d / 12.0 + 7.0 * e / 24.0 - f / 24.0,
        (a + e) / 24.0 - (b + d) / 6.0 + c / 4.0,
        (f - a) / 120.0 + (b - e) / 24.0 + (d - c) / 12.0,
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_quintic_is_reproduced() {
        let f = |t: f64| 1.0 + t * (2.0 + t * (-0.5 + t * (0.3 + t * (-0.7 + t * 0.11))));
        let samples: Vec<f64> = (-2..=3).map(|n| f(f64::from(n))).collect();
        for (ours, expected) in quintic_through(&samples).iter().zip([1.0, 2.0, -0.5, 0.3, -0.7, 0.11]) {
            assert!((ours - expected).abs() < 1e-12, "{ours} {expected}");
        }
    }

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
