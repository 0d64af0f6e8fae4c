//! The SGD model in single precision, as a renderer evaluates it.

use crate::masking::closed_form::G1ClosedForm;
use crate::models::fresnel::fifth;
use crate::models::sgd::{ParameterError, Sgd, SgdParameters};

/// One channel in f32 with the closed form of `G1`, all constants folded.
///
/// Against [`Sgd`] in f64 with the same closed form: relative error below 2e-4 where `f` is above 1e-3 of its peak and both
/// angles are below 89 degrees, alpha at least 1e-6; what the closed form itself costs comes on top and is in the fit's document.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RenderSgd {
    diffuse: f32,
    /// `ln(rho_s K / pi^2)`; the sign of rho_s is in `sign`.
    ln_specular: f32,
    sign: f32,
    alpha: f32,
    inverse_alpha: f32,
    p: f32,
    f0: f32,
    f1: f32,
    masking: RenderG1,
}

#[derive(Clone, Copy, Debug, PartialEq)]
struct RenderG1 {
    lambda: f32,
    theta0: f32,
    inverse_span: f32,
    k: f32,
    growth: f32,
}

impl RenderG1 {
    fn new(form: &G1ClosedForm) -> Self {
        Self {
            lambda: form.lambda as f32,
            theta0: form.theta0 as f32,
            inverse_span: (1.0 / (std::f64::consts::FRAC_PI_2 - form.theta0)) as f32,
            k: form.k as f32,
            growth: libm::log1p(1.0 / form.lambda) as f32,
        }
    }

    fn g1(&self, cos_theta: f32) -> f32 {
        let t = (libm::acosf(cos_theta.min(1.0)) - self.theta0) * self.inverse_span;
        if t <= 0.0 {
            return 1.0;
        }
        (1.0 - self.lambda * libm::expm1f(self.growth * libm::powf(t, self.k))).clamp(0.0, 1.0)
    }
}

impl RenderSgd {
    /// The channel with these parameters and this closed form of its masking function.
    ///
    /// # Errors
    /// As [`Sgd::new`].
    pub fn new(parameters: SgdParameters, form: &G1ClosedForm) -> Result<Self, ParameterError> {
        let sgd = Sgd::new(parameters)?;
        let pi = std::f64::consts::PI;
        Ok(Self {
            diffuse: (parameters.rho_d / pi) as f32,
            ln_specular: (libm::log(parameters.rho_s.abs() / (pi * pi)) + sgd.distribution().ln_k()) as f32,
            sign: if parameters.rho_s == 0.0 { 0.0 } else { parameters.rho_s.signum() as f32 },
            alpha: parameters.alpha as f32,
            inverse_alpha: (1.0 / parameters.alpha) as f32,
            p: parameters.p as f32,
            f0: parameters.f0 as f32,
            f1: parameters.f1 as f32,
            masking: RenderG1::new(form),
        })
    }

    /// `f` in 1/sr from `tan^2 theta_h`, `cos theta_d`, `cos theta_i` and `cos theta_o`; zero at and below the horizon.
    ///
    /// Take `tan^2 theta_h` as `(h.x^2 + h.y^2) / h.z^2`: from the cosine alone it has no digits left near the peak.
    pub fn value(&self, tan_square_h: f32, cos_theta_d: f32, cos_theta_i: f32, cos_theta_o: f32) -> f32 {
        if cos_theta_i <= 0.0 || cos_theta_o <= 0.0 {
            return 0.0;
        }
        let a = self.alpha + tan_square_h * self.inverse_alpha;
        let secant = 1.0 + tan_square_h;
        let fresnel = self.f0 - self.f1 * cos_theta_d + (1.0 - self.f0) * fifth(f64::from(1.0 - cos_theta_d)) as f32;
        let lobe = libm::expf(self.ln_specular - a - self.p * libm::logf(a)) * secant * secant;
        let masking = self.masking.g1(cos_theta_i) * self.masking.g1(cos_theta_o) / (cos_theta_i * cos_theta_o);
        if self.sign == 0.0 { self.diffuse } else { self.diffuse + self.sign * fresnel * lobe * masking }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::direction::HalfDifference;
    use crate::models::sgd::Configuration;

    #[test]
    fn stays_close_to_double_precision() {
        let form = G1ClosedForm { lambda: 0.3, theta0: 0.2, k: 9.0 };
        let mut worst: f64 = 0.0;
        for (alpha, p) in [(1e-6, 0.4), (1e-4, 1.5), (0.01, 0.6), (0.3, 0.1)] {
            let parameters = SgdParameters { rho_d: 0.1, rho_s: 0.5, alpha, p, f0: 0.2, f1: -0.1 };
            let (sgd, render) = (Sgd::new(parameters).unwrap(), RenderSgd::new(parameters, &form).unwrap());
            for theta_h in [0.0, 0.3 * alpha, alpha, 0.3 * alpha.sqrt(), alpha.sqrt()] {
                for theta_d in [0.0, 0.5, 1.1, 1.5] {
                    let at = Configuration::from(HalfDifference { theta_h, theta_d, phi_d: 1.4 });
                    if at.cos_theta_i.min(at.cos_theta_o) < 89f64.to_radians().cos() {
                        continue;
                    }
                    let g1 = |cos: f64| form.g1(libm::acos(cos));
                    let exact = parameters.rho_d / std::f64::consts::PI
                        + parameters.rho_s
                            * parameters.fresnel().value(at.cos_theta_d)
                            * sgd.distribution().d_at(theta_h)
                            * g1(at.cos_theta_i)
                            * g1(at.cos_theta_o)
                            / (std::f64::consts::PI * at.cos_theta_i * at.cos_theta_o);
                    let value = render.value(
                        at.tan_square_h as f32,
                        at.cos_theta_d as f32,
                        at.cos_theta_i as f32,
                        at.cos_theta_o as f32,
                    );
                    worst = worst.max((f64::from(value) / exact - 1.0).abs());
                }
            }
        }
        println!("largest relative error of the f32 evaluation: {worst:.2e}");
        assert!(worst < 2e-4, "{worst}");
    }
}
