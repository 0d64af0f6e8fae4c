//! The rows of a slice that a step uses.

use brdfit_measured::{Dimensions, cosine_drop};

/// One row of a slice inside the cut-off, with a measurement.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Row {
    /// Bin, 0..90.
    pub(crate) bin: usize,
    /// Sample angle, radians.
    pub(crate) theta: f64,
    /// Measured value per channel, 1/sr.
    pub(crate) measured: [f64; 3],
}

/// The measured rows of a slice at sample angles up to `cutoff_degrees`, in order of their angle.
pub(crate) fn rows_within(angles: &[f64], measured: &[Vec<Option<f64>>; 3], cutoff_degrees: f64) -> Vec<Row> {
    let cutoff = cutoff_degrees.to_radians() * (1.0 + 1e-12);
    angles
        .iter()
        .enumerate()
        .filter(|&(_, &theta)| theta <= cutoff)
        .filter_map(|(bin, &theta)| {
            let measured = [measured[0][bin]?, measured[1][bin]?, measured[2][bin]?];
            Some(Row { bin, theta, measured })
        })
        .collect()
}

/// `cos e_i - cos e_(i+1)` of a theta_h bin: the solid angle of its ring over 2 pi.
pub(crate) fn ring(bin: usize) -> f64 {
    let edge = |bin: usize| Dimensions::HALF_TURN.theta_h_edge(bin);
    cosine_drop(edge(bin), edge(bin + 1))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_without_a_measurement_and_beyond_the_cutoff_are_left_out() {
        let angles = [0.0, 0.5, 1.0, 75f64.to_radians(), 1.4];
        let channel = vec![Some(1.0), None, Some(2.0), Some(3.0), Some(4.0)];
        let rows = rows_within(&angles, &[channel.clone(), channel.clone(), channel], 75.0);
        assert_eq!(rows.iter().map(|row| row.bin).collect::<Vec<_>>(), [0, 2, 3]);
    }

    #[test]
    fn rings_add_up_to_the_hemisphere() {
        let total: f64 = (0..90).map(ring).sum();
        assert!((total - 1.0).abs() < 1e-14);
    }
}
