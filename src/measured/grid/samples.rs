//! Sines and cosines of the sample angles, tabulated once per axis.

use crate::grid::dimensions::Dimensions;
use crate::grid::sample_position::SamplePosition;

/// The smallest cosine with the normal that counts as above the horizon.
pub const MIN_COSINE: f64 = 1e-9;

/// Sine and cosine of the sample angles along each axis of a grid.
#[derive(Clone, Debug)]
pub(crate) struct Samples {
    theta_h: Vec<(f64, f64)>,
    theta_d: Vec<(f64, f64)>,
    cos_phi_d: Vec<f64>,
}

/// The cells of one (theta_h, theta_d): their cosines differ by phi_d only.
///
/// `cos theta_i = even - odd cos phi_d`, `cos theta_o = even + odd cos phi_d`.
#[derive(Clone, Copy, Debug)]
pub(crate) struct RowCosines<'a> {
    even: f64,
    odd: f64,
    cos_phi_d: &'a [f64],
}

impl Samples {
    pub(crate) fn new(dimensions: Dimensions, position: SamplePosition) -> Self {
        Self {
            theta_h: (0..Dimensions::THETA_H).map(|i| libm::sincos(dimensions.theta_h_sample(i, position))).collect(),
            theta_d: (0..Dimensions::THETA_D).map(|j| libm::sincos(dimensions.theta_d_sample(j, position))).collect(),
            cos_phi_d: (0..dimensions.phi_d()).map(|k| libm::cos(dimensions.phi_d_sample(k, position))).collect(),
        }
    }

    #[inline]
    pub(crate) fn cos_theta_d(&self, theta_d: usize) -> f64 {
        self.theta_d[theta_d].1
    }

    #[inline]
    pub(crate) fn row(&self, theta_h: usize, theta_d: usize) -> RowCosines<'_> {
        let ((sin_h, cos_h), (sin_d, cos_d)) = (self.theta_h[theta_h], self.theta_d[theta_d]);
        RowCosines { even: cos_h * cos_d, odd: sin_h * sin_d, cos_phi_d: &self.cos_phi_d }
    }
}

impl RowCosines<'_> {
    /// (cos theta_i, cos theta_o) of the cell at bin `phi_d`.
    #[inline]
    pub(crate) fn at(&self, phi_d: usize) -> (f64, f64) {
        let odd = self.odd * self.cos_phi_d[phi_d];
        (self.even - odd, self.even + odd)
    }
}

/// Whether both directions are above the horizon.
#[inline]
pub(crate) fn is_above_horizon((cos_i, cos_o): (f64, f64)) -> bool {
    cos_i > MIN_COSINE && cos_o > MIN_COSINE
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::grid::dimensions::cosines;

    #[test]
    fn rows_agree_with_the_formula_to_the_bit() {
        for dimensions in [Dimensions::HALF_TURN, Dimensions::FULL_TURN] {
            for position in [SamplePosition::Edge, SamplePosition::Centre] {
                let samples = Samples::new(dimensions, position);
                for (h, d, p) in [(0, 0, 0), (30, 70, 0), (89, 89, 179), (45, 12, 90), (7, 60, 33)] {
                    let angles = (
                        dimensions.theta_h_sample(h, position),
                        dimensions.theta_d_sample(d, position),
                        dimensions.phi_d_sample(p, position),
                    );
                    assert_eq!(samples.row(h, d).at(p), cosines(angles.0, angles.1, angles.2));
                }
            }
        }
    }
}
