//! The local bandwidth of any two-dimensional signal.

use rayon::prelude::*;

use crate::wavelet::daubechies::Border;
use crate::wavelet::energy::{Energies, Reflected};
use crate::wavelet::energy_interpolation::{Axis, RowSamples, interpolate_row};
use crate::wavelet::pyramid::{COARSEST, Pyramid, level_count};
use crate::wavelet::spectrum::{Rule, Spectra};

/// Options of the estimation of local bandwidth; the default is that of the atlas.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Estimator {
    /// From energies per band to a frequency.
    pub rule: Rule,
    /// A band counts at a pixel where its energy is above `delta^2` times that of all bands and the mean together.
    pub delta: f64,
    /// Average over the four reflections of the image: the wavelet is not symmetric.
    pub reflections: bool,
    /// Border extension of the image.
    pub border: Border,
}

impl Default for Estimator {
    fn default() -> Self {
        Self { rule: Rule::Percentile(95.0), delta: 0.02, reflections: true, border: Border::Reflect }
    }
}

impl Estimator {
    /// The factor from the percentile of the energies to the bandwidth of the signal: the inverse of the median overestimate on
    /// sine gratings (docs/accuracy.md). 1 for the epsilon rule, as published.
    pub fn kappa(&self) -> f64 {
        match self.rule {
            Rule::Percentile(_) if self.reflections => 0.471,
            Rule::Percentile(_) => 0.480,
            Rule::Epsilon(_) => 1.0,
        }
    }

    /// The bandwidth of a signal around each of its `rows x columns` samples (row-major), in cycles per sample, at most
    /// `sqrt(1/2) kappa`; 0 where it does not vary.
    ///
    /// Sides that are not a power of two of at least 8 are extended to the next one by what the border says. Values must be
    /// finite, below 1e15 in magnitude; scaling them by a power of two changes nothing.
    ///
    /// # Panics
    /// If the number of values is not `rows x columns`, or zero.
    pub fn local_bandwidth(&self, values: &[f32], rows: usize, columns: usize) -> Vec<f32> {
        assert!(!values.is_empty() && values.len() == rows * columns, "{rows} x {columns} values expected");
        let side = |n: usize| n.next_power_of_two().max(2 * COARSEST);
        let (tall, wide) = (side(rows), side(columns));
        let place = |n: usize, count: usize| match self.border {
            Border::Periodic => n % count,
            Border::Reflect => (n % (2 * count)).min(2 * count - 1 - n % (2 * count)),
        };
        let mut image = Vec::with_capacity(tall * wide);
        for r in 0..tall {
            let row = &values[place(r, rows) * columns..][..columns];
            image.extend((0..wide).map(|c| row[place(c, columns)]));
        }
        let map = self.map(&image, tall, wide);
        if (tall, wide) == (rows, columns) {
            return map;
        }
        map.chunks_exact(wide).take(rows).flat_map(|row| &row[..columns]).copied().collect()
    }

    /// The bandwidth of a signal of finite extent, zero outside, as an area light is: estimated in an image of twice the
    /// size and cropped (Bagher 2013, section 2.3). Otherwise as [`Self::local_bandwidth`].
    ///
    /// # Panics
    /// If the number of values is not `rows x columns`, or zero.
    pub fn bandwidth_in_the_dark(&self, values: &[f32], rows: usize, columns: usize) -> Vec<f32> {
        assert!(!values.is_empty() && values.len() == rows * columns, "{rows} x {columns} values expected");
        let (top, left) = (rows / 2, columns / 2);
        let mut padded = vec![0.0; 4 * rows * columns];
        for (row, from) in padded.chunks_exact_mut(2 * columns).skip(top).zip(values.chunks_exact(columns)) {
            row[left..left + columns].copy_from_slice(from);
        }
        let map = self.local_bandwidth(&padded, 2 * rows, 2 * columns);
        map.chunks_exact(2 * columns).skip(top).take(rows).flat_map(|row| &row[left..left + columns]).copied().collect()
    }

    /// The map of an image with sides that the transform takes.
    fn map(&self, image: &[f32], rows: usize, columns: usize) -> Vec<f32> {
        let count = level_count(rows, columns);
        let mut pyramid = Pyramid::default();
        let mut energies = Energies::default();
        energies.clear_pyramid(0, rows, columns, count);
        let (turned, weight) = (self.turned(), self.weight());
        // pairs first: so the sum for a mirrored image is the mirrored sum bit for bit
        let mut pair = Energies::default();
        for &by_rows in turned {
            pair.clear_like(&energies, false);
            for &by_columns in turned {
                let reflected = Reflected { rows: by_rows, columns: by_columns };
                pyramid.analyse(&reflect(image, columns, reflected), rows, columns, self.border);
                pair.add_pyramid(0, &pyramid, reflected, weight);
            }
            energies.add(&pair, false);
        }
        let axes = [rows, columns].map(|side| Axis::new(side, count, [0.125, 0.375, 0.625, 0.875]));
        let mut map = vec![0.0; rows * columns];
        map.par_chunks_mut(columns).enumerate().for_each_init(
            || (Spectra::new(columns, count), vec![0.0; columns / 2 + 4]),
            |(spectra, scratch), (r, out)| {
                let row = RowSamples { rows: &axes[0], row: r, columns: &axes[1], cells: 0..columns / 4 };
                for (level, energy) in energies.levels.iter().enumerate() {
                    let [sides, diagonals] = spectra.level(level);
                    interpolate_row(&energy.sides, level, &row, sides, scratch);
                    interpolate_row(&energy.diagonals, level, &row, diagonals, scratch);
                }
                interpolate_row(&energies.mean, count - 1, &row, spectra.mean(), scratch);
                let frequencies = self.frequencies(spectra);
                for (out, log2) in out.iter_mut().zip(frequencies) {
                    *out = self.calibrated(*log2);
                }
            },
        );
        map
    }

    /// Whether the image is exchanged along a side, for each transform that the average takes.
    pub(crate) fn turned(&self) -> &'static [bool] {
        if self.reflections { &[false, true] } else { &[false] }
    }

    /// Share of one transform in the average over all reflections.
    pub(crate) fn weight(&self) -> f32 {
        if self.reflections { 0.25 } else { 1.0 }
    }

    /// The bandwidth of which [`Self::frequencies`] gives the logarithm, in the unit of that.
    pub(crate) fn calibrated(&self, log2: f32) -> f32 {
        if log2 == f32::NEG_INFINITY { 0.0 } else { self.kappa() as f32 * libm::exp2f(log2) }
    }

    /// Base 2 logarithms of the bandwidths that belong to the spectra, in cycles per sample of the finest level, before calibration;
    /// negative infinity where nothing varies.
    #[inline(always)]
    pub(crate) fn frequencies<'a>(&self, spectra: &'a mut Spectra) -> &'a [f32] {
        match self.rule {
            Rule::Percentile(percent) => {
                spectra.percentiles(((100.0 - percent) / 100.0) as f32, (self.delta * self.delta) as f32)
            }
            Rule::Epsilon(epsilon) => spectra.finest_levels(epsilon as f32),
        }
    }
}

/// The image read backwards along its rows, its columns, or both.
fn reflect(image: &[f32], columns: usize, reflected: Reflected) -> Vec<f32> {
    let mut out = image.to_vec();
    if reflected.columns {
        out.chunks_exact_mut(columns).for_each(<[f32]>::reverse);
    }
    if reflected.rows {
        out = out.chunks_exact(columns).rev().flatten().copied().collect();
    }
    out
}

/// Samples per unit of length, or per radian, of an image that is laid out over a surface, or over directions: the geometric mean over
/// all orientations, from the derivatives of the position (or the unit direction) by one sample along a row and along a column.
///
/// A bandwidth in cycles per sample times this is one in cycles per metre (or per radian).
pub fn samples_per_unit(along_row: [f64; 3], along_column: [f64; 3]) -> f64 {
    let [a, b] = [along_row, along_column];
    let cross = [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
    // the product of the singular values of a 3 x 2 matrix is the area that its columns span
    1.0 / cross.iter().map(|x| x * x).sum::<f64>().sqrt().sqrt()
}
