//! The closed form that approximates Smith's `G1` in renderers.

use std::f64::consts::{FRAC_PI_2, LN_10};

/// `G1 ~ 1 + lambda (1 - exp(c (theta - theta0)^k))` beyond theta0 and 1 below (thesis eq. V.3), held in the well-scaled form
///
/// `t = (theta - theta0) / (pi/2 - theta0)`, `G1 ~ 1 + lambda (1 - (1 + 1/lambda)^(t^k))`,
///
/// which reaches 0 at pi/2 by construction and does not contain `c = ln(1 + 1/lambda) / (pi/2 - theta0)^k`, a number that
/// reaches 1e109. How close it is to the integral depends on the parameters; the fit reports its error beside them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct G1ClosedForm {
    /// Depth parameter, above zero.
    pub lambda: f64,
    /// Angle in radians up to which there is no masking; may be negative.
    pub theta0: f64,
    /// Exponent, above zero.
    pub k: f64,
}

impl G1ClosedForm {
    /// The form from the published parametrisation (lambda, c, k) of which theta0 follows.
    pub fn from_published(lambda: f64, c: f64, k: f64) -> Self {
        let theta0 = FRAC_PI_2 - libm::exp(libm::log(libm::log1p(1.0 / lambda) / c) / k);
        Self { lambda, theta0, k }
    }

    /// `G1` at theta in radians, in [0, 1].
    pub fn g1(&self, theta: f64) -> f64 {
        if theta >= FRAC_PI_2 {
            return 0.0;
        }
        let t = (theta - self.theta0) / (FRAC_PI_2 - self.theta0);
        if t <= 0.0 {
            return 1.0;
        }
        let growth = libm::log1p(1.0 / self.lambda) * libm::pow(t, self.k);
        (1.0 - self.lambda * libm::expm1(growth)).clamp(0.0, 1.0)
    }

    /// `log10 c` of the published parametrisation; `c` itself does not fit in an f32 and rarely in a shader's constants.
    pub fn log10_c(&self) -> f64 {
        (libm::log(libm::log1p(1.0 / self.lambda)) - self.k * libm::log(FRAC_PI_2 - self.theta0)) / LN_10
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn both_forms_are_the_same_curve(ln_lambda in -6.0..3.0_f64, theta0 in -0.8..1.2_f64, k in 1.0..40.0_f64, theta in 0.0..1.57_f64) {
            let form = G1ClosedForm { lambda: ln_lambda.exp(), theta0, k };
            let c = 10f64.powf(form.log10_c());
            let printed = if theta <= theta0 { 1.0 } else { 1.0 + form.lambda * (1.0 - (c * (theta - theta0).powf(k)).exp()) };
            prop_assert!((form.g1(theta) - printed.max(0.0)).abs() < 1e-9);
            let back = G1ClosedForm::from_published(form.lambda, c, k);
            prop_assert!((back.theta0 - theta0).abs() < 1e-9);
        }

        #[test]
        fn falls_from_one_to_zero(ln_lambda in -16.0..16.0_f64, theta0 in -1.5..1.5_f64, ln_k in -1.0..7.0_f64) {
            let form = G1ClosedForm { lambda: ln_lambda.exp(), theta0, k: ln_k.exp() };
            let values: Vec<f64> = (0..=90).map(|n| form.g1(f64::from(n).to_radians())).collect();
            prop_assert!(values.windows(2).all(|pair| pair[1] <= pair[0]));
            prop_assert_eq!(form.g1(FRAC_PI_2), 0.0);
        }
    }
}
