//! The values of a measured file in single precision, folded by its symmetries and without gaps.

use brdfit_brdf::Direction;
use std::f64::consts::{FRAC_PI_2, PI};
use wide::f32x4;

use crate::grid::dimensions::{CHANNELS, Dimensions};
use crate::grid::fill::nearest;
use crate::grid::sample_position::SamplePosition;
use crate::grid::samples::{Samples, is_above_horizon};
use crate::merl::file::MerlFile;

/// Columns of phi_d from 0 to a quarter turn, guards included.
pub(super) const QUARTER: usize = 92;
/// Columns of phi_d from 0 to a half turn, guards included.
pub(super) const HALF: usize = 182;
/// Rows of theta_d per slab of theta_h.
pub(super) const ROWS: usize = Dimensions::THETA_D;
/// The last row and the last slab between which there is something to interpolate.
pub(super) const LAST: usize = 88;
/// The square of an angle's index coordinate along theta_h, per radian: `90^2 / (pi/2)`.
pub(super) const H_PER_RADIAN: f64 = (Dimensions::THETA_H * Dimensions::THETA_H) as f64 / FRAC_PI_2;
/// Bins of theta_d and phi_d per radian.
pub(super) const PER_RADIAN: f64 = 180.0 / PI;

/// Texels (R, G, B, 0) over (theta_h, theta_d, phi_d), phi_d contiguous.
///
/// Along phi_d the outermost columns continue the table past its ends by reflection, so that every angle has a column on
/// both sides: phi_d lies at column `bins(phi_d) + offset`, theta_h and theta_d at row `bins - offset`, with the offset of
/// the sample position.
#[derive(Clone, Debug)]
pub(super) struct Table {
    pub(super) texels: Vec<f32x4>,
    /// [`QUARTER`] or [`HALF`].
    pub(super) width: usize,
    /// [`SamplePosition::offset`].
    pub(super) offset: f64,
}

impl Table {
    /// Folds, converts and fills; `None` if no cell is usable.
    pub(super) fn new(file: &MerlFile, position: SamplePosition) -> Option<Self> {
        file.expect_all();
        let dimensions = file.dimensions();
        let bins = dimensions.phi_d();
        let width = if dimensions.is_folded() { QUARTER } else { HALF };
        // The mirror image of phi_d bin k; the bins that are left; the columns before the first of them.
        let (mirrored, kept, first): (fn(usize, usize) -> usize, _, _) = match position {
            SamplePosition::Edge => (|k, bins| (bins - k) % bins, bins / 2 + 1, 0),
            SamplePosition::Centre => (|k, bins| bins - 1 - k, bins / 2, 1),
        };
        let samples = Samples::new(dimensions, position);
        let rows = Dimensions::THETA_H * ROWS;
        let mut texels = vec![f32x4::ZERO; rows * width];
        let mut valid = vec![false; rows * kept];
        for (row, (texels, valid)) in texels.chunks_exact_mut(width).zip(valid.chunks_exact_mut(kept)).enumerate() {
            let cosines = samples.row(row / ROWS, row % ROWS);
            let measured = |k| is_above_horizon(cosines.at(k)).then(|| file.rgb(row * bins + k)).flatten();
            for (k, (texel, valid)) in texels[first..].iter_mut().zip(valid).enumerate() {
                let rgb = match (measured(k), measured(mirrored(k, bins))) {
                    (Some(a), Some(b)) => Some([0, 1, 2].map(|c: usize| 0.5 * a[c] + 0.5 * b[c])),
                    (a, b) => a.or(b),
                };
                if let Some(rgb) = rgb {
                    let [r, g, b] = rgb.map(|f| f.min(f64::from(f32::MAX)) as f32);
                    (*texel, *valid) = (f32x4::new([r, g, b, 0.0]), true);
                }
            }
        }
        let place = |cell: usize| cell / kept * width + first + cell % kept;
        for (cell, source) in nearest([Dimensions::THETA_H, ROWS, kept], &valid)? {
            texels[place(cell)] = texels[place(source)];
        }
        for row in texels.chunks_exact_mut(width) {
            row[0] = row[first];
            row[width - 1] = row[width - 3 + first];
        }
        Some(Self { texels, width, offset: position.offset() })
    }

    /// The value in 1/sr for two unit vectors, in double precision.
    pub(super) fn value(&self, i: &Direction, o: &Direction) -> [f64; CHANNELS] {
        self.interpolated(self.coordinates(i, o))
    }

    /// The mean of the channels.
    pub(super) fn mean(&self, i: &Direction, o: &Direction) -> f64 {
        self.value(i, o).iter().sum::<f64>() / 3.0
    }

    /// Slab, row and column of the half/difference angles of two unit vectors.
    pub(super) fn coordinates(&self, i: &Direction, o: &Direction) -> [f64; 3] {
        let (h, d) = (i + o, i - o);
        let across_square = h.x * h.x + h.y * h.y;
        let theta_h = libm::atan2(across_square.sqrt(), h.z);
        let theta_d = libm::atan2(d.norm(), h.norm());
        // d along the axes of the frame of h, times |h| and the part of h in the surface
        let x = h.z * (h.x * d.x + h.y * d.y) - across_square * d.z;
        let y = h.norm() * (h.x * d.y - h.y * d.x);
        let phi_d = libm::atan2(y.abs(), if self.width == QUARTER { x.abs() } else { x });
        [
            (theta_h * H_PER_RADIAN).sqrt() - self.offset,
            theta_d * PER_RADIAN - self.offset,
            phi_d * PER_RADIAN + self.offset,
        ]
    }

    /// The trilinear interpolation between the samples around a slab, a row and a column, held outside the outermost ones.
    fn interpolated(&self, [slab, row, column]: [f64; 3]) -> [f64; CHANNELS] {
        let split = |at: f64, last: usize| {
            let at = at.clamp(0.0, (last + 1) as f64);
            let below = (at as usize).min(last);
            (below, at - below as f64)
        };
        let ((h, s), (d, t), (p, u)) = (split(slab, LAST), split(row, LAST), split(column, self.width - 2));
        let first = (h * ROWS + d) * self.width + p;
        let corners = [0, self.width, ROWS * self.width, (ROWS + 1) * self.width]
            .map(|step| [first + step, first + step + 1].map(|at| self.texels[at].to_array()));
        [0, 1, 2].map(|c: usize| {
            let mix = |a: f64, b: f64, share: f64| a + share * (b - a);
            let [a, b, e, f] = corners.map(|[a, b]| mix(f64::from(a[c]), f64::from(b[c]), u));
            mix(mix(a, b, t), mix(e, f, t), s)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Rows (theta_h, theta_d) = (10, 20) of a file that holds 1 + k at phi_d bin k, all above the horizon.
    fn row(dimensions: Dimensions, position: SamplePosition, missing: Option<usize>) -> Vec<f32> {
        let value = |_, h, d, k| if (h, d, Some(k)) == (10, 20, missing) { -1.0 } else { 1.0 + k as f64 };
        let file = MerlFile::from_fn("x", dimensions, value).unwrap();
        let table = Table::new(&file, position).unwrap();
        table.texels[(10 * ROWS + 20) * table.width..][..table.width].iter().map(|t| t.to_array()[1]).collect()
    }

    #[test]
    fn mirror_images_are_averaged_and_the_ends_reflected() {
        for (dimensions, bins, width) in [(Dimensions::HALF_TURN, 180.0, 92), (Dimensions::FULL_TURN, 360.0, 182)] {
            // edge: 0 is its own image, k goes with bins - k
            let edge = row(dimensions, SamplePosition::Edge, None);
            assert_eq!((edge.len(), edge[0], edge[1], edge[30]), (width, 1.0, 1.0 + bins / 2.0, 1.0 + bins / 2.0));
            assert_eq!(edge[width - 1], edge[width - 3]);
            // centre: k goes with bins - 1 - k
            let centre = row(dimensions, SamplePosition::Centre, None);
            assert!(centre.iter().all(|&f| f == 1.0 + (bins - 1.0) / 2.0));
            // what one image misses the other has: column 31 is bin 30
            let half = row(dimensions, SamplePosition::Centre, Some(30));
            assert_eq!((half[31], half[32]), (bins - 30.0, centre[32]));
        }
    }

    #[test]
    fn cells_below_the_horizon_count_as_missing() {
        let d = Dimensions::HALF_TURN;
        let above = |h, t, p| {
            let centre = SamplePosition::Centre;
            let angles = (d.theta_h_sample(h, centre), d.theta_d_sample(t, centre), d.phi_d_sample(p, centre));
            is_above_horizon(crate::grid::dimensions::cosines(angles.0, angles.1, angles.2))
        };
        let file = MerlFile::from_fn("x", d, |_, h, t, p| if above(h, t, p) { 2.0 } else { 1e6 }).unwrap();
        let table = Table::new(&file, SamplePosition::Centre).unwrap();
        assert!(table.texels.iter().all(|texel| texel.to_array()[0] == 2.0));
    }
}
