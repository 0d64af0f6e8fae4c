//! The two slices that the two-step fit reads.

use crate::grid::dimensions::{CHANNELS, Dimensions};
use crate::grid::sample_position::SamplePosition;
use crate::grid::samples::{Samples, is_above_horizon};
use crate::merl::file::MerlFile;

/// Two one-dimensional slices of a measurement, each the mean over phi_d of the usable cells: valid in all three planes
/// and with both directions above the horizon at the sample.
///
/// - `measured_h`: theta_d bin 0 as a function of theta_h. There i, o and h nearly coincide (retro-reflection), and the
///   slice shows the distribution of the half vector.
/// - `measured_d`: theta_h bin 0 as a function of theta_d. There i and o are nearly mirror directions, and the slice
///   shows the Fresnel term.
///
/// After Bagher, Soler & Holzschuch 2012, section 4. All vectors have 90 entries; values are in 1/sr, angles in radians.
#[derive(Clone, Debug, PartialEq)]
pub struct Slices {
    /// Position of each value within its cell.
    pub position: SamplePosition,
    /// Sample angles of the rows of `measured_h`.
    pub theta_h: Vec<f64>,
    /// Sample angles of the rows of `measured_d`.
    pub theta_d: Vec<f64>,
    /// Per channel, the mean at theta_d bin 0; `None` where no cell of the row is usable.
    pub measured_h: [Vec<Option<f64>>; CHANNELS],
    /// Per channel, the mean at theta_h bin 0; `None` where no cell of the row is usable.
    pub measured_d: [Vec<Option<f64>>; CHANNELS],
    /// Number of cells behind each entry of `measured_h`.
    pub cells_h: Vec<usize>,
    /// Number of cells behind each entry of `measured_d`.
    pub cells_d: Vec<usize>,
}

impl Slices {
    /// The slices of a grid whose usable values are `value([theta_h bin, theta_d bin, phi_d bin])`, in 1/sr; it is asked for
    /// cells above the horizon only.
    pub(crate) fn of(
        dimensions: Dimensions,
        position: SamplePosition,
        value: impl Fn([usize; 3]) -> Option<[f64; CHANNELS]>,
    ) -> Self {
        let samples = Samples::new(dimensions, position);
        let (measured_h, cells_h) = slice(&samples, dimensions.phi_d(), |i| [i, 0], &value);
        let (measured_d, cells_d) = slice(&samples, dimensions.phi_d(), |j| [0, j], &value);
        Self {
            position,
            theta_h: (0..Dimensions::THETA_H).map(|i| dimensions.theta_h_sample(i, position)).collect(),
            theta_d: (0..Dimensions::THETA_D).map(|j| dimensions.theta_d_sample(j, position)).collect(),
            measured_h,
            measured_d,
            cells_h,
            cells_d,
        }
    }
}

impl MerlFile {
    /// Reads the two slices. Only their cells are touched: of a 35 MB file on disk, less than 2 MB are read.
    #[must_use]
    pub fn slices(&self, position: SamplePosition) -> Slices {
        let dimensions = self.dimensions();
        Slices::of(dimensions, position, |[theta_h, theta_d, phi_d]| {
            self.rgb(dimensions.index(theta_h, theta_d, phi_d))
        })
    }
}

/// The slice whose entry `n` is the row (theta_h, theta_d) = `row(n)`, and the number of cells in each mean.
fn slice(
    samples: &Samples,
    bins: usize,
    row: impl Fn(usize) -> [usize; 2],
    value: &impl Fn([usize; 3]) -> Option<[f64; CHANNELS]>,
) -> ([Vec<Option<f64>>; CHANNELS], Vec<usize>) {
    const ROWS: usize = 90;
    let mut means: [Vec<Option<f64>>; CHANNELS] = std::array::from_fn(|_| Vec::with_capacity(ROWS));
    let mut counts = Vec::with_capacity(ROWS);
    for n in 0..ROWS {
        let [theta_h, theta_d] = row(n);
        let cosines = samples.row(theta_h, theta_d);
        let (mut sum, mut count) = ([0.0; CHANNELS], 0);
        for phi_d in (0..bins).filter(|&k| is_above_horizon(cosines.at(k))) {
            if let Some(rgb) = value([theta_h, theta_d, phi_d]) {
                for (sum, f) in sum.iter_mut().zip(rgb) {
                    *sum += f;
                }
                count += 1;
            }
        }
        for (mean, sum) in means.iter_mut().zip(sum) {
            mean.push((count > 0).then(|| sum / count as f64));
        }
        counts.push(count);
    }
    (means, counts)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A file whose value is a function of the bins, with some cells taken out.
    fn file(dimensions: Dimensions) -> MerlFile {
        MerlFile::from_fn("x", dimensions, |c, h, d, p| {
            let missing = match (h, d) {
                (40, 0) => p >= 3,          // three cells left
                (41, 0) => true,            // none left
                (42, 0) => c == 1 && p > 0, // one plane decides for all
                _ => false,
            };
            if missing { -1.0 } else { (c + 1) as f64 * (1.0 + h as f64 + 100.0 * d as f64 + p as f64) }
        })
        .unwrap()
    }

    #[test]
    fn slices_are_means_over_the_cells_that_are_left() {
        for dimensions in [Dimensions::HALF_TURN, Dimensions::FULL_TURN] {
            for position in [SamplePosition::Edge, SamplePosition::Centre] {
                let slices = file(dimensions).slices(position);
                let middle = (dimensions.phi_d() - 1) as f64 / 2.0;
                for c in 0..CHANNELS {
                    let near = |got: Option<f64>, expected: f64| {
                        let got = got.unwrap();
                        let expected = (c + 1) as f64 * expected;
                        assert!((got - expected).abs() < 1e-12 * expected, "{got} {expected}");
                    };
                    near(slices.measured_h[c][7], 8.0 + middle);
                    near(slices.measured_d[c][7], 701.0 + middle);
                    near(slices.measured_h[c][40], 42.0);
                    assert_eq!(slices.measured_h[c][41], None);
                    near(slices.measured_h[c][42], 43.0);
                    assert_eq!(slices.measured_h[c][0], slices.measured_d[c][0]);
                }
                assert_eq!((slices.cells_h[39], slices.cells_h[40], slices.cells_h[41]), (dimensions.phi_d(), 3, 0));
                assert_eq!(slices.theta_h[3], dimensions.theta_h_sample(3, position));
                assert_eq!((slices.position, slices.theta_d.len()), (position, 90));
            }
        }
    }

    #[test]
    fn cells_below_the_horizon_are_left_out() {
        // At the centre of the last theta_h row theta_h is 89.0 degrees and theta_d 0.5: all above. At the edge theta_d
        // is 0 and both directions are the half vector. So both slices are complete when every cell is valid.
        let all = MerlFile::from_fn("x", Dimensions::HALF_TURN, |_, _, _, _| 1.0).unwrap();
        let slices = all.slices(SamplePosition::Centre);
        assert_eq!(slices.cells_h, vec![180; 90]);
        // theta_h of the first row is 0.0028 degrees; at theta_d = 89.5 degrees both stay above.
        assert_eq!(slices.cells_d, vec![180; 90]);
        assert_eq!(all.slices(SamplePosition::Edge).cells_d, vec![180; 90]);
    }
}
