//! Smith's masking function of the shifted gamma distribution, by quadrature.
//!
//! `G1 = 1 / (1 + Lambda)`. With `mu = cot theta`, `a0 = alpha + mu^2 / alpha` and `t = a - a0` Smith's integral over
//! slopes takes the form without cancellation
//!
//! `Lambda = (alpha K / pi) e^(-a0) int_0^inf e^(-t) (a0 + t)^(-p) g(sqrt(alpha t) / mu) dt`, `g(s) = s - arctan s`,
//!
//! which one fixed double-exponential rule handles for every (alpha, p, theta). What is computed is `mu Lambda`, finite up
//! to grazing: `G1 = mu / (mu + mu Lambda)`.

use std::f64::consts::PI;
use std::sync::LazyLock;
use wide::f64x4;

/// The rule `t = exp(x - e^(-x))`, `x = -3.3 + n / 10`, `n = 0..=70`, padded to a multiple of four by weights of zero;
/// a weight is `e^(-t) dt/dx / 10`.
static RULE: LazyLock<Vec<Node>> = LazyLock::new(|| {
    let (nodes, weights): (Vec<f64>, Vec<f64>) = laguerre_rule().unzip();
    let pad = |values: &[f64], fill: f64| -> Vec<f64x4> {
        values
            .chunks(4)
            .map(|chunk| {
                let mut lanes = [fill; 4];
                lanes[..chunk.len()].copy_from_slice(chunk);
                f64x4::from(lanes)
            })
            .collect()
    };
    pad(&nodes, 1.0).into_iter().zip(pad(&weights, 0.0)).map(|(t, weight)| Node { t, root: t.sqrt(), weight }).collect()
});

/// Where the logarithm of the integrand's scale lies below this, a0 is above 40 and `Lambda` below 1e-19: `G1` is one.
const NEGLIGIBLE: f64 = -44.0;

struct Node {
    t: f64x4,
    root: f64x4,
    weight: f64x4,
}

/// Nodes and weights of a double-exponential rule for `int_0^inf e^(-t) phi(t) dt`, `phi` smooth in `ln t`: the weights
/// contain `e^(-t)`.
pub(crate) fn laguerre_rule() -> impl Iterator<Item = (f64, f64)> {
    (0..=70).map(|n| {
        let x = -3.3 + f64::from(n) / 10.0;
        let inner = libm::exp(-x);
        let t = libm::exp(x - inner);
        (t, 0.1 * t * (1.0 + inner) * libm::exp(-t))
    })
}

/// Smith's `mu Lambda` of one shifted gamma distribution, exact up to quadrature: `G1` is within 2e-13 of an mpmath
/// integration of the original definition for alpha in [1e-6, 1], p in [0, 2] (`data-fixtures/sgd.json`; `docs/accuracy.md`).
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct SmithIntegral {
    alpha: f64,
    p: f64,
    /// `ln(alpha K / pi)` and its derivatives with respect to alpha and p.
    ln_scale: f64,
    ln_scale_slopes: [f64; 2],
}

impl SmithIntegral {
    /// Of the distribution with these parameters, `ln K` and its derivatives (thesis eq. III.4).
    pub(crate) fn new(alpha: f64, p: f64, ln_k: f64, [by_alpha, by_p]: [f64; 2]) -> Self {
        Self { alpha, p, ln_scale: libm::log(alpha / PI) + ln_k, ln_scale_slopes: [by_alpha + 1.0 / alpha, by_p] }
    }

    /// `mu Lambda` at `mu = cot theta > 0`; zero where `Lambda` is below 1e-19.
    pub(crate) fn mu_lambda(&self, mu: f64) -> f64 {
        self.integrate(mu, |_, _, value, _, sums| sums[0] += value)[0]
    }

    /// `mu Lambda` and its derivatives with respect to alpha and p at fixed `mu = cot theta > 0`.
    pub(crate) fn mu_lambda_with_slopes(&self, mu: f64) -> (f64, [f64; 2]) {
        let a0_slope = 1.0 - mu * mu / (self.alpha * self.alpha);
        let sums = self.integrate(mu, |a, ln_a, value, widening, sums| {
            sums[0] += value;
            sums[1] += value / a;
            sums[2] += value * ln_a;
            sums[3] += widening;
        });
        let m = sums[0];
        let by_alpha =
            (self.ln_scale_slopes[0] - a0_slope) * m - self.p * a0_slope * sums[1] + sums[3] / (2.0 * self.alpha);
        let by_p = self.ln_scale_slopes[1] * m - sums[2];
        (m, [by_alpha, by_p])
    }

    /// Runs the rule: hands `a = a0 + t`, `ln a`, the weighted integrand and the weighted `sigma s^2 / (1 + s^2)` (twice alpha times
    /// the integrand's derivative through the width `sigma = sqrt(alpha t)`) of four nodes to `add`; returns the four sums.
    fn integrate(&self, mu: f64, add: impl Fn(f64x4, f64x4, f64x4, f64x4, &mut [f64x4; 4])) -> [f64; 4] {
        let a0 = self.alpha + mu * mu / self.alpha;
        let exponent = self.ln_scale - a0;
        if exponent - self.p * libm::log(a0) < NEGLIGIBLE {
            return [0.0; 4];
        }
        let root_alpha = self.alpha.sqrt();
        let (mu4, minus_p) = (f64x4::splat(mu), f64x4::splat(-self.p));
        let mut sums = [f64x4::splat(0.0); 4];
        for node in RULE.iter() {
            let a = node.t + a0;
            let ln_a = a.ln();
            let density = (minus_p * ln_a + exponent).exp() * node.weight;
            let sigma = node.root * root_alpha;
            let s = sigma / mu4;
            let s2 = s * s;
            // s - arctan s by its series where the difference would cancel
            let series = s * s2 * (s2 * (s2 * (s2 * (-1.0 / 9.0) + 1.0 / 7.0) - 0.2) + 1.0 / 3.0);
            let g = s2.simd_lt(f64x4::splat(9e-4)).select(series, s - s.atan());
            add(a, ln_a, density * mu4 * g, density * sigma * (s2 / (s2 + 1.0)), &mut sums);
        }
        sums.map(|sum| {
            let [a, b, c, d] = sum.to_array();
            (a + b) + (c + d)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::distributions::normal_distribution::NormalDistribution;
    use crate::distributions::shifted_gamma::ShiftedGamma;

    fn smith(alpha: f64, p: f64) -> ShiftedGamma {
        ShiftedGamma::new(alpha, p).unwrap()
    }

    #[test]
    fn without_exponent_it_is_beckmanns() {
        // p = 0 is Beckmann with m^2 = alpha: Lambda = (erf(a) - 1)/2 + exp(-a^2) / (2 a sqrt(pi)), a = cot theta / m (Walter 2007).
        for alpha in [1e-4_f64, 0.01, 0.3] {
            for degrees in [1.0_f64, 20.0, 45.0, 70.0, 85.0, 89.0, 89.99] {
                let theta = degrees.to_radians();
                let a = 1.0 / (theta.tan() * alpha.sqrt());
                let lambda = -0.5 * libm::erfc(a) + (-a * a).exp() / (2.0 * a * PI.sqrt());
                let expected = 1.0 / (1.0 + lambda);
                let value = smith(alpha, 0.0).g1(theta);
                assert!((value - expected).abs() < 1e-12, "alpha {alpha}, {degrees} degrees: {value} {expected}");
            }
        }
    }

    #[test]
    fn ends_and_monotony() {
        for (alpha, p) in [(1e-6, 0.4), (1e-3, 1.2), (0.9, 2.0)] {
            let smith = smith(alpha, p);
            assert_eq!(smith.g1(0.0), 1.0);
            assert_eq!(smith.g1(PI / 2.0 + 1e-9), 0.0);
            let mut last = 1.0;
            for n in 1..900 {
                let value = smith.g1(f64::from(n) * 0.1_f64.to_radians());
                assert!(value <= last + 1e-15 && value > 0.0, "alpha {alpha} p {p} n {n}");
                last = value;
            }
        }
    }

    #[test]
    fn slopes_agree_with_central_differences() {
        for (alpha, p) in [(1e-5, 0.4), (3e-3, 1.3), (0.2, 0.1), (0.9, 1.9)] {
            for degrees in [30.0_f64, 60.0, 80.0, 89.0] {
                let theta = degrees.to_radians();
                let (_, slopes) = smith(alpha, p).g1_with_slopes(theta);
                let h = 1e-5 * alpha;
                let by_alpha = (smith(alpha + h, p).g1(theta) - smith(alpha - h, p).g1(theta)) / (2.0 * h);
                let by_p = (smith(alpha, p + 1e-5).g1(theta) - smith(alpha, p - 1e-5).g1(theta)) / 2e-5;
                assert!((slopes[0] - by_alpha).abs() < 2e-6 * (by_alpha.abs() + 1e-5 / alpha), "alpha {alpha} p {p}");
                assert!((slopes[1] - by_p).abs() < 1e-7, "alpha {alpha} p {p}");
            }
        }
    }
}
