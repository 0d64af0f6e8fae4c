//! The shifted gamma distribution of microfacet normals.

use crate::math::gamma::ln_upper_gamma;
use std::f64::consts::PI;

/// The shifted gamma distribution (thesis V.3.2) with its normalisation computed once:
///
/// `D(theta_h) = P22(tan^2 theta_h) / (pi cos^4 theta_h)`, `P22(x) = K e^(-a) / a^p`, `a = alpha + x / alpha`,
/// `K = 1 / (alpha Gamma(1 - p, alpha))`, so that the integral of `D cos theta_h` over the hemisphere is one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ShiftedGamma {
    alpha: f64,
    p: f64,
    ln_k: f64,
    /// `d ln K / d alpha` and `d ln K / d p`.
    ln_k_slopes: [f64; 2],
}

impl ShiftedGamma {
    /// The distribution with width `alpha` in [1e-12, 100] and exponent `p` in (-90, 20); `None` outside or where `K` is not finite.
    pub fn new(alpha: f64, p: f64) -> Option<Self> {
        if alpha.is_nan() || alpha > 100.0 {
            return None;
        }
        let s = 1.0 - p;
        let (ln_gamma, slope) = ln_upper_gamma(s, alpha);
        let ln_alpha = libm::log(alpha);
        // d Gamma(s, x) / dx = -x^(s-1) e^-x
        let by_alpha = libm::exp((s - 1.0) * ln_alpha - alpha - ln_gamma) - 1.0 / alpha;
        let ln_k = -ln_alpha - ln_gamma;
        (ln_k.is_finite() && by_alpha.is_finite() && slope.is_finite()).then_some(Self {
            alpha,
            p,
            ln_k,
            ln_k_slopes: [by_alpha, slope],
        })
    }

    /// The width parameter alpha.
    pub fn alpha(&self) -> f64 {
        self.alpha
    }

    /// The exponent p.
    pub fn p(&self) -> f64 {
        self.p
    }

    /// `ln K`; `K` itself stays below 1e13 for alpha >= 1e-6 and p in [0, 2].
    pub fn ln_k(&self) -> f64 {
        self.ln_k
    }

    /// `K`, the normalisation of `P22`.
    pub fn k(&self) -> f64 {
        libm::exp(self.ln_k)
    }

    /// `(d ln K / d alpha, d ln K / d p)`.
    pub fn ln_k_slopes(&self) -> [f64; 2] {
        self.ln_k_slopes
    }

    /// `ln P22` at `x = tan^2 theta_h`.
    pub fn ln_p22(&self, x: f64) -> f64 {
        let a = self.alpha + x / self.alpha;
        self.ln_k - a - self.p * libm::log(a)
    }

    /// `P22` at `x = tan^2 theta_h`.
    pub fn p22(&self, x: f64) -> f64 {
        libm::exp(self.ln_p22(x))
    }

    /// `D` in 1/sr at the cosine of theta_h; zero at and below the horizon.
    pub fn d(&self, cos_theta_h: f64) -> f64 {
        if cos_theta_h <= 0.0 {
            return 0.0;
        }
        let square = cos_theta_h * cos_theta_h;
        let tan_square = (1.0 - square).max(0.0) / square;
        self.p22(tan_square) / (PI * square * square)
    }

    /// `D` in 1/sr at theta_h in radians: keeps full relative precision for small angles, where a cosine has lost it.
    pub fn d_at(&self, theta_h: f64) -> f64 {
        if !(0.0..PI / 2.0).contains(&theta_h) {
            return 0.0;
        }
        let (tan, cos) = (libm::tan(theta_h), libm::cos(theta_h));
        let square = cos * cos;
        self.p22(tan * tan) / (PI * square * square)
    }

    /// `(d ln D / d alpha, d ln D / d p)` at `x = tan^2 theta_h`; the same for `P22`.
    pub fn ln_slopes(&self, x: f64) -> [f64; 2] {
        let a = self.alpha + x / self.alpha;
        let a_by_alpha = 1.0 - x / (self.alpha * self.alpha);
        [self.ln_k_slopes[0] - a_by_alpha * (1.0 + self.p / a), self.ln_k_slopes[1] - libm::log(a)]
    }

    /// The probability that a normal drawn with density `D cos theta_h` has `tan^2 theta_h <= x` (thesis V.3.5):
    /// `1 - Gamma(1 - p, alpha + x / alpha) / Gamma(1 - p, alpha)`.
    pub fn cumulative(&self, x: f64) -> f64 {
        let ln_total = -self.ln_k - libm::log(self.alpha);
        let (ln_tail, _) = ln_upper_gamma(1.0 - self.p, self.alpha + x.max(0.0) / self.alpha);
        (-libm::expm1((ln_tail - ln_total).min(0.0))).clamp(0.0, 1.0)
    }

    /// The `x = tan^2 theta_h` below which a share `u` in [0, 1) of the normals lies: the inverse of [`Self::cumulative`],
    /// by bisection on `ln x` to about 1e-12 relative.
    pub fn quantile(&self, u: f64) -> f64 {
        if u <= 0.0 {
            return 0.0;
        }
        let (mut low, mut high) = (2.0 * libm::log(self.alpha) - 40.0, libm::log(self.alpha) + 6.0);
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            if self.cumulative(libm::exp(middle)) < u {
                low = middle;
            } else {
                high = middle;
            }
        }
        libm::exp(0.5 * (low + high))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn without_exponent_it_is_beckmann() {
        // p = 0: P22 = e^(-x/alpha)/alpha, Beckmann with m^2 = alpha.
        let distribution = ShiftedGamma::new(0.04, 0.0).unwrap();
        for degrees in [0.0_f64, 5.0, 20.0, 60.0] {
            let theta = degrees.to_radians();
            let beckmann = (-theta.tan().powi(2) / 0.04).exp() / (PI * 0.04 * theta.cos().powi(4));
            assert!((distribution.d_at(theta) / beckmann - 1.0).abs() < 1e-12);
            assert!((distribution.d(theta.cos()) / beckmann - 1.0).abs() < 1e-9);
        }
    }

    #[test]
    fn projected_area_is_one() {
        // Integral of P22 over x by the trapezoidal rule in ln x.
        for (alpha, p) in [(1e-6, 0.0), (1e-6, 2.0), (1e-3, 0.6), (0.1, 1.0), (1.0, 0.3)] {
            let distribution = ShiftedGamma::new(alpha, p).unwrap();
            let step = 0.01;
            let sum: f64 = (-14000..2000)
                .map(|n| {
                    let x = (f64::from(n) * step / 2.0).exp();
                    distribution.p22(x) * x * step / 2.0
                })
                .sum();
            assert!((sum - 1.0).abs() < 1e-9, "alpha {alpha} p {p}: {sum}");
        }
    }

    #[test]
    fn slopes_agree_with_central_differences() {
        for (alpha, p) in [(1e-5, 0.4), (3e-3, 1.3), (0.2, 0.1), (0.9, 1.9)] {
            let at = |alpha: f64, p: f64, x: f64| ShiftedGamma::new(alpha, p).unwrap().ln_p22(x);
            let centre = ShiftedGamma::new(alpha, p).unwrap();
            for x in [0.0, alpha * alpha, alpha, 4.0 * alpha] {
                let [by_alpha, by_p] = centre.ln_slopes(x);
                let h = 1e-5 * alpha;
                let numeric = (at(alpha + h, p, x) - at(alpha - h, p, x)) / (2.0 * h);
                assert!(
                    (by_alpha - numeric).abs() < 1e-6 * (by_alpha.abs() + 1.0 / alpha),
                    "alpha {alpha} p {p} x {x}"
                );
                let numeric = (at(alpha, p + 1e-5, x) - at(alpha, p - 1e-5, x)) / 2e-5;
                assert!((by_p - numeric).abs() < 1e-7 * (1.0 + by_p.abs()), "alpha {alpha} p {p} x {x}");
            }
        }
    }

    #[test]
    fn the_quantile_inverts_the_cumulative() {
        for (alpha, p) in [(1e-5, 0.4), (3e-3, 1.3), (0.2, 0.1)] {
            let distribution = ShiftedGamma::new(alpha, p).unwrap();
            for u in [0.01, 0.5, 0.9, 0.999] {
                let x = distribution.quantile(u);
                assert!((distribution.cumulative(x) - u).abs() < 1e-10, "alpha {alpha} p {p} u {u}");
            }
        }
    }
}
