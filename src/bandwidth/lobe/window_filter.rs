//! The transform of a sharp lobe at a high resolution, of which only a window is computed.
//!
//! Outside the window the lobe is smooth at that resolution: its fine coefficients are too small to count, and the approximation
//! coefficients follow from the samples of the coarser resolution, by a filter which has the first four moments of the low-pass filter that
//! would have made them of fine samples. Inside the window the image is filtered, and from there on the transform goes on as if all of it
//! had been.

use std::ops::Range;

use crate::wavelet::daubechies::{Border, LOW, four_taps};
use crate::wavelet::pyramid::{Bands, Image, step};
use crate::wavelet::simd_dispatch::dispatch_simd;

/// Samples of a part of an image; rows and columns outside the image repeat it reflected.
#[derive(Clone, Debug, Default)]
pub(crate) struct Patch {
    pub(crate) top: isize,
    pub(crate) left: isize,
    pub(crate) rows: usize,
    pub(crate) columns: usize,
    pub(crate) values: Vec<f32>,
}

/// A part of the map of 64 x 64 texels.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Window {
    pub(crate) rows: Range<usize>,
    pub(crate) columns: Range<usize>,
}

/// Taps at the samples n - 2 .. n + 1 of a smooth image which have the first four moments of the low-pass filter, once or twice
/// applied, that makes approximation coefficient n out of samples of a half, or a quarter, of the distance.
fn smooth_taps(levels: usize) -> [f32; 4] {
    // where the low-pass reads, in fine samples from the centre of the block, and with which weight
    let mut reads = vec![(0.0, 1.0)];
    for _ in 0..levels {
        // coefficient k reads 2k - 1 + t, and the centre of its block lies at 2k + 1/2
        let finer = |&(x, weight): &(f64, f64)| [0, 1, 2, 3].map(|t| (2.0 * x + t as f64 - 1.5, weight * LOW[t]));
        reads = reads.iter().flat_map(finer).collect();
    }
    let scale = f64::from(1 << levels);
    let nodes = [-2.0, -1.0, 0.0, 1.0];
    std::array::from_fn(|a| {
        let basis = |x: f64| -> f64 {
            let others = nodes.iter().enumerate().filter(|&(b, _)| b != a);
            others.map(|(_, node)| (x - node) / (nodes[a] - node)).product()
        };
        reads.iter().map(|&(x, weight)| weight * basis(x / scale)).sum::<f64>() as f32
    })
}

/// Index of the sample that lies at `n` in an image of `size` samples which goes on reflected.
pub(crate) fn reflect(n: isize, size: usize) -> usize {
    if n < 0 { (-1 - n) as usize } else { (n as usize).min(2 * size - 1 - n as usize) }
}

/// In double precision.
pub(crate) fn sum_of_squares(values: &[f32]) -> f64 {
    values.iter().map(|&x| f64::from(x) * f64::from(x)).sum()
}

impl Patch {
    /// Takes a shape; the values are left to be written.
    pub(crate) fn resize(&mut self, rows: Range<isize>, columns: Range<isize>) {
        (self.top, self.left) = (rows.start, columns.start);
        (self.rows, self.columns) = (rows.len(), columns.len());
        self.values.resize(self.rows * self.columns, 0.0);
    }

    /// Exchanges left and right, or top and bottom, in an image of `size` samples along a side.
    pub(crate) fn reflected(&self, size: usize, columns: bool, rows: bool, out: &mut Self) {
        let turn = |start: isize, count: usize| size as isize - start - count as isize;
        out.clone_from(self);
        if columns {
            out.left = turn(self.left, self.columns);
            out.values.chunks_exact_mut(self.columns).for_each(<[f32]>::reverse);
        }
        if rows {
            out.top = turn(self.top, self.rows);
            let (upper, lower) = out.values.split_at_mut(self.rows / 2 * self.columns);
            let lower = &mut lower[self.rows % 2 * self.columns..];
            for (a, b) in upper.chunks_exact_mut(self.columns).zip(lower.chunks_exact_mut(self.columns).rev()) {
                a.swap_with_slice(b);
            }
        }
    }

    /// Sum of squares of the samples in a part of the image.
    pub(crate) fn energy(&self, rows: Range<isize>, columns: Range<isize>) -> f64 {
        let column = |column: isize| (column - self.left) as usize;
        let row = |row: isize| (row - self.top) as usize * self.columns;
        rows.map(|r| sum_of_squares(&self.values[row(r)..][column(columns.start)..column(columns.end)])).sum()
    }

    /// Without some samples on each side.
    pub(crate) fn trim(&self, margin: usize) -> Self {
        let (rows, columns) = (self.rows - 2 * margin, self.columns - 2 * margin);
        let mut values = Vec::with_capacity(rows * columns);
        for row in self.values.chunks_exact(self.columns).skip(margin).take(rows) {
            values.extend_from_slice(&row[margin..margin + columns]);
        }
        Self { top: self.top + margin as isize, left: self.left + margin as isize, rows, columns, values }
    }

    /// Writes into `out`, which has its shape already, the approximation after `levels` (1 or 2) levels that this smooth image stands for.
    /// This patch reaches two samples further on each side.
    pub(crate) fn shifted(&self, levels: usize, out: &mut Self, scratch: &mut Vec<f32>) {
        assert!(self.rows == out.rows + 4 && self.columns == out.columns + 4, "the patch is not two samples larger");
        let weights = smooth_taps(levels);
        let columns = out.columns;
        scratch.resize(self.rows * columns, 0.0);
        dispatch_simd(
            #[inline(always)]
            || {
                for (out, row) in scratch.chunks_exact_mut(columns).zip(self.values.chunks_exact(self.columns)) {
                    four_taps(weights, [row, &row[1..], &row[2..], &row[3..]], out);
                }
                for (r, out) in out.values.chunks_exact_mut(columns).enumerate() {
                    four_taps(weights, [0, 1, 2, 3].map(|a| &scratch[(r + a) * columns..][..columns]), out);
                }
            },
        );
    }

    /// One level of the transform: writes the detail of this patch, which reaches two samples beyond a window of an even number of
    /// samples, to `bands` (the window alone), and its approximation over that of `coarse`.
    pub(crate) fn filter(&self, coarse: &mut Self, bands: &mut Bands<f32>, memory: &mut FilterMemory) {
        let FilterMemory { approximation, bands: all, scratch } = memory;
        let image = Image { samples: &self.values, rows: self.rows, columns: self.columns };
        step(image, Border::Reflect, approximation, all, scratch);
        // the outermost coefficients saw the end of the patch
        let (rows, columns) = (self.rows / 2 - 2, self.columns / 2 - 2);
        let inner = |r: usize| (r + 1) * all.columns + 1..(r + 1) * all.columns + 1 + columns;
        let crop = |plane: &[f32], out: &mut Vec<f32>| {
            out.clear();
            (0..rows).for_each(|r| out.extend_from_slice(&plane[inner(r)]));
        };
        (bands.rows, bands.columns) = (rows, columns);
        crop(&all.horizontal, &mut bands.horizontal);
        crop(&all.vertical, &mut bands.vertical);
        crop(&all.diagonal, &mut bands.diagonal);
        let (top, left) = (self.top / 2 + 1 - coarse.top, self.left / 2 + 1 - coarse.left);
        for r in 0..rows {
            let start = (top as usize + r) * coarse.columns + left as usize;
            coarse.values[start..start + columns].copy_from_slice(&approximation[inner(r)]);
        }
    }

    /// Makes the samples outside an image of `size` samples along a side the reflection of those inside.
    pub(crate) fn close(&mut self, size: usize) {
        let ends_inside = |start: isize, count: usize| start >= 0 && start + count as isize <= size as isize;
        if ends_inside(self.top, self.rows) && ends_inside(self.left, self.columns) {
            return;
        }
        let inside = |start: isize, n: usize| reflect(start + n as isize, size) as isize - start;
        for r in 0..self.rows {
            for c in 0..self.columns {
                let from = (inside(self.top, r), inside(self.left, c));
                if from != (r as isize, c as isize) {
                    self.values[r * self.columns + c] = self.values[from.0 as usize * self.columns + from.1 as usize];
                }
            }
        }
    }
}

/// Memory of [`Patch::filter`].
#[derive(Clone, Debug, Default)]
pub(crate) struct FilterMemory {
    approximation: Vec<f32>,
    bands: Bands<f32>,
    scratch: Vec<f32>,
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::wavelet::daubechies::analyse;

    /// A part of an image without structure, of any size, that goes on reflected.
    fn noise(rows: Range<isize>, columns: Range<isize>, size: usize) -> Patch {
        let mut patch = Patch::default();
        patch.resize(rows.clone(), columns.clone());
        let values = rows.flat_map(|r| columns.clone().map(move |c| (reflect(r, size), reflect(c, size))));
        patch.values = values.map(|(r, c)| ((r * 7919 + c * 104_729) % 1009) as f32 / 1009.0).collect();
        patch
    }

    #[test]
    fn smooth_taps_are_exact_for_cubics() {
        // in units of the coarse samples, of which number n lies at n + 1/2
        let cubic = |x: f64| 0.3 + x * (0.7 - x * (0.05 + 0.01 * x));
        for levels in [1, 2] {
            let scale = f64::from(1 << levels);
            let mut line: Vec<f64> = (0..64).map(|m| cubic((f64::from(m) + 0.5) / scale)).collect();
            for _ in 0..levels {
                let (mut low, mut high) = (vec![0.0; line.len() / 2], vec![0.0; line.len() / 2]);
                analyse(&line, Border::Reflect, &mut low, &mut high, &mut vec![0.0; line.len() + 2]);
                line = low;
            }
            let taps = smooth_taps(levels);
            for n in 3..line.len() - 3 {
                let samples = [0, 1, 2, 3].map(|a| cubic((n + a) as f64 - 1.5));
                let smooth: f64 = taps.iter().zip(samples).map(|(&tap, x)| f64::from(tap) * x).sum();
                let error = (smooth - line[n]).abs() / (1.0 + line[n].abs());
                assert!(error < 1e-6, "{levels} levels, {n}: {smooth} {}", line[n]);
            }
        }
    }

    #[test]
    fn smooth_images_are_shifted_along_both_sides() {
        let plane = |r: isize, c: isize| (2 * r - 3 * c) as f32;
        let (rows, columns) = (4..12, -2..16);
        let mut patch = Patch::default();
        patch.resize(rows.clone(), columns.clone());
        patch.values = rows.flat_map(|r| columns.clone().map(move |c| plane(r, c))).collect();
        let mut out = Patch::default();
        out.resize(6..10, 0..14);
        patch.shifted(1, &mut out, &mut Vec::new());
        // a linear function keeps its slopes, times two (the norm in two dimensions), and moves by the delay of the filter
        for r in 0..4 {
            for c in 0..14 {
                let from_first = out.values[r * 14 + c] - out.values[0];
                assert!((from_first - 2.0 * plane(r as isize, c as isize)).abs() < 1e-3, "{r} {c}: {from_first}");
            }
        }
    }

    #[test]
    fn a_window_is_filtered_as_the_whole_is() {
        const SIZE: usize = 32;
        let whole = noise(0..SIZE as isize, 0..SIZE as isize, SIZE);
        let (mut low, mut all) = (Vec::new(), Bands::default());
        let image = Image { samples: &whole.values, rows: SIZE, columns: SIZE };
        step(image, Border::Reflect, &mut low, &mut all, &mut Vec::new());
        for (rows, columns) in [(8..20, 4..16), (0..8, 24..32), (0..32, 0..32)] {
            let wider = |range: &Range<isize>| range.start - 2..range.end + 2;
            let patch = noise(wider(&rows), wider(&columns), SIZE);
            let mut coarse = Patch::default();
            coarse.resize(0..SIZE as isize / 2, 0..SIZE as isize / 2);
            coarse.values.fill(-1.0);
            let mut bands = Bands::default();
            patch.filter(&mut coarse, &mut bands, &mut FilterMemory::default());
            assert_eq!((bands.rows, bands.columns), (rows.len() / 2, columns.len() / 2));
            for r in 0..SIZE / 2 {
                for c in 0..SIZE / 2 {
                    let n = r * SIZE / 2 + c;
                    if !(rows.contains(&(2 * r as isize)) && columns.contains(&(2 * c as isize))) {
                        assert_eq!(coarse.values[n], -1.0);
                        continue;
                    }
                    assert_eq!(coarse.values[n], low[n]);
                    let inside = (r - rows.start as usize / 2) * bands.columns + c - columns.start as usize / 2;
                    assert_eq!(bands.horizontal[inside], all.horizontal[n]);
                    assert_eq!(bands.vertical[inside], all.vertical[n]);
                    assert_eq!(bands.diagonal[inside], all.diagonal[n]);
                }
            }
        }
    }

    #[test]
    fn reflected_patches_lie_where_they_belong() {
        const SIZE: usize = 16;
        for rows in [3..8, 3..9] {
            let patch = noise(rows, -1..7, SIZE);
            let mut turned = Patch::default();
            patch.reflected(SIZE, true, true, &mut turned);
            assert_eq!((turned.top + turned.rows as isize, turned.left), (SIZE as isize - 3, 9));
            for r in 0..patch.rows {
                for c in 0..patch.columns {
                    let there = (patch.rows - 1 - r) * patch.columns + patch.columns - 1 - c;
                    assert_eq!(patch.values[r * patch.columns + c], turned.values[there]);
                }
            }
            let mut back = Patch::default();
            turned.reflected(SIZE, true, true, &mut back);
            assert_eq!((back.top, back.left, back.values), (patch.top, patch.left, patch.values));
        }
    }

    #[test]
    fn closing_reflects_what_is_inside() {
        let expected = noise(-3..5, 12..20, 16);
        let mut patch = expected.clone();
        for (n, value) in patch.values.iter_mut().enumerate() {
            let (r, c) = (n / 8, n % 8);
            if r < 3 || c >= 4 {
                *value = f32::NAN;
            }
        }
        patch.close(16);
        assert_eq!(patch.values, expected.values);
        let trimmed = patch.trim(2);
        assert_eq!((trimmed.top, trimmed.left, trimmed.rows, trimmed.columns), (-1, 14, 4, 4));
        assert_eq!(trimmed.values[5], patch.values[3 * 8 + 3]);
        assert_eq!(patch.energy(-1..3, 14..18), sum_of_squares(&trimmed.values));
    }
}
