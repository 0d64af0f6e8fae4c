//! The GGX microfacet model.

use crate::batch::ggx_shading::GgxShading;
use crate::batch::shading::Shading;
use crate::brdf::{Brdf, cosine_sample};
use crate::distributions::ggx::Ggx;
use crate::math::direction::{Direction, reflect};
use crate::models::sgd::sine;
use std::f64::consts::FRAC_1_PI;

/// GGX in Cook-Torrance's form with Smith's exact masking of either direction and without a Fresnel term (F = 1):
///
/// `f(i, o) = rho_d / pi + rho_s D(theta_h) G1(theta_i) G1(theta_o) / (4 cos theta_i cos theta_o)`,
/// `D = m^2 / (pi cos^4 theta_h (m^2 + tan^2 theta_h)^2)`, `G1 = 2 / (1 + sqrt(1 + m^2 tan^2 theta))`
///
/// in 1/sr (Walter et al. 2007, eq. 20, 33 and 34). Half vectors are drawn from `D cos theta_h`, mixed with a cosine lobe.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GgxBrdf {
    /// Diffuse albedo per channel, at least zero.
    pub rho_d: [f64; 3],
    /// Specular scale per channel, at least zero; up to `1 - rho_d` no more is reflected than received.
    pub rho_s: [f64; 3],
    /// Width of the distribution, above zero: the root of the median of `tan^2 theta_h`.
    pub m: f64,
}

impl GgxBrdf {
    /// `G1 / cos theta` at a cosine above zero, finite up to the horizon.
    fn g1_over_cos(&self, cos: f64) -> f64 {
        let slope = self.m * sine(cos);
        2.0 / (cos + (cos * cos + slope * slope).sqrt())
    }

    /// Probability of the specular lobe; the rest goes to the cosine lobe.
    pub(crate) fn specular_share(&self) -> f64 {
        let [diffuse, specular] = [self.rho_d, self.rho_s].map(|scale| scale.iter().sum::<f64>());
        if specular > 0.0 { (specular / (specular + diffuse)).clamp(0.1, 0.95) } else { 0.0 }
    }
}

impl Brdf for GgxBrdf {
    fn value(&self, i: &Direction, o: &Direction) -> [f64; 3] {
        if i.z <= 0.0 || o.z <= 0.0 {
            return [0.0; 3];
        }
        let h = i + o;
        let d = Ggx::new(self.m).d_at_tan_square((h.x * h.x + h.y * h.y) / (h.z * h.z));
        let lobe = 0.25 * d * (self.g1_over_cos(i.z) * self.g1_over_cos(o.z));
        [0, 1, 2].map(|c: usize| self.rho_d[c] * FRAC_1_PI + self.rho_s[c] * lobe)
    }

    fn sample(&self, i: &Direction, u: [f64; 3]) -> Option<Direction> {
        if u[2] >= self.specular_share() {
            return Some(cosine_sample([u[0], u[1]]));
        }
        let o = reflect(i, &Ggx::new(self.m).sample([u[0], u[1]]));
        (o.z > 0.0).then_some(o)
    }

    fn pdf(&self, i: &Direction, o: &Direction) -> f64 {
        if i.z <= 0.0 || o.z <= 0.0 {
            return 0.0;
        }
        let (h, share) = (i + o, self.specular_share());
        // cos theta_h / (4 i.h) with h of length one; |i + o| = 2 i.h
        let jacobian = h.z / (2.0 * h.norm_squared());
        let d = Ggx::new(self.m).d_at_tan_square((h.x * h.x + h.y * h.y) / (h.z * h.z));
        share * d * jacobian + (1.0 - share) * o.z * FRAC_1_PI
    }

    fn shading(&self) -> Box<dyn Shading + '_> {
        Box::new(GgxShading::new(self.rho_d, self.rho_s, self.m, self.specular_share()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::direction::direction;
    use proptest::prelude::*;
    use std::f64::consts::{FRAC_PI_2, PI, TAU};

    fn mirror(m: f64) -> GgxBrdf {
        GgxBrdf { rho_d: [0.0; 3], rho_s: [1.0; 3], m }
    }

    /// Integral over half vectors by the midpoint rule, in `theta_h = pi/2 s^3` where sharp lobes are resolved.
    fn over_half_vectors(integrand: impl Fn(&Direction) -> f64) -> f64 {
        let (rings, azimuths) = (2000, 128);
        let mut sum = 0.0;
        for ring in 0..rings {
            let s = (f64::from(ring) + 0.5) / f64::from(rings);
            let theta = FRAC_PI_2 * s.powi(3);
            let area = libm::sin(theta) * 3.0 * FRAC_PI_2 * s * s / f64::from(rings) * TAU / f64::from(azimuths);
            for n in 0..azimuths {
                sum += area * integrand(&direction(theta, TAU * (f64::from(n) + 0.5) / f64::from(azimuths)));
            }
        }
        sum
    }

    #[test]
    fn visible_normals_cover_the_projected_surface() {
        // int G1(i) max(i.h, 0) D(h) dh = cos theta_i defines Smith's G1 of D
        for m in [0.02, 0.2, 0.8] {
            for theta in [0.0, 0.8, 1.4] {
                let i = direction(theta, 0.0);
                let seen = over_half_vectors(|h| i.dot(h).max(0.0) * Ggx::new(m).d(h.z));
                let covered = mirror(m).g1_over_cos(i.z) * seen;
                assert!((covered - 1.0).abs() < 1e-3, "m {m} theta {theta}: {covered}");
            }
        }
    }

    #[test]
    fn no_more_is_reflected_than_received() {
        for m in [0.02, 0.2, 0.8] {
            for theta in [0.0, 0.8, 1.4] {
                let i = direction(theta, 0.0);
                // int f cos theta_o do with do = 4 i.h dh
                let albedo = over_half_vectors(|h| {
                    let o = reflect(&i, h);
                    mirror(m).value(&i, &o)[0] * o.z.max(0.0) * 4.0 * i.dot(h).max(0.0)
                });
                assert!(albedo < 1.001, "m {m} theta {theta}: {albedo}");
                // what single scattering loses is little on a smooth surface
                assert!(m > 0.1 || theta > 1.0 || albedo > 0.99, "m {m} theta {theta}: {albedo}");
            }
        }
    }

    #[test]
    fn samples_follow_the_density() {
        // means over samples against means over the density
        let model = GgxBrdf { rho_d: [0.2, 0.1, 0.0], rho_s: [0.5, 0.6, 0.7], m: 0.3 };
        for theta in [0.2, 1.1] {
            let i = direction(theta, 0.5);
            let side = 500;
            let mut drawn = [0.0; 3];
            for n in 0..side * side {
                let place = |n: u32| (f64::from(n) + 0.5) / f64::from(side);
                let u = [place(n % side), place(n / side), (f64::from(n) * 0.618_033_988_749_895).fract()];
                if let Some(o) = model.sample(&i, u) {
                    let weight = 1.0 / f64::from(side * side);
                    drawn = [drawn[0] + weight, drawn[1] + weight * o.x, drawn[2] + weight * o.z * o.z];
                }
            }
            for (n, drawn) in drawn.into_iter().enumerate() {
                let expected = over_half_vectors(|h| {
                    let o = reflect(&i, h);
                    model.pdf(&i, &o) * 4.0 * i.dot(h).max(0.0) * [1.0, o.x, o.z * o.z][n]
                });
                assert!((drawn - expected).abs() < 3e-3, "theta {theta} moment {n}: {drawn} {expected}");
            }
        }
    }

    #[test]
    fn without_a_specular_part_it_is_lamberts() {
        let model = GgxBrdf { rho_d: [0.1, 0.2, 0.3], rho_s: [0.0; 3], m: 0.1 };
        let (i, o) = (direction(0.3, 0.0), direction(1.2, 2.0));
        assert_eq!(model.value(&i, &o), [0.1, 0.2, 0.3].map(|albedo| albedo * FRAC_1_PI));
        assert_eq!(model.pdf(&i, &o), o.z * FRAC_1_PI);
        assert!(model.sample(&i, [0.1, 0.2, 0.0]).is_some());
    }

    proptest! {
        #[test]
        fn exchanging_the_directions_changes_nothing(
            m in 0.01..1.0_f64, a in 0.0..1.57_f64, b in 0.0..1.57_f64, phi in 0.0..PI
        ) {
            let (i, o) = (direction(a, 0.0), direction(b, phi));
            let model = mirror(m);
            prop_assert_eq!(model.value(&i, &o), model.value(&o, &i));
            prop_assert!(model.pdf(&i, &o) > 0.0);
        }
    }
}
