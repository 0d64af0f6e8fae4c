//! The GGX distribution of normals: a model's, and the proxy that half vectors are drawn from.

use crate::distributions::normal_distribution::{LobeLanes, NormalDistribution};
use crate::masking::masking::{Masking, MaskingLanes};
use crate::math::direction::{Direction, direction};
use crate::models::parameter::{Parameter, ParameterError, Transform};
use std::f64::consts::{PI, TAU};
use wide::{f32x8, f64x4};

/// GGX (Trowbridge-Reitz) of width alpha: `D = alpha^2 / (pi cos^4 theta_h (alpha^2 + tan^2 theta_h)^2)` with
/// `G1 = 2 / (1 + sqrt(1 + alpha^2 tan^2 theta))` (Walter et al. 2007, eq. 33 and 34).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ggx {
    alpha: f64,
    alpha_square: f64,
}

impl Ggx {
    /// The width of a material's distribution.
    pub const ALPHA_RANGE: [f64; 2] = [1e-4, 10.0];

    /// The distribution of width `alpha > 0`, which is the root of the median of `tan^2 theta_h`.
    pub fn new(alpha: f64) -> Self {
        Self { alpha, alpha_square: alpha * alpha }
    }

    /// The width alpha.
    pub fn alpha(&self) -> f64 {
        self.alpha
    }

    /// A normal with density `D cos theta_h` from two numbers in [0, 1): azimuth and radius.
    pub fn sample(&self, u: [f64; 2]) -> Direction {
        direction(libm::atan(self.quantile(u[1]).sqrt()), TAU * u[0])
    }
}

impl NormalDistribution<1> for Ggx {
    const MODEL: &'static str = "ggx";
    const TITLE: &'static str = "GGX";
    const DIVISOR: f64 = 4.0;
    const SHAPE: [Parameter; 1] = [Parameter {
        name: "alpha",
        symbol: ("α", ""),
        meaning: "Width of the distribution: the root of the median of tan^2 theta_h.",
        unit: "",
        transform: Transform::Logarithm,
        range: [1e-4, 2.0],
    }];
    const STARTS: &'static [[f64; 1]] = &[[0.1], [0.02], [0.5], [4e-3], [8e-4]];
    const SINGLE_PRECISION_LOBES: bool = false;
    type Masking = Self;
    type MaskingLanes = GgxMaskingLanes;
    type Lanes = GgxLanes;

    fn from_shape([alpha]: [f64; 1]) -> Result<Self, ParameterError> {
        let inside = (Self::ALPHA_RANGE[0]..=Self::ALPHA_RANGE[1]).contains(&alpha);
        ParameterError::unless(inside, "alpha", alpha, "between 1e-4 and 10")?;
        Ok(Self::new(alpha))
    }

    fn shape(&self) -> [f64; 1] {
        [self.alpha]
    }

    fn p22(&self, x: f64) -> f64 {
        let base = self.alpha_square + x;
        self.alpha_square / (base * base)
    }

    fn ln_slopes(&self, x: f64) -> [f64; 1] {
        [2.0 * (x - self.alpha_square) / (self.alpha * (self.alpha_square + x))]
    }

    #[inline(always)]
    fn ln_shape(&[alpha]: &[f64; 1], x: f64x4) -> (f64x4, [f64x4; 1]) {
        let ratio = x * (1.0 / (alpha * alpha));
        (ratio.ln_1p() * -2.0, [ratio * 4.0 / (ratio + 1.0)])
    }

    /// `(sqrt(mu^2 + alpha^2) - mu) / 2`, without cancellation.
    fn mu_lambda(&self, mu: f64) -> f64 {
        0.5 * self.alpha_square / (mu + (mu * mu + self.alpha_square).sqrt())
    }

    fn mu_lambda_with_slopes(&self, mu: f64) -> (f64, [f64; 1]) {
        (NormalDistribution::mu_lambda(self, mu), [0.5 * self.alpha / (mu * mu + self.alpha_square).sqrt()])
    }

    fn quantile(&self, u: f64) -> f64 {
        self.alpha_square * u / (1.0 - u)
    }

    fn tan_square_range(&self) -> [f64; 2] {
        [self.alpha_square / 256.0, (1e6 * self.alpha_square).max(1e4)]
    }

    /// The trapezoidal rule in `s = ln(x / alpha^2)`: `P22(x) dx = e^s / (1 + e^s)^2 ds`, steps of 1/8 up to +-26.
    fn quadrature(&self) -> Vec<(f64, f64)> {
        const STEP: f64 = 0.125;
        (-208..=208)
            .map(|n| {
                let e = libm::exp(f64::from(n) * STEP);
                (self.alpha_square * e, STEP * e / ((1.0 + e) * (1.0 + e)))
            })
            .collect()
    }

    fn masking(&self) -> Self {
        *self
    }

    fn masking_lanes(channels: [&Self; 3]) -> GgxMaskingLanes {
        GgxMaskingLanes {
            alpha_square: channels.map(|ggx| ggx.alpha_square as f32),
            shared: channels[0] == channels[1] && channels[1] == channels[2],
        }
    }

    fn lanes(&self) -> GgxLanes {
        GgxLanes { height: self.alpha_square, alpha_square: self.alpha_square as f32 }
    }

    fn d_at_tan_square(&self, x: f64) -> f64 {
        let base = (1.0 + x) / (self.alpha_square + x);
        self.alpha_square * base * base / PI
    }
}

impl Masking for Ggx {
    #[inline]
    fn mu_lambda(&self, cos_theta: f64, sin_theta: f64, _: f64) -> f64 {
        NormalDistribution::mu_lambda(self, cos_theta / sin_theta)
    }

    #[inline]
    fn g1_over_cos(&self, cos_theta: f64, sin_theta: f64, _: f64) -> f64 {
        let slope = self.alpha * sin_theta;
        2.0 / (cos_theta + (cos_theta * cos_theta + slope * slope).sqrt())
    }

    #[inline]
    fn four_cos_over_g1(&self, cos_theta: f64x4, sin_theta: f64x4, _: [f64; 4]) -> f64x4 {
        let slope = sin_theta * self.alpha;
        (cos_theta + (cos_theta * cos_theta + slope * slope).sqrt()) * 0.5
    }

    fn g1(&self, theta: f64) -> f64 {
        NormalDistribution::g1(self, theta)
    }
}

/// `G1` of three channels in single precision.
#[derive(Clone, Debug)]
pub struct GgxMaskingLanes {
    alpha_square: [f32; 3],
    /// Whether the channels have one width.
    shared: bool,
}

impl MaskingLanes for GgxMaskingLanes {
    #[inline(always)]
    fn g1_over_cos(&self, cos: f32x8, sin_square: f32x8) -> [f32x8; 3] {
        let of = |c: usize| 2.0 / (cos + (cos * cos + sin_square * self.alpha_square[c]).sqrt());
        if self.shared { [of(0); 3] } else { [of(0), of(1), of(2)] }
    }
}

/// The lobe in single precision: `((1 + x) / (alpha^2 + x))^2` with `x = tan^2 theta_h`, with the factor `1 / cos^4 theta_h`.
#[derive(Clone, Debug)]
pub struct GgxLanes {
    height: f64,
    alpha_square: f32,
}

impl LobeLanes for GgxLanes {
    fn height(&self) -> f64 {
        self.height
    }

    #[inline(always)]
    fn lobe(&self, tan_square: f32x8) -> Option<f32x8> {
        let base = (tan_square + 1.0) / (tan_square + self.alpha_square);
        Some(base * base)
    }

    #[inline(always)]
    fn masked(&self, lobe: f32x8, scale: f32x8, g1_over_cos: [f32x8; 2], _: f32x8) -> f32x8 {
        lobe * (g1_over_cos[0] * g1_over_cos[1]) * scale
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn samples_follow_the_cumulative() {
        // share below x = tan^2: x / (alpha^2 + x)
        let ggx = Ggx::new(0.2);
        for u in [0.1, 0.5, 0.9] {
            let m = ggx.sample([0.3, u]);
            let tan_square = (1.0 - m.z * m.z) / (m.z * m.z);
            assert!((tan_square / (0.04 + tan_square) - u).abs() < 1e-12);
            assert!((ggx.d_at_tan_square(tan_square) / ggx.d_at(libm::acos(m.z)) - 1.0).abs() < 1e-12);
        }
    }

    #[test]
    fn the_quadrature_integrates_the_cumulative() {
        // int P22 dx / (1 + x) = [x ln x - x + 1] / (x - 1)^2 at x = alpha^2
        for alpha in [1e-3_f64, 0.1, 0.7, 3.0] {
            let y = alpha * alpha;
            let expected = y * (1.0 / y - 1.0 + y.ln()) / ((1.0 - y) * (1.0 - y));
            let rule = Ggx::new(alpha).quadrature();
            let found: f64 = rule.iter().map(|(x, weight)| weight / (1.0 + x)).sum();
            assert!((found / expected - 1.0).abs() < 1e-9, "alpha {alpha}: {found} {expected}");
            assert!((rule.iter().map(|(_, weight)| weight).sum::<f64>() - 1.0).abs() < 1e-10);
        }
    }

    #[test]
    fn widths_outside_of_the_domain_are_refused() {
        for alpha in [0.0, -1.0, 9e-5, 10.1, f64::NAN, f64::INFINITY] {
            assert_eq!(Ggx::from_shape([alpha]).unwrap_err().name, "alpha");
        }
        assert!(Ggx::ALPHA_RANGE.into_iter().all(|alpha| Ggx::from_shape([alpha]).is_ok()));
    }
}
