//! Directions and the half/difference parametrisation.

use std::f64::consts::{PI, TAU};

/// A unit vector in the local frame of the surface: the normal is +z.
pub type Direction = nalgebra::Vector3<f64>;

/// The direction at polar angle theta and azimuth phi, radians.
pub fn direction(theta: f64, phi: f64) -> Direction {
    let sin = libm::sin(theta);
    Direction::new(sin * libm::cos(phi), sin * libm::sin(phi), libm::cos(theta))
}

/// Half/difference angles in radians of a pair (i, o) (Rusinkiewicz 1998), without the azimuth of h, on which an isotropic
/// BRDF does not depend.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HalfDifference {
    /// Angle between the half vector h and the normal, [0, pi/2].
    pub theta_h: f64,
    /// Angle between i and h, [0, pi/2].
    pub theta_d: f64,
    /// Azimuth of i around h, (-pi, pi]; phi_d and phi_d + pi exchange i and o.
    pub phi_d: f64,
}

impl HalfDifference {
    /// The angles of two unit vectors that are not opposite.
    pub fn from_directions(i: &Direction, o: &Direction) -> Self {
        let h = (i + o).normalize();
        let theta_h = libm::atan2(libm::hypot(h.x, h.y), h.z);
        let half_difference = (i - o).norm() * 0.5;
        let theta_d = libm::asin(half_difference.min(1.0));
        // rotate by -phi_h around z, then by -theta_h around y
        let phi_h = libm::atan2(h.y, h.x);
        let (sin_p, cos_p) = (libm::sin(phi_h), libm::cos(phi_h));
        let (sin_t, cos_t) = (libm::sin(theta_h), libm::cos(theta_h));
        let (x, y) = (cos_p * i.x + sin_p * i.y, cos_p * i.y - sin_p * i.x);
        let phi_d = libm::atan2(y, cos_t * x - sin_t * i.z);
        Self { theta_h, theta_d, phi_d }
    }

    /// The pair (i, o) with these angles and the half vector at azimuth zero; either may lie below the horizon.
    pub fn to_directions(self) -> (Direction, Direction) {
        let (sin_h, cos_h) = (libm::sin(self.theta_h), libm::cos(self.theta_h));
        let place = |phi: f64| {
            let d = direction(self.theta_d, phi);
            Direction::new(cos_h * d.x + sin_h * d.z, d.y, cos_h * d.z - sin_h * d.x)
        };
        (place(self.phi_d), place(self.phi_d + PI))
    }

    /// `(cos theta_i, cos theta_o)`; negative below the horizon.
    pub fn cosines(&self) -> (f64, f64) {
        let same = libm::cos(self.theta_h) * libm::cos(self.theta_d);
        let turn = libm::sin(self.theta_h) * libm::sin(self.theta_d) * libm::cos(self.phi_d);
        (same - turn, same + turn)
    }
}

/// The mirror image of `v` about the unit vector `m`: `2 (v.m) m - v`.
pub fn reflect(v: &Direction, m: &Direction) -> Direction {
    m * (2.0 * v.dot(m)) - v
}

/// A direction with density `cos theta / pi` from two numbers in [0, 1).
pub fn cosine_sample(u: [f64; 2]) -> Direction {
    direction(libm::asin(u[1].sqrt()), TAU * u[0])
}

/// The sine that belongs to a cosine in [0, 1].
pub(crate) fn sine(cos: f64) -> f64 {
    ((1.0 - cos) * (1.0 + cos)).max(0.0).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn angles_and_directions_are_inverse(theta_h in 0.001..1.5_f64, theta_d in 0.001..1.5_f64, phi_d in -3.1..3.1_f64) {
            let angles = HalfDifference { theta_h, theta_d, phi_d };
            let (i, o) = angles.to_directions();
            let back = HalfDifference::from_directions(&i, &o);
            prop_assert!((back.theta_h - theta_h).abs() < 1e-12);
            prop_assert!((back.theta_d - theta_d).abs() < 1e-12);
            prop_assert!((back.phi_d - phi_d).abs() < 1e-9);
            let (cos_i, cos_o) = angles.cosines();
            prop_assert!((cos_i - i.z).abs() < 1e-14 && (cos_o - o.z).abs() < 1e-14);
        }

        #[test]
        fn reflection_keeps_the_half_vector(theta_h in 0.0..1.5_f64, theta in 0.0..1.5_f64, phi in 0.0..6.2_f64) {
            let (i, m) = (direction(theta, phi), direction(theta_h, 0.3));
            let o = reflect(&i, &m);
            prop_assert!((o.norm() - 1.0).abs() < 1e-14);
            prop_assert!((o.dot(&m) - i.dot(&m)).abs() < 1e-14);
        }
    }
}
