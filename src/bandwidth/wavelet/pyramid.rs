//! The two-dimensional wavelet transform: one horizontal and one vertical step per level.

use rayon::prelude::*;

use crate::wavelet::daubechies::{Border, HIGH, LOW, Real, analyse, four_taps, rebuilding, synthesise, taps};
use crate::wavelet::simd_dispatch::dispatch_simd;

/// Size of the last approximation along the shorter side.
pub const COARSEST: usize = 4;

/// Images with at least this many samples are transformed by all threads.
const PARALLEL: usize = 1 << 18;

/// Coefficients of one level, row-major, half as many rows and columns as the level before.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Bands<T> {
    /// Rows of each band.
    pub rows: usize,
    /// Columns of each band.
    pub columns: usize,
    /// High-passed along a row, low-passed along a column: sees vertical edges.
    pub horizontal: Vec<T>,
    /// Low-passed along a row, high-passed along a column: sees horizontal edges.
    pub vertical: Vec<T>,
    /// High-passed along both.
    pub diagonal: Vec<T>,
}

/// The wavelet transform of an image of `2^a x 2^b` samples, with memory to be used again.
///
/// The coefficients are orthonormal (with [`Border::Periodic`] the sum of squares is that of the image). Agreement with PyWavelets:
/// `docs/accuracy.md`.
#[derive(Clone, Debug, Default)]
pub struct Pyramid<T> {
    /// Detail bands, finest first.
    pub levels: Vec<Bands<T>>,
    /// The residual after the last level, row-major: the local mean times `2^levels`.
    pub approximation: Vec<T>,
    /// The approximation of the level before.
    previous: Vec<T>,
    /// Every row filtered, and scratch behind.
    scratch: Vec<T>,
}

/// Number of levels until the last bands of a `rows x columns` image are 4 along the shorter side.
///
/// # Panics
/// If a side is not a power of two of at least 8.
pub fn level_count(rows: usize, columns: usize) -> usize {
    for side in [rows, columns] {
        assert!(side.is_power_of_two() && side >= 2 * COARSEST, "{rows} x {columns} has a side that is not 2^m >= 8");
    }
    (rows.min(columns) / COARSEST).ilog2() as usize
}

impl<T: Real> Pyramid<T> {
    /// Transforms an image, all levels.
    ///
    /// # Panics
    /// If the sides are not powers of two of at least 8, or do not fit the number of samples.
    pub fn analyse(&mut self, image: &[T], rows: usize, columns: usize, border: Border) {
        assert_eq!(image.len(), rows * columns, "{rows} x {columns} samples expected");
        self.analyse_rows(image, rows, columns, border);
    }

    /// Transforms an image of which the first rows are given and the others repeat them backwards (or all are given).
    pub(crate) fn analyse_rows(&mut self, image: &[T], rows: usize, columns: usize, border: Border) {
        let count = level_count(rows, columns);
        self.levels.resize_with(count, Bands::default);
        for (level, bands) in self.levels.iter_mut().enumerate() {
            let (rows, columns) = (rows >> level, columns >> level);
            let samples = if level == 0 {
                image
            } else {
                std::mem::swap(&mut self.approximation, &mut self.previous);
                &self.previous
            };
            step(Image { samples, rows, columns }, border, &mut self.approximation, bands, &mut self.scratch);
        }
    }

    /// Rebuilds the image.
    pub fn synthesise(&self, border: Border) -> Vec<T> {
        let mut image = self.approximation.clone();
        for bands in self.levels.iter().rev() {
            image = step_back(&image, bands, border);
        }
        image
    }
}

/// An image of which all rows are given, or the first half, which the others repeat backwards.
#[derive(Clone, Copy)]
pub(crate) struct Image<'a, T> {
    /// The given rows, one after the other.
    pub(crate) samples: &'a [T],
    pub(crate) rows: usize,
    pub(crate) columns: usize,
}

impl<T> Image<'_, T> {
    /// Number of rows.
    fn given(&self) -> usize {
        let given = self.samples.len() / self.columns;
        assert!(given == self.rows || given == self.rows / 2, "{given} of {} rows", self.rows);
        given
    }

    /// Whether the work is large enough for several threads.
    fn is_large(&self) -> bool {
        self.rows * self.columns >= PARALLEL
    }
}

/// One level: filters all rows, then all columns. The memory is used again.
pub(crate) fn step<T: Real>(
    image: Image<'_, T>,
    border: Border,
    approximation: &mut Vec<T>,
    bands: &mut Bands<T>,
    scratch: &mut Vec<T>,
) {
    bands.rows = image.rows / 2;
    bands.columns = image.columns / 2;
    for plane in [&mut *approximation, &mut bands.horizontal, &mut bands.vertical, &mut bands.diagonal] {
        plane.resize(bands.rows * bands.columns, T::default());
    }
    // behind the last row, room to filter one
    let filtered_len = image.given() * image.columns;
    scratch.resize(filtered_len + image.columns + 2, T::default());
    let (filtered, spare) = scratch.split_at_mut(filtered_len);
    filter_rows(image, border, filtered, spare);
    filter_columns(Image { samples: filtered, ..image }, border, approximation, bands);
}

/// Filters each given row of an image: its low half, then its high half. `spare` holds two samples more than a row.
fn filter_rows<T: Real>(image: Image<'_, T>, border: Border, filtered: &mut [T], spare: &mut [T]) {
    let Image { samples, columns, .. } = image;
    let along_row = |spare: &mut [T], (out, row): (&mut [T], &[T])| {
        let (low, high) = out.split_at_mut(columns / 2);
        dispatch_simd(
            #[inline(always)]
            || analyse(row, border, low, high, spare),
        );
    };
    if image.is_large() {
        let rows = filtered.par_chunks_mut(columns).zip(samples.par_chunks(columns));
        rows.for_each_init(|| vec![T::default(); columns + 2], |spare, row| along_row(spare, row));
    } else {
        filtered.chunks_mut(columns).zip(samples.chunks(columns)).for_each(|row| along_row(spare, row));
    }
}

/// Filters the columns of an image whose rows are filtered, which makes the approximation and the three bands.
fn filter_columns<T: Real>(filtered: Image<'_, T>, border: Border, approximation: &mut [T], bands: &mut Bands<T>) {
    let (rows, given, half) = (filtered.rows, filtered.given(), filtered.columns / 2);
    // the low and the high half of a row, also beyond the first and the last one
    let row = |r: isize| {
        let r = match border {
            Border::Reflect => r.clamp(0, rows as isize - 1),
            Border::Periodic => r.rem_euclid(rows as isize),
        } as usize;
        let r = if r < given { r } else { rows - 1 - r };
        filtered.samples[r * filtered.columns..][..filtered.columns].split_at(half)
    };
    let along_column = |(k, (((low, horizontal), vertical), diagonal)): Quarter<'_, T>| {
        let first = 2 * k as isize - 1;
        let [a, b, c, d] = [row(first), row(first + 1), row(first + 2), row(first + 3)];
        let (left, right) = ([a.0, b.0, c.0, d.0], [a.1, b.1, c.1, d.1]);
        dispatch_simd(
            #[inline(always)]
            || {
                four_taps(taps(LOW), left, low);
                four_taps(taps(HIGH), left, vertical);
                four_taps(taps(LOW), right, horizontal);
                four_taps(taps(HIGH), right, diagonal);
            },
        );
    };
    let Bands { horizontal, vertical, diagonal, .. } = bands;
    if filtered.is_large() {
        let quarters = approximation
            .par_chunks_mut(half)
            .zip(horizontal.par_chunks_mut(half))
            .zip(vertical.par_chunks_mut(half))
            .zip(diagonal.par_chunks_mut(half));
        quarters.enumerate().for_each(along_column);
    } else {
        let quarters = approximation
            .chunks_mut(half)
            .zip(horizontal.chunks_mut(half))
            .zip(vertical.chunks_mut(half))
            .zip(diagonal.chunks_mut(half));
        quarters.enumerate().for_each(along_column);
    }
}

/// Row k of the approximation and of the three bands.
type Quarter<'a, T> = (usize, (((&'a mut [T], &'a mut [T]), &'a mut [T]), &'a mut [T]));

/// One level back: the image of which [`step`] made this approximation and these bands.
fn step_back<T: Real>(approximation: &[T], bands: &Bands<T>, border: Border) -> Vec<T> {
    let (half_rows, half) = (bands.rows, bands.columns);
    let columns = 2 * half;
    let mut filtered = vec![T::default(); 2 * half_rows * columns];
    filtered.par_chunks_mut(columns).enumerate().for_each(|(r, out)| {
        let ([k, next], taps) = rebuilding(r, half_rows, border);
        let (left, right) = out.split_at_mut(half);
        for (low, high, out) in
            [(approximation, &bands.vertical, left), (&bands.horizontal[..], &bands.diagonal, right)]
        {
            let row = |k: usize| k * half..(k + 1) * half;
            four_taps(taps.map(T::from_f64), [&low[row(k)], &high[row(k)], &low[row(next)], &high[row(next)]], out);
        }
    });
    let mut image = vec![T::default(); filtered.len()];
    image.par_chunks_mut(columns).zip(filtered.par_chunks(columns)).for_each(|(out, row)| {
        let (low, high) = row.split_at(half);
        synthesise(low, high, border, out);
    });
    image
}

#[cfg(test)]
mod tests {
    use super::*;

    #[derive(serde::Deserialize)]
    struct Oracle {
        name: String,
        border: String,
        x: Vec<Vec<f64>>,
        low: Vec<Vec<f64>>,
        #[serde(rename = "H")]
        horizontal: Vec<Vec<f64>>,
        #[serde(rename = "V")]
        vertical: Vec<Vec<f64>>,
        #[serde(rename = "D")]
        diagonal: Vec<Vec<f64>>,
    }

    /// One level of images of any even sides; more levels: `tests/wavelet_oracles.rs`.
    #[test]
    fn one_level_is_that_of_pywavelets() {
        let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../data-fixtures/wavelet.json");
        let mut fixture: serde_json::Value = serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap();
        let images: Vec<Oracle> = serde_json::from_value(fixture["images"].take()).unwrap();
        assert_eq!(images.len(), 6);
        for image in images {
            let border = if image.border == "periodic" { Border::Periodic } else { Border::Reflect };
            let (rows, columns, x) = (image.x.len(), image.x[0].len(), image.x.concat());
            let (mut low, mut bands) = (Vec::new(), Bands::default());
            step(Image { samples: &x, rows, columns }, border, &mut low, &mut bands, &mut Vec::new());
            let Bands { horizontal, vertical, diagonal, .. } = &bands;
            let theirs = [&image.low, &image.horizontal, &image.vertical, &image.diagonal];
            for (ours, theirs) in [&low, horizontal, vertical, diagonal].into_iter().zip(theirs) {
                assert_eq!(ours.len(), rows * columns / 4);
                for (ours, theirs) in ours.iter().zip(theirs.concat()) {
                    assert!((ours - theirs).abs() < 1e-13, "{} {}: {ours} {theirs}", image.name, image.border);
                }
            }
            for (ours, x) in step_back(&low, &bands, border).iter().zip(&x) {
                assert!((ours - x).abs() < 1e-13, "{} {}: {ours} {x}", image.name, image.border);
            }
        }
    }

    #[test]
    fn half_of_a_symmetric_image_is_enough() {
        let (rows, columns) = (32, 16);
        let upper: Vec<f32> = (0..rows / 2 * columns).map(|n| ((n * 7919) % 101) as f32).collect();
        let whole: Vec<f32> = upper.chunks(columns).chain(upper.chunks(columns).rev()).flatten().copied().collect();
        let (mut by_half, mut by_whole) = (Pyramid::default(), Pyramid::default());
        by_half.analyse_rows(&upper, rows, columns, Border::Reflect);
        by_whole.analyse_rows(&whole, rows, columns, Border::Reflect);
        assert_eq!((by_half.levels, by_half.approximation), (by_whole.levels, by_whole.approximation));
    }

    #[test]
    fn levels_end_at_four_samples() {
        assert_eq!([level_count(8, 8), level_count(256, 256), level_count(1024, 16)], [1, 6, 2]);
        for (rows, columns) in [(4, 8), (8, 12), (0, 8)] {
            assert!(std::panic::catch_unwind(|| level_count(rows, columns)).is_err(), "{rows} x {columns}");
        }
    }
}
