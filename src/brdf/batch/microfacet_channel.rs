//! One channel of a microfacet model in single precision, eight half vectors at a time.

use crate::distributions::normal_distribution::{LobeLanes, NormalDistribution};
use crate::models::microfacet::Microfacet;
use std::f64::consts::PI;
use wide::f32x8;

/// Quantities that do not depend on directions.
#[derive(Clone, Debug)]
pub(crate) struct MicrofacetChannel<L> {
    diffuse: f32,
    /// `rho_s height / (c pi)`.
    pub(crate) specular: f64,
    lanes: L,
    f0: f32,
    f1: f32,
}

/// Quantities of eight half vectors that the channels share.
#[derive(Clone, Copy)]
pub(crate) struct HalfAngles {
    pub(crate) tan_square: f32x8,
    cos_d: f32x8,
    /// `(1 - cos theta_d)^5`.
    fifth: f32x8,
}

impl HalfAngles {
    #[inline(always)]
    pub(crate) fn new(tan_square: f32x8, cos_d: f32x8) -> Self {
        let grazing = 1.0 - cos_d;
        let grazing_square = grazing * grazing;
        Self { tan_square, cos_d, fifth: grazing_square * grazing_square * grazing }
    }
}

impl<L: LobeLanes> MicrofacetChannel<L> {
    pub(crate) fn new<D: NormalDistribution<N, Lanes = L>, const N: usize>(channel: &Microfacet<D, N>) -> Self {
        let parameters = channel.parameters();
        let lanes = channel.distribution().lanes();
        Self {
            diffuse: (parameters.rho_d / PI) as f32,
            specular: parameters.rho_s * lanes.height() / (D::DIVISOR * PI),
            lanes,
            f0: parameters.f0 as f32,
            f1: parameters.f1 as f32,
        }
    }

    /// The lobe; `None` where it is zero for all eight.
    #[inline(always)]
    pub(crate) fn lobe(&self, half: &HalfAngles) -> Option<f32x8> {
        self.lanes.lobe(half.tan_square)
    }

    /// `f` in 1/sr from the lobe and what scales it: [`Self::specular`], and `G1 / cos theta` of either direction.
    #[inline(always)]
    pub(crate) fn value(&self, lobe: Option<f32x8>, half: &HalfAngles, scale: f32x8, g1_over_cos: [f32x8; 2]) -> f32x8 {
        match lobe {
            Some(lobe) => {
                let masked = self.lanes.masked(lobe, scale, g1_over_cos, half.tan_square);
                let fresnel = self.f0 - half.cos_d * self.f1 + half.fifth * (1.0 - self.f0);
                masked * fresnel + self.diffuse
            }
            None => f32x8::splat(self.diffuse),
        }
    }

    /// The diffuse part.
    #[inline(always)]
    pub(crate) fn diffuse(&self) -> f32x8 {
        f32x8::splat(self.diffuse)
    }
}
