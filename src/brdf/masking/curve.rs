//! Smith's `G1` of one distribution as a piecewise polynomial, for fast evaluation.

use crate::masking::masking::Masking;

/// Width of an interval in `ln cot theta`.
const STEP: f64 = 1.0 / 16.0;
/// Added to positions, so that all are above zero and truncation rounds them down.
const OFFSET: f64 = 1024.0;

/// `mu Lambda` as a function of `ln mu`, `mu = cot theta`, on intervals of 1/16, quintic in each (six-point Lagrange).
///
/// In this variable the curve is equally smooth at every roughness, up to the horizon. Largest relative error of `G1`
/// against the quadrature of the shifted gamma distribution, over alpha in [1e-6, 1], p in [0, 2] and all of (0, pi/2): 5e-8
/// (test below). Building it takes some 200 quadratures.
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
    /// Tabulates `mu Lambda` as a function of `mu = cot theta` over a range of `ln mu`: below it must be linear in `mu` to
    /// what accuracy is asked for, above it counts as zero.
    pub fn new(mu_lambda: impl Fn(f64) -> f64, ln_mu: [f64; 2]) -> Self {
        let (first, last) = ((ln_mu[0] / STEP).floor() as i32, (ln_mu[1] / STEP).ceil() as i32);
        let node = |n: i32| libm::exp(f64::from(n) * STEP);
        let samples: Vec<f64> = (first - 2..=last + 3).map(|n| mu_lambda(node(n))).collect();
        let intervals = samples.windows(6).map(quintic_through).collect();
        let slope = (samples[2] - samples[1]) / (node(first) - node(first - 1));
        Self { first: first + OFFSET as i32, intervals, low: [samples[2] - slope * node(first), slope] }
    }

    /// Position of a direction in the table, `ln(cot theta)` in steps: depends on the direction alone, so that a fixed set of
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
}

impl Masking for G1Curve {
    #[inline]
    fn mu_lambda(&self, cos_theta: f64, sin_theta: f64, position: f64) -> f64 {
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

    fn g1(&self, theta: f64) -> f64 {
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
    use crate::distributions::normal_distribution::NormalDistribution;
    use crate::distributions::shifted_gamma::ShiftedGamma;

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
                let curve = distribution.masking();
                for n in 1..400 {
                    // dense towards the horizon: cot theta from 1e2 down to 1e-12
                    let theta = libm::atan(libm::exp(-4.6 + f64::from(n) * 0.081));
                    let exact = distribution.g1(theta);
                    worst = worst.max((curve.g1(theta) / exact - 1.0).abs());
                }
                assert_eq!((curve.g1(0.0), curve.g1(2.0)), (1.0, 0.0));
            }
        }
        println!("largest relative error of the tabulated G1: {worst:.2e}");
        assert!(worst < 5e-8, "{worst}");
    }
}
