//! The angles of a pair of directions that models depend on.

use crate::math::direction::HalfDifference;

/// A pair of directions as isotropic models see it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Configuration {
    /// `tan^2 theta_h`.
    pub tan_square_h: f64,
    /// `cos theta_d`.
    pub cos_theta_d: f64,
    /// Cosine of the incident direction with the normal.
    pub cos_theta_i: f64,
    /// Cosine of the outgoing direction with the normal.
    pub cos_theta_o: f64,
}

impl From<HalfDifference> for Configuration {
    fn from(angles: HalfDifference) -> Self {
        let tan = libm::tan(angles.theta_h);
        let (cos_theta_i, cos_theta_o) = angles.cosines();
        Self { tan_square_h: tan * tan, cos_theta_d: libm::cos(angles.theta_d), cos_theta_i, cos_theta_o }
    }
}
