//! The GGX distribution of normals, as the proxy that half vectors are drawn from.

use crate::math::direction::{Direction, direction};
use std::f64::consts::{PI, TAU};

/// GGX (Trowbridge-Reitz) of width alpha: `D = alpha^2 / (pi cos^4 theta_h (alpha^2 + tan^2 theta_h)^2)` (Walter 2007).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ggx {
    alpha_square: f64,
}

impl Ggx {
    /// The distribution of width `alpha > 0`.
    pub fn new(alpha: f64) -> Self {
        Self { alpha_square: alpha * alpha }
    }

    /// The width alpha.
    pub fn alpha(&self) -> f64 {
        self.alpha_square.sqrt()
    }

    /// `D` in 1/sr at the cosine of theta_h; zero at and below the horizon.
    pub fn d(&self, cos_theta_h: f64) -> f64 {
        if cos_theta_h <= 0.0 {
            return 0.0;
        }
        // cos^4 (alpha^2 + tan^2)^2 = (1 - cos^2 (1 - alpha^2))^2
        let base = (1.0 - cos_theta_h) * (1.0 + cos_theta_h) + self.alpha_square * cos_theta_h * cos_theta_h;
        self.alpha_square / (PI * base * base)
    }

    /// `D` in 1/sr at `tan^2 theta_h`: keeps full relative precision for small angles, where a cosine has lost it.
    pub fn d_at_tan_square(&self, tan_square: f64) -> f64 {
        let base = (1.0 + tan_square) / (self.alpha_square + tan_square);
        self.alpha_square * base * base / PI
    }

    /// A normal with density `D cos theta_h` from two numbers in [0, 1).
    pub fn sample(&self, u: [f64; 2]) -> Direction {
        let tan = (self.alpha_square * u[1] / (1.0 - u[1])).sqrt();
        direction(libm::atan(tan), TAU * u[0])
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
            assert!((ggx.d_at_tan_square(tan_square) / ggx.d(m.z) - 1.0).abs() < 1e-12);
        }
    }
}
