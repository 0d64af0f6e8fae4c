//! The shifted gamma distribution of microfacet normals.

use crate::distributions::normal_distribution::{LobeLanes, NormalDistribution};
use crate::masking::curve::G1Curve;
use crate::masking::smith::{SmithIntegral, laguerre_rule};
use crate::masking::table::MaskingTable;
use crate::math::gamma::ln_upper_gamma;
use crate::math::log_exp::{exp2, log2};
use crate::models::parameter::{Parameter, ParameterError, Transform};
use std::f64::consts::{LOG2_E, PI};
use wide::{f32x8, f64x4};

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
    smith: SmithIntegral,
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
            smith: SmithIntegral::new(alpha, p, ln_k, [by_alpha, slope]),
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

    /// The probability that a normal drawn with density `D cos theta_h` has `tan^2 theta_h <= x` (thesis V.3.5):
    /// `1 - Gamma(1 - p, alpha + x / alpha) / Gamma(1 - p, alpha)`.
    pub fn cumulative(&self, x: f64) -> f64 {
        let ln_total = -self.ln_k - libm::log(self.alpha);
        let (ln_tail, _) = ln_upper_gamma(1.0 - self.p, self.alpha + x.max(0.0) / self.alpha);
        (-libm::expm1((ln_tail - ln_total).min(0.0))).clamp(0.0, 1.0)
    }
}

/// `2^LOWEST` is zero in [`exp2`]: where the distribution lies below `2^-126.5` of its maximum it counts as zero.
const LOWEST: f32 = -127.0;

impl NormalDistribution<2> for ShiftedGamma {
    const MODEL: &'static str = "sgd";
    const TITLE: &'static str = "SGD";
    const DIVISOR: f64 = PI;
    const SHAPE: [Parameter; 2] = [
        Parameter {
            name: "alpha",
            symbol: ("α", ""),
            meaning: "Width of the distribution, above zero: small is sharp.",
            unit: "",
            transform: Transform::Logarithm,
            range: [1e-6, 1.0],
        },
        Parameter {
            name: "p",
            symbol: ("p", ""),
            meaning: "Exponent of the distribution: large makes the peak sharper than the tail.",
            unit: "",
            transform: Transform::Identity,
            range: [0.0, 2.0],
        },
    ];
    const STARTS: &'static [[f64; 2]] = &[[1e-4, 0.4], [3e-3, 0.4], [0.1, 0.4], [0.9, 0.1], [1e-5, 0.4]];
    const SEARCH_LATTICE: Option<[f64; 2]> = Some([0.25, 0.2]);
    type Masking = G1Curve;
    type MaskingLanes = MaskingTable;
    type Lanes = ShiftedGammaLanes;

    fn from_shape([alpha, p]: [f64; 2]) -> Result<Self, ParameterError> {
        ParameterError::unless(p > -90.0 && p < 20.0, "p", p, "between -90 and 20")?;
        let domain = "between 1e-12 and 100, with a finite normalisation";
        Self::new(alpha, p).ok_or(ParameterError { name: "alpha", value: alpha, domain })
    }

    fn shape(&self) -> [f64; 2] {
        [self.alpha, self.p]
    }

    fn p22(&self, x: f64) -> f64 {
        libm::exp(self.ln_p22(x))
    }

    fn ln_slopes(&self, x: f64) -> [f64; 2] {
        let a = self.alpha + x / self.alpha;
        let a_by_alpha = 1.0 - x / (self.alpha * self.alpha);
        [self.ln_k_slopes[0] - a_by_alpha * (1.0 + self.p / a), self.ln_k_slopes[1] - libm::log(a)]
    }

    #[inline(always)]
    fn ln_shape(&[alpha, p]: &[f64; 2], x: f64x4) -> (f64x4, [f64x4; 2]) {
        // e^(-b) (alpha / (alpha + b))^p, b = x / alpha
        let b = x * (1.0 / alpha);
        let ln_ratio = -(b * (1.0 / alpha)).ln_1p();
        (ln_ratio * p - b, [b + b * (2.0 * p) / (b + alpha), ln_ratio])
    }

    fn mu_lambda(&self, mu: f64) -> f64 {
        self.smith.mu_lambda(mu)
    }

    fn mu_lambda_with_slopes(&self, mu: f64) -> (f64, [f64; 2]) {
        self.smith.mu_lambda_with_slopes(mu)
    }

    /// By bisection on `ln x` to about 1e-12 relative.
    fn quantile(&self, u: f64) -> f64 {
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

    /// From where the lobe is constant to where a billionth of the normals is left.
    fn tan_square_range(&self) -> [f64; 2] {
        [self.alpha * self.alpha / 256.0, self.quantile(1.0 - 1e-9)]
    }

    /// `P22(x) dx = alpha K e^(-alpha) e^(-t) (alpha + t)^(-p) dt` with `x = alpha t`, by the rule of the masking function.
    fn quadrature(&self) -> Vec<(f64, f64)> {
        let ln_density = self.ln_k + libm::log(self.alpha) - self.alpha;
        laguerre_rule()
            .map(|(t, weight)| (self.alpha * t, libm::exp(ln_density - self.p * libm::log(self.alpha + t)) * weight))
            .collect()
    }

    fn normalisation(&self) -> Option<f64> {
        Some(self.k())
    }

    fn masking(&self) -> G1Curve {
        // Below: mu Lambda is linear in mu to 1e-8. Above: a0 > 60, mu Lambda is below 1e-20 mu.
        let ln_alpha = libm::log(self.alpha);
        G1Curve::new(|mu| self.smith.mu_lambda(mu), [ln_alpha - 9.5, 0.5 * (libm::log(60.0) + ln_alpha)])
    }

    fn masking_lanes(channels: [&G1Curve; 3]) -> MaskingTable {
        MaskingTable::new(channels)
    }

    fn lanes(&self) -> ShiftedGammaLanes {
        let (alpha, p) = (self.alpha, self.p);
        // d ln P22 / da = -1 - p / a
        let largest_at = alpha * (-p - alpha).max(0.0);
        ShiftedGammaLanes {
            peak: self.p22(largest_at),
            start: (largest_at / alpha * LOG2_E + p * libm::log2(1.0 + largest_at / (alpha * alpha))) as f32,
            decay: (LOG2_E / alpha) as f32,
            inverse_alpha_square: (1.0 / (alpha * alpha)) as f32,
            p: p as f32,
        }
    }
}

/// The lobe in single precision: `P22(t) = P22(t*) 2^e` with `t = tan^2 theta_h`, `t*` where `P22` is largest (0 unless
/// p < -alpha) and `e = ((t* - t) / alpha) log2(e) + p log2((1 + t*/alpha^2) / (1 + t/alpha^2))`, which loses no digits in the core.
#[derive(Clone, Debug)]
pub struct ShiftedGammaLanes {
    /// `P22(t*)`.
    peak: f64,
    /// `e` where t is zero.
    start: f32,
    /// `log2(e) / alpha`.
    decay: f32,
    inverse_alpha_square: f32,
    p: f32,
}

impl LobeLanes for ShiftedGammaLanes {
    fn height(&self) -> f64 {
        self.peak
    }

    #[inline(always)]
    fn lobe(&self, tan_square: f32x8) -> Option<f32x8> {
        let decayed = self.start - tan_square * self.decay;
        // unless p is below zero the rest of the exponent only lowers it
        (self.p < 0.0 || decayed.simd_gt(f32x8::splat(LOWEST)).any()).then(|| {
            let exponent = decayed - log2(tan_square * self.inverse_alpha_square + 1.0) * self.p;
            exp2(exponent.fast_max(f32x8::splat(LOWEST)))
        })
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
            let tan_square = theta.tan().powi(2);
            assert!((distribution.d_at_tan_square(tan_square) / beckmann - 1.0).abs() < 1e-12);
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
