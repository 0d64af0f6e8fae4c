//! Transport of bandwidth along a path (Bagher et al. 2013, figure 4 and equations 3 and 4).
//!
//! A local light field has a bandwidth in space, cycles per world unit, and one in angle, cycles per radian. Signs are kept along
//! the path: shears add up or cancel.

use nalgebra::{Matrix2, Vector2};

/// Spatial (cycles per world unit) and angular (cycles per radian) bandwidth.
pub(crate) type LocalBandwidth = Vector2<f32>;

/// The largest bandwidth that the published operators pass on: they break at the infinite one of an edge.
pub(crate) const LARGEST: f32 = 1e4;

/// Transport over the distance `d`, world units: an angular shear.
#[must_use]
pub(crate) fn free_space(d: f32) -> Matrix2<f32> {
    Matrix2::new(1.0, 0.0, -d, 1.0)
}

/// From the light's frame to that of a surface, whose normal makes the angle with this cosine with the path.
#[must_use]
pub(crate) fn onto_surface(cos_theta_i: f32) -> Matrix2<f32> {
    Matrix2::new(cos_theta_i, 0.0, 0.0, 1.0)
}

/// From the frame of a surface to that of the outgoing path: the inverse of [`onto_surface`].
#[must_use]
pub(crate) fn off_surface(cos_theta_x: f32) -> Matrix2<f32> {
    Matrix2::new(1.0 / cos_theta_x, 0.0, 0.0, 1.0)
}

/// From a plane to a surface of normal curvature `c`, 1 per world unit: a spatial shear.
#[must_use]
pub(crate) fn curvature(c: f32) -> Matrix2<f32> {
    Matrix2::new(1.0, c, 0.0, 1.0)
}

/// Mirror reflection.
#[must_use]
pub(crate) fn mirror() -> Matrix2<f32> {
    Matrix2::new(1.0, 0.0, 0.0, -1.0)
}

/// Band limit of the BRDF on reflected light.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum BandLimit {
    /// The spectrum is a segment along nu, so a cut of its angular part shortens the whole of it:
    /// `B nu = min(1, rho / |nu_a|) nu + (t, 0)`, the sign of nu_s on t.
    Segment,
    /// As published: `B nu = (nu_s + t, min(rho, nu_a))`; what is cut in angle remains in space.
    Published,
}

impl BandLimit {
    /// Reflection of the bandwidth `nu` by a BRDF of angular bandwidth `rho` and a texture of spatial bandwidth `t`.
    #[must_use]
    pub(crate) fn apply(self, nu: LocalBandwidth, rho: f32, t: f32) -> LocalBandwidth {
        match self {
            Self::Segment => {
                let share = if nu.y.abs() > rho { rho / nu.y.abs() } else { 1.0 };
                Vector2::new(share * nu.x + t.copysign(nu.x), share * nu.y)
            }
            Self::Published => Vector2::new(nu.x + t, nu.y.abs().min(rho).copysign(nu.y)),
        }
    }
}

/// The events of a path between the light and the eye.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Bounce {
    /// Distance from the light to the surface, world units; has no effect on a distant light.
    pub(crate) d: f32,
    /// Distance from the surface to the eye, world units.
    pub(crate) d_eye: f32,
    /// Normal curvature of the surface, 1 per world unit, convex above zero.
    pub(crate) c: f32,
    /// Cosine of the angle of incidence.
    pub(crate) cos_theta_i: f32,
    /// Cosine of the angle of the path to the eye with the normal.
    pub(crate) cos_theta_x: f32,
    /// Angular bandwidth of the BRDF for these directions, cycles per radian.
    pub(crate) rho: f32,
    /// Spatial bandwidth of the texture, cycles per world unit.
    pub(crate) t: f32,
}

impl Bounce {
    /// Bandwidth at the eye of what leaves the light with `nu`: `T_d' R S T_d nu` with `R = P_x C_-c S B C_c P_i`.
    ///
    /// The first S is not in equation (4): a surface describes what arrives by directions towards the light, against the way that
    /// it travels. Without it a flat mirror would undo the transport from the light, `|d - d'|` instead of `d + d'`. A distant
    /// light is the same with and without.
    #[must_use]
    pub(crate) fn transport(&self, nu: LocalBandwidth, limit: BandLimit) -> LocalBandwidth {
        let arriving = curvature(self.c) * onto_surface(self.cos_theta_i) * mirror() * free_space(self.d) * nu;
        let leaving = off_surface(self.cos_theta_x) * curvature(-self.c) * mirror();
        free_space(self.d_eye) * leaving * limit.apply(arriving, self.rho, self.t)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn bounce(c: f32, rho: f32) -> Bounce {
        Bounce { d: 3.0, d_eye: 5.0, c, cos_theta_i: 0.6, cos_theta_x: 0.8, rho, t: 0.0 }
    }

    proptest! {
        #[test]
        fn a_distant_light_follows_the_closed_form(c in -2.0_f32..2.0, rho in 0.1_f32..50.0, light in 0.1_f32..50.0) {
            // |nu_a| = min(rho, nu_light) |1 + 2 d' c / cos theta_x|
            let ours = bounce(c, rho).transport(Vector2::new(0.0, light), BandLimit::Segment).y.abs();
            let expected = rho.min(light) * (1.0 + 2.0 * 5.0 * c / 0.8).abs();
            prop_assert!((ours - expected).abs() <= 1e-4 * (1.0 + expected), "{} {}", ours, expected);
        }

        #[test]
        fn the_published_limit_lets_the_light_pass_into_space(c in 0.0_f32..2.0, rho in 0.1_f32..50.0, light in 0.1_f32..50.0) {
            // m + d' c (nu_light + m) / cos theta_x
            let ours = bounce(c, rho).transport(Vector2::new(0.0, light), BandLimit::Published).y.abs();
            let m = rho.min(light);
            let expected = m + 5.0 * c * (light + m) / 0.8;
            prop_assert!((ours / expected - 1.0).abs() < 1e-4, "{} {}", ours, expected);
        }

        #[test]
        fn both_limits_agree_below_the_limit(c in -2.0_f32..2.0, nu_s in -9.0_f32..9.0, nu_a in -9.0_f32..9.0) {
            let nu = Vector2::new(nu_s, nu_a);
            let rho = 1e6;
            let (a, b) = (bounce(c, rho).transport(nu, BandLimit::Segment), bounce(c, rho).transport(nu, BandLimit::Published));
            prop_assert!((a - b).norm() <= 1e-4 * (1.0 + a.norm()));
        }
    }

    #[test]
    fn a_flat_mirror_passes_everything_on() {
        // without curvature the light is seen as if it were as far away as the whole path
        let flat = Bounce { cos_theta_x: 0.6, ..bounce(0.0, 1e6) };
        let seen = flat.transport(Vector2::new(2.0, 0.0), BandLimit::Segment);
        let unfolded = free_space(8.0) * Vector2::new(2.0, 0.0);
        assert!((seen.y.abs() - unfolded.y.abs()).abs() < 1e-4, "{seen} {unfolded}");
    }

    #[test]
    fn a_convex_mirror_shows_a_local_light_smaller() {
        // paraxial mirror equation 1/d_image = 1/d + 2 c: the image lies behind the mirror and is smaller by d_image / d, so at
        // the eye its detail of spacing 1/nu_s spans 1 / (nu_s (d/d_image) (d' + d_image)) radians
        let (c, d, d_eye, nu_s) = (0.4, 3.0, 5.0, 2.0);
        let mirror = Bounce { d, d_eye, c, cos_theta_i: 1.0, cos_theta_x: 1.0, rho: 1e6, t: 0.0 };
        let image = 1.0 / (1.0 / d + 2.0 * c);
        let expected = nu_s * d / image * (d_eye + image);
        let seen = mirror.transport(Vector2::new(nu_s, 0.0), BandLimit::Segment).y.abs();
        assert!((seen / expected - 1.0).abs() < 1e-5, "{seen} {expected}");
    }

    #[test]
    fn an_edge_of_the_light_takes_the_bandwidth_of_the_material() {
        let seen = bounce(0.0, 7.0).transport(Vector2::new(0.0, LARGEST), BandLimit::Segment);
        assert!((seen.y.abs() - 7.0).abs() < 1e-4);
    }
}
