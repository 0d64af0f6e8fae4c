//! The interface of masking functions for the evaluation of models.

use std::fmt::Debug;
use wide::{f32x8, f64x4};

/// Smith's `G1` of one distribution, made ready for evaluations by the million.
///
/// Directions come with a `position`, [`crate::G1Curve::position`], which depends on the direction alone: a fixed set of directions
/// computes it once for all materials. Closed forms do without.
pub trait Masking: Clone + Debug + Send + Sync + 'static {
    /// `mu Lambda` of a direction, `mu = cot theta`, from its cosine (above zero), its sine (above zero) and its position.
    fn mu_lambda(&self, cos_theta: f64, sin_theta: f64, position: f64) -> f64;

    /// `G1 / cos theta` of a direction.
    #[inline]
    fn g1_over_cos(&self, cos_theta: f64, sin_theta: f64, position: f64) -> f64 {
        1.0 / (cos_theta + sin_theta * self.mu_lambda(cos_theta, sin_theta, position))
    }

    /// `cos theta / G1` of four directions.
    #[inline]
    fn four_cos_over_g1(&self, cos_theta: f64x4, sin_theta: f64x4, positions: [f64; 4]) -> f64x4 {
        let (cos, sin) = (cos_theta.to_array(), sin_theta.to_array());
        cos_theta + sin_theta * f64x4::from(std::array::from_fn(|n| self.mu_lambda(cos[n], sin[n], positions[n])))
    }

    /// `G1` at theta in radians: 1 at the normal, 0 at and below the horizon.
    fn g1(&self, theta: f64) -> f64;
}

/// Smith's `G1` of three channels in single precision.
pub trait MaskingLanes: Clone + Debug + Send + Sync + 'static {
    /// `G1 / cos theta` per channel for directions with a cosine above zero and the square of the sine; finite.
    fn g1_over_cos(&self, cos: f32x8, sin_square: f32x8) -> [f32x8; 3];
}
