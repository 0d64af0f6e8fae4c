//! The GGX microfacet model.

use crate::distributions::ggx::Ggx;
use crate::models::microfacet::MicrofacetParameters;
use crate::models::microfacet_material::{MicrofacetMaterial, channels, specular_share};
use crate::models::parameter::ParameterError;

/// Three GGX channels (R, G, B), `f(i, o) = rho_d / pi + rho_s F D G1 G1 / (4 cos theta_i cos theta_o)` in 1/sr (Walter et
/// al. 2007, eq. 20) with the generalised Schlick term.
pub type GgxMaterial = MicrofacetMaterial<Ggx, 1>;

impl GgxMaterial {
    /// One lobe of width alpha for all channels and without a Fresnel term (F = 1): what a scene describes by hand. Up to
    /// `rho_s = 1 - rho_d` no more is reflected than received.
    ///
    /// # Errors
    /// If a scale is not finite, rho_d is negative, or alpha lies outside of [`Ggx::ALPHA_RANGE`].
    pub fn without_fresnel(rho_d: [f64; 3], rho_s: [f64; 3], alpha: f64) -> Result<Self, ParameterError> {
        let of = |c: usize| MicrofacetParameters { rho_d: rho_d[c], rho_s: rho_s[c], shape: [alpha], f0: 1.0, f1: 0.0 };
        let channels = channels([0, 1, 2].map(of))?;
        // one distribution is drawn from; its share by the scales, which are albedos but for masking
        Ok(Self::with_shares(channels, [specular_share(rho_s, rho_d), 0.0, 0.0]))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::brdf::Brdf;
    use crate::distributions::normal_distribution::NormalDistribution;
    use crate::masking::masking::Masking;
    use crate::math::direction::{Direction, direction, reflect};
    use proptest::prelude::*;
    use std::f64::consts::{FRAC_1_PI, FRAC_PI_2, PI, TAU};

    fn mirror(alpha: f64) -> GgxMaterial {
        GgxMaterial::without_fresnel([0.0; 3], [1.0; 3], alpha).unwrap()
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
        for alpha in [0.02, 0.2, 0.8] {
            for theta in [0.0, 0.8, 1.4] {
                let i = direction(theta, 0.0);
                let seen = over_half_vectors(|h| {
                    i.dot(h).max(0.0) * Ggx::new(alpha).d_at_tan_square((1.0 - h.z * h.z) / (h.z * h.z))
                });
                let covered = Ggx::new(alpha).g1_over_cos(i.z, libm::sin(theta), 0.0) * seen;
                assert!((covered - 1.0).abs() < 1e-3, "alpha {alpha} theta {theta}: {covered}");
            }
        }
    }

    #[test]
    fn no_more_is_reflected_than_received() {
        for alpha in [0.02, 0.2, 0.8] {
            for theta in [0.0, 0.8, 1.4] {
                let i = direction(theta, 0.0);
                // int f cos theta_o do with do = 4 i.h dh
                let albedo = over_half_vectors(|h| {
                    let o = reflect(&i, h);
                    mirror(alpha).value(&i, &o)[0] * o.z.max(0.0) * 4.0 * i.dot(h).max(0.0)
                });
                assert!(albedo < 1.001, "alpha {alpha} theta {theta}: {albedo}");
                // what single scattering loses is little on a smooth surface
                assert!(alpha > 0.1 || theta > 1.0 || albedo > 0.99, "alpha {alpha} theta {theta}: {albedo}");
            }
        }
    }

    #[test]
    fn samples_follow_the_density() {
        // means over samples against means over the density
        let model = GgxMaterial::without_fresnel([0.2, 0.1, 0.0], [0.5, 0.6, 0.7], 0.3).unwrap();
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
        let model = GgxMaterial::without_fresnel([0.1, 0.2, 0.3], [0.0; 3], 0.1).unwrap();
        let (i, o) = (direction(0.3, 0.0), direction(1.2, 2.0));
        assert_eq!(model.value(&i, &o), [0.1, 0.2, 0.3].map(|albedo| albedo * FRAC_1_PI));
        assert_eq!(model.pdf(&i, &o), o.z * FRAC_1_PI);
        assert!(model.sample(&i, [0.1, 0.2, 0.0]).is_some());
    }

    proptest! {
        #[test]
        fn exchanging_the_directions_changes_nothing(
            alpha in 0.01..1.0_f64, a in 0.0..1.57_f64, b in 0.0..1.57_f64, phi in 0.0..PI
        ) {
            let (i, o) = (direction(a, 0.0), direction(b, phi));
            let model = mirror(alpha);
            prop_assert_eq!(model.value(&i, &o), model.value(&o, &i));
            prop_assert!(model.pdf(&i, &o) > 0.0);
        }
    }

    #[test]
    fn a_width_of_zero_is_refused() {
        let error = GgxMaterial::without_fresnel([0.1; 3], [0.5; 3], 0.0).unwrap_err();
        assert_eq!(error.to_string(), "alpha = 0 is outside of the model's domain: between 1e-4 and 10");
    }
}
