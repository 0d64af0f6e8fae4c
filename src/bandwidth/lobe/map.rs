//! From the energies of a lobe to the map of its bandwidth.

use crate::lobe::grid::{LEVELS, LOBE_TEXELS, LobeGrid, RESOLUTIONS};
use crate::lobe::window_filter::Window;
use crate::wavelet::energy::Energies;
use crate::wavelet::energy_interpolation::{Axis, Pixels, expand_row, expand_window};
use crate::wavelet::local_bandwidth::Estimator;
use crate::wavelet::simd_dispatch::vectorise;
use crate::wavelet::spectrum::Spectra;

/// Samples along a side at which the map is evaluated: four per texel.
const SAMPLES: usize = 4 * LOBE_TEXELS;

/// Pixels of a texel at which the map is evaluated, per resolution: the outermost ones are there. In the core of the finest
/// window all are.
const WITHIN: [[usize; 4]; RESOLUTIONS] = [[0, 1, 2, 3], [0, 2, 5, 7], [0, 5, 10, 15]];

/// Samples along one side of a lobe, four per texel.
struct Raster {
    axis: Axis,
    pixels: Pixels,
}

/// Where lobes are evaluated.
pub(crate) struct Rasters {
    /// Per resolution, samples at [`WITHIN`], and then those that together are all pixels of a texel.
    rasters: [Vec<Raster>; RESOLUTIONS],
}

impl Default for Rasters {
    fn default() -> Self {
        let rasters = std::array::from_fn(|r| {
            let all = (0..1 << r).map(|k| [0, 1, 2, 3].map(|quarter| (quarter << r) + k));
            let raster = |within: [usize; 4]| {
                let pixels = f64::from(4 << r);
                let axis = Axis::new(SAMPLES, LEVELS, within.map(|pixel| (pixel as f64 + 0.5) / pixels));
                Raster { axis, pixels: Pixels { cell: 2 + r, within } }
            };
            std::iter::once(WITHIN[r]).chain(all).map(raster).collect()
        });
        Self { rasters }
    }
}

/// What the map of a channel is made of.
pub(crate) struct MapInput<'a> {
    pub(crate) energies: &'a Energies,
    /// The windows of the finer resolutions, finest last.
    pub(crate) windows: &'a [Window],
    pub(crate) grid: &'a LobeGrid,
    pub(crate) estimator: &'a Estimator,
    /// Whether the lower half mirrors the upper one.
    pub(crate) symmetric: bool,
}

impl Rasters {
    /// The map of a channel, cycles per radian, 64 x 64 texels.
    pub(crate) fn map(&self, input: &MapInput<'_>, spectra: &mut Spectra, scratch: &mut Vec<f32>) -> Vec<f32> {
        let rows = if input.symmetric { LOBE_TEXELS / 2 } else { LOBE_TEXELS };
        let mut texels = vec![f32::NEG_INFINITY; LOBE_TEXELS * LOBE_TEXELS];
        let (some, all) = self.rasters[input.windows.len()].split_at(1);
        input.raise([&some[0]; 2], &Window { rows: 0..rows, columns: 0..LOBE_TEXELS }, spectra, scratch, &mut texels);
        if let Some(window) = input.windows.last().map(Window::core) {
            let window = Window { rows: window.rows.start..window.rows.end.min(rows), columns: window.columns.clone() };
            for row_raster in all {
                for raster in all {
                    input.raise([row_raster, raster], &window, spectra, scratch, &mut texels);
                }
            }
        }
        texels.iter_mut().for_each(|texel| *texel = input.estimator.calibrated(*texel));
        if input.symmetric {
            let (upper, lower) = texels.split_at_mut(LOBE_TEXELS * LOBE_TEXELS / 2);
            let upper = upper.chunks_exact(LOBE_TEXELS).rev();
            upper.zip(lower.chunks_exact_mut(LOBE_TEXELS)).for_each(|(from, to)| to.copy_from_slice(from));
        }
        texels
    }
}

impl MapInput<'_> {
    /// Raises the texels of a window, base 2 logarithms of cycles per radian before calibration, to the largest of their samples.
    fn raise(
        &self,
        [row_raster, raster]: [&Raster; 2],
        window: &Window,
        spectra: &mut Spectra,
        scratch: &mut Vec<f32>,
        texels: &mut [f32],
    ) {
        let resolution = self.windows.len();
        let cells = window.columns.clone();
        spectra.shape(4 * cells.len(), LEVELS + resolution);
        scratch.resize(SAMPLES, 0.0);
        let mut meets = [true; RESOLUTIONS];
        let lines = &mut Vec::new();
        for row in 4 * window.rows.start..4 * window.rows.end {
            let out = &mut texels[row / 4 * LOBE_TEXELS..][..LOBE_TEXELS][cells.clone()];
            let log2_scale = self.grid.log2_scale(resolution, row_raster.pixels.of(row));
            for (level, energy) in self.energies.levels[..resolution].iter().enumerate() {
                let (rows, columns) = ((&row_raster.pixels, row), (&raster.pixels, cells.clone()));
                let before = (meets[level], &mut *lines);
                meets[level] = expand_window(energy, level + 1, rows, columns, spectra.level(level), before);
            }
            vectorise(
                #[inline(always)]
                || {
                    let rows = (&row_raster.axis, row);
                    let columns = || (&raster.axis, cells.clone());
                    for (level, energy) in self.energies.levels[resolution..].iter().enumerate() {
                        let [sides, diagonals] = spectra.level(resolution + level);
                        expand_row(&energy.sides, level, rows, columns(), sides, scratch);
                        expand_row(&energy.diagonals, level, rows, columns(), diagonals, scratch);
                    }
                    expand_row(&self.energies.mean, LEVELS - 1, rows, columns(), spectra.mean(), scratch);
                    let frequencies = self.estimator.frequencies(spectra);
                    for ((c, out), frequencies) in cells.clone().zip(&mut *out).zip(frequencies.chunks_exact(4)) {
                        let scale = &log2_scale[c << (2 + resolution)..];
                        for (within, frequency) in raster.pixels.within.iter().zip(frequencies) {
                            *out = out.max(frequency + scale[*within]);
                        }
                    }
                },
            );
        }
    }
}
