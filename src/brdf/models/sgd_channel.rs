//! One SGD channel in single precision, eight half vectors at a time.

use crate::math::log_exp::{exp2, log2};
use crate::models::sgd::Sgd;
use std::f64::consts::{LOG2_E, PI};
use wide::f32x8;

/// `2^LOWEST` is zero in [`exp2`]: where the distribution lies below `2^-126.5` of its maximum it counts as zero.
const LOWEST: f32 = -127.0;

/// What does not depend on directions.
///
/// The distribution is evaluated as `P22(t) = P22(t*) 2^e` with `t = tan^2 theta_h`, `t*` where `P22` is largest (0 unless
/// p < -alpha) and `e = ((t* - t) / alpha) log2(e) + p log2((1 + t*/alpha^2) / (1 + t/alpha^2))`, which loses no digits in the core.
#[derive(Clone, Debug)]
pub(crate) struct SgdChannel {
    /// `rho_d / pi`.
    pub(crate) diffuse: f32,
    /// `rho_s P22(t*) / pi^2`.
    pub(crate) specular: f64,
    /// `e` where t is zero.
    start: f32,
    /// `log2(e) / alpha`.
    decay: f32,
    inverse_alpha_square: f32,
    p: f32,
    f0: f32,
    f1: f32,
}

impl SgdChannel {
    pub(crate) fn new(sgd: &Sgd) -> Self {
        let parameters = sgd.parameters();
        let (alpha, p) = (parameters.alpha, parameters.p);
        // d ln P22 / da = -1 - p / a
        let largest_at = alpha * (-p - alpha).max(0.0);
        Self {
            diffuse: (parameters.rho_d / PI) as f32,
            specular: parameters.rho_s * sgd.distribution().p22(largest_at) / (PI * PI),
            start: (largest_at / alpha * LOG2_E + p * libm::log2(1.0 + largest_at / (alpha * alpha))) as f32,
            decay: (LOG2_E / alpha) as f32,
            inverse_alpha_square: (1.0 / (alpha * alpha)) as f32,
            p: p as f32,
            f0: parameters.f0 as f32,
            f1: parameters.f1 as f32,
        }
    }

    /// `P22(t) / P22(t*)`; `None` where it is zero for all eight.
    #[inline(always)]
    pub(crate) fn lobe(&self, tan_square: f32x8) -> Option<f32x8> {
        let decayed = self.start - tan_square * self.decay;
        // unless p is below zero the rest of the exponent only lowers it
        (self.p < 0.0 || decayed.simd_gt(f32x8::splat(LOWEST)).any()).then(|| {
            let exponent = decayed - log2(tan_square * self.inverse_alpha_square + 1.0) * self.p;
            exp2(exponent.fast_max(f32x8::splat(LOWEST)))
        })
    }

    /// The Fresnel term, `fifth` from [`fifth_of_grazing`].
    #[inline(always)]
    pub(crate) fn fresnel(&self, cos_d: f32x8, fifth: f32x8) -> f32x8 {
        self.f0 - cos_d * self.f1 + fifth * (1.0 - self.f0)
    }
}

/// `(1 - cos theta_d)^5`.
#[inline(always)]
pub(crate) fn fifth_of_grazing(cos_d: f32x8) -> f32x8 {
    let grazing = 1.0 - cos_d;
    let grazing_square = grazing * grazing;
    grazing_square * grazing_square * grazing
}
