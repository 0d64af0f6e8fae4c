//! The generalised Schlick Fresnel term.

/// Schlick's approximation with a linear term, `F(theta_d) = f0 - f1 cos theta_d + (1 - f0) (1 - cos theta_d)^5`
/// (thesis eq. V.5). With `f1 = 0` it is Schlick's; `F(pi/2) = 1` always. It is a fit, not physics: nothing in the form
/// keeps it inside [0, 1]; [`Fresnel::range`] tells where it lies.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fresnel {
    /// Constant term.
    pub f0: f64,
    /// Coefficient of the linear term.
    pub f1: f64,
}

impl Fresnel {
    /// `F` at the cosine of theta_d; dimensionless.
    pub fn value(&self, cos_theta_d: f64) -> f64 {
        self.f0 - self.f1 * cos_theta_d + (1.0 - self.f0) * fifth(1.0 - cos_theta_d)
    }

    /// `(dF/df0, dF/df1)` at the cosine of theta_d.
    pub fn derivatives(cos_theta_d: f64) -> (f64, f64) {
        (1.0 - fifth(1.0 - cos_theta_d), -cos_theta_d)
    }

    /// Smallest and largest `F` over theta_d in [0, pi/2], exact up to rounding: the ends and the one stationary point
    /// `1 - cos theta_d = (-f1 / (5 (1 - f0)))^(1/4)`.
    pub fn range(&self) -> [f64; 2] {
        let mut range = [self.value(1.0).min(self.value(0.0)), self.value(1.0).max(self.value(0.0))];
        let quartic = -self.f1 / (5.0 * (1.0 - self.f0));
        if quartic > 0.0 && quartic < 1.0 {
            let stationary = self.value(1.0 - quartic.sqrt().sqrt());
            range = [range[0].min(stationary), range[1].max(stationary)];
        }
        range
    }
}

/// `x^5`.
pub(crate) fn fifth(x: f64) -> f64 {
    let square = x * x;
    square * square * x
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn the_range_encloses_a_fine_sampling_and_is_reached(f0 in -2.0..3.0_f64, f1 in -2.0..2.0_f64) {
            let fresnel = Fresnel { f0, f1 };
            let samples: Vec<f64> = (0..=2000).map(|n| fresnel.value(f64::from(n) / 2000.0)).collect();
            let low = samples.iter().copied().fold(f64::INFINITY, f64::min);
            let high = samples.iter().copied().fold(f64::NEG_INFINITY, f64::max);
            let [a, b] = fresnel.range();
            prop_assert!(a <= low + 1e-12 && b >= high - 1e-12);
            prop_assert!((a - low).abs() < 1e-4 && (b - high).abs() < 1e-4);
        }

        #[test]
        fn grazing_incidence_reflects_everything(f0 in -2.0..3.0_f64, f1 in -2.0..2.0_f64) {
            let fresnel = Fresnel { f0, f1 };
            prop_assert!((fresnel.value(0.0) - 1.0).abs() < 4e-15 * (1.0 + f0.abs()));
        }
    }
}
