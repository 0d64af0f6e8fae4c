//! The SGD microfacet model of one colour channel.

use crate::distributions::shifted_gamma::ShiftedGamma;
use crate::masking::curve::G1Curve;
use crate::masking::smith::SmithG1;
use crate::math::direction::HalfDifference;
use crate::models::fresnel::Fresnel;
use std::f64::consts::{FRAC_1_PI, FRAC_PI_2, PI};

/// The six free parameters of one channel (thesis V.3), all dimensionless.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize, schemars::JsonSchema))]
pub struct SgdParameters {
    /// Diffuse albedo.
    pub rho_d: f64,
    /// Specular scale; only its product with the Fresnel term has a meaning of its own.
    pub rho_s: f64,
    /// Width of the distribution, above zero: small is sharp.
    pub alpha: f64,
    /// Exponent of the distribution: large makes the peak sharper than the tail.
    pub p: f64,
    /// Constant term of the generalised Schlick Fresnel term.
    pub f0: f64,
    /// Linear term of the generalised Schlick Fresnel term.
    pub f1: f64,
}

impl SgdParameters {
    /// The Fresnel term of these parameters.
    pub fn fresnel(&self) -> Fresnel {
        Fresnel { f0: self.f0, f1: self.f1 }
    }
}

/// Parameters with which the model cannot be evaluated.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{name} = {value} is outside of the model's domain: {domain}")]
pub struct ParameterError {
    /// Which parameter.
    pub name: &'static str,
    /// Its value.
    pub value: f64,
    /// What it may be.
    pub domain: &'static str,
}

/// What the model needs to know of a pair of directions.
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

/// The SGD model of one channel with Smith's exact masking:
///
/// `f(i, o) = [rho_d + rho_s F(theta_d) D(theta_h) G1(theta_i) G1(theta_o) / (cos theta_i cos theta_o)] / pi`
///
/// in 1/sr (thesis V.3.1: no factor 1/4). Values within 1e-11 relative of mpmath (`data-fixtures/sgd.json`).
#[derive(Clone, Copy, Debug)]
pub struct Sgd {
    parameters: SgdParameters,
    distribution: ShiftedGamma,
    smith: SmithG1,
}

impl Sgd {
    /// The model with these parameters.
    ///
    /// # Errors
    /// Where a parameter is not finite, alpha is outside of [1e-12, 100], p is outside of (-90, 20), rho_d is negative, or K is not finite.
    pub fn new(parameters: SgdParameters) -> Result<Self, ParameterError> {
        let SgdParameters { rho_d, rho_s, alpha, p, f0, f1 } = parameters;
        let check = |name, value: f64, inside: bool, domain| {
            if inside && value.is_finite() { Ok(()) } else { Err(ParameterError { name, value, domain }) }
        };
        check("rho_d", rho_d, rho_d >= 0.0, "finite and not negative")?;
        check("rho_s", rho_s, true, "finite")?;
        check("f0", f0, true, "finite")?;
        check("f1", f1, true, "finite")?;
        check("p", p, p > -90.0 && p < 20.0, "between -90 and 20")?;
        let distribution = ShiftedGamma::new(alpha, p);
        check("alpha", alpha, distribution.is_some(), "between 1e-12 and 100, with a finite normalisation")?;
        let distribution = distribution.expect("checked above");
        Ok(Self { parameters, distribution, smith: SmithG1::new(&distribution) })
    }

    /// The six parameters.
    pub fn parameters(&self) -> &SgdParameters {
        &self.parameters
    }

    /// The distribution of normals.
    pub fn distribution(&self) -> &ShiftedGamma {
        &self.distribution
    }

    /// The exact masking function.
    pub fn smith(&self) -> &SmithG1 {
        &self.smith
    }

    /// `f` in 1/sr; zero where either direction is at or below the horizon.
    pub fn value(&self, at: &Configuration) -> f64 {
        if at.cos_theta_i <= 0.0 || at.cos_theta_o <= 0.0 {
            return 0.0;
        }
        let fresnel = self.parameters.fresnel().value(at.cos_theta_d);
        let masked = |cos: f64| self.smith.g1_from(cos, sine(cos)) / cos;
        (self.parameters.rho_d
            + self.parameters.rho_s * fresnel * self.d(at) * masked(at.cos_theta_i) * masked(at.cos_theta_o))
            * FRAC_1_PI
    }

    /// `f` in 1/sr and its derivatives with respect to rho_d, rho_s, alpha, p, f0, f1 in this order.
    pub fn value_and_gradient(&self, at: &Configuration) -> (f64, [f64; 6]) {
        if at.cos_theta_i <= 0.0 || at.cos_theta_o <= 0.0 {
            return (0.0, [0.0; 6]);
        }
        let SgdParameters { rho_d, rho_s, .. } = self.parameters;
        let fresnel = self.parameters.fresnel().value(at.cos_theta_d);
        let (by_f0, by_f1) = Fresnel::derivatives(at.cos_theta_d);
        let (g_i, g_i_slopes) = self.smith.g1_with_slopes(libm::acos(at.cos_theta_i.min(1.0)));
        let (g_o, g_o_slopes) = self.smith.g1_with_slopes(libm::acos(at.cos_theta_o.min(1.0)));
        let shape = self.d(at) * g_i * g_o / (at.cos_theta_i * at.cos_theta_o) * FRAC_1_PI;
        let d_slopes = self.distribution.ln_slopes(at.tan_square_h);
        // d ln(D G1 G1) / d(alpha, p)
        let ln_slope = |n: usize| d_slopes[n] + g_i_slopes[n] / g_i + g_o_slopes[n] / g_o;
        let value = rho_d * FRAC_1_PI + rho_s * fresnel * shape;
        let gradient = [
            FRAC_1_PI,
            fresnel * shape,
            rho_s * fresnel * shape * ln_slope(0),
            rho_s * fresnel * shape * ln_slope(1),
            rho_s * shape * by_f0,
            rho_s * shape * by_f1,
        ];
        (value, gradient)
    }

    /// `D` in 1/sr from `tan^2 theta_h`: `1 / cos^4 = (1 + tan^2)^2`.
    fn d(&self, at: &Configuration) -> f64 {
        let secant_square = 1.0 + at.tan_square_h;
        self.distribution.p22(at.tan_square_h) * secant_square * secant_square / PI
    }
}

/// The sine that belongs to a cosine in [0, 1].
pub(crate) fn sine(cos: f64) -> f64 {
    ((1.0 - cos) * (1.0 + cos)).max(0.0).sqrt()
}

/// Directional albedo of one channel at theta_i in radians: the integral of `f cos theta_o` over the outgoing hemisphere.
///
/// The diffuse part is exact; the specular part is integrated over the half vector by the double-exponential rule of the
/// masking function in `tan^2 theta_h / alpha` and the midpoint rule with 32 azimuths. `curve` is the channel's own masking. Within 1e-4 absolute of an
/// independent quadrature (`data-fixtures/albedo.json`).
pub fn directional_albedo(sgd: &Sgd, curve: &G1Curve, theta_i: f64) -> f64 {
    const AZIMUTHS: u32 = 32;
    let cos_i = libm::cos(theta_i);
    if !(0.0..FRAC_PI_2).contains(&theta_i) {
        return 0.0;
    }
    let sin_i = libm::sin(theta_i);
    let (alpha, p) = (sgd.distribution.alpha(), sgd.distribution.p());
    let ln_density = sgd.distribution.ln_k() + libm::log(alpha) - alpha;
    let fresnel = sgd.parameters.fresnel();
    let cosines: Vec<f64> = (0..AZIMUTHS).map(|n| libm::cos(PI * (f64::from(n) + 0.5) / f64::from(AZIMUTHS))).collect();
    let mut specular = 0.0;
    for (t, weight) in crate::masking::smith::laguerre_rule() {
        // x = tan^2 theta_h = alpha t;  P22(x) dx = alpha K e^(-alpha) e^(-t) (alpha + t)^(-p) dt
        let density = libm::exp(ln_density - p * libm::log(alpha + t)) * weight;
        let cos_h = 1.0 / (1.0 + alpha * t).sqrt();
        let sin_h = (alpha * t).sqrt() * cos_h;
        if density < 1e-10 {
            continue;
        }
        let mut ring = 0.0;
        for cos_phi in &cosines {
            let cos_d = cos_i * cos_h + sin_i * sin_h * cos_phi;
            let cos_o = 2.0 * cos_d * cos_h - cos_i;
            if cos_d <= 0.0 || cos_o <= 0.0 {
                continue;
            }
            let sin_o = sine(cos_o);
            let masking = if sin_o > 0.0 {
                cos_o * curve.g1_over_cos(cos_o, sin_o, G1Curve::position(cos_o, sin_o))
            } else {
                1.0
            };
            ring += fresnel.value(cos_d) * masking * cos_d;
        }
        specular += density / cos_h * ring / f64::from(AZIMUTHS);
    }
    sgd.parameters.rho_d + 4.0 * sgd.parameters.rho_s * sgd.smith.g1(theta_i) / (PI * cos_i) * specular
}

#[cfg(test)]
mod tests {
    use super::*;

    const METAL: SgdParameters = SgdParameters { rho_d: 0.03, rho_s: 0.6, alpha: 0.03, p: 0.45, f0: 0.24, f1: 0.18 };

    #[test]
    fn reciprocity_and_the_horizon() {
        let sgd = Sgd::new(METAL).unwrap();
        let angles = HalfDifference { theta_h: 0.2, theta_d: 0.9, phi_d: 0.7 };
        let swapped = HalfDifference { phi_d: 0.7 + PI, ..angles };
        let (a, b) = (sgd.value(&angles.into()), sgd.value(&swapped.into()));
        assert!((a / b - 1.0).abs() < 1e-12);
        let below = HalfDifference { theta_h: 1.2, theta_d: 0.9, phi_d: 0.1 };
        assert_eq!(sgd.value(&below.into()), 0.0);
    }

    #[test]
    fn a_diffuse_channel_has_the_albedo_rho_d() {
        let sgd = Sgd::new(SgdParameters { rho_d: 0.4, rho_s: 0.0, ..METAL }).unwrap();
        for theta in [0.0, 0.7, 1.4] {
            assert!((directional_albedo(&sgd, &G1Curve::new(sgd.distribution()), theta) - 0.4).abs() < 1e-15);
        }
    }

    #[test]
    fn parameters_outside_of_the_domain_are_named() {
        let refused = |parameters| Sgd::new(parameters).unwrap_err().name;
        assert_eq!(refused(SgdParameters { alpha: 0.0, ..METAL }), "alpha");
        assert_eq!(refused(SgdParameters { alpha: f64::NAN, ..METAL }), "alpha");
        assert_eq!(refused(SgdParameters { p: 1e9, ..METAL }), "p");
        assert_eq!(refused(SgdParameters { rho_d: -1.0, ..METAL }), "rho_d");
        assert_eq!(refused(SgdParameters { f1: f64::INFINITY, ..METAL }), "f1");
    }
}
