//! The bandwidth map of a lobe from the energies of its bands.

use crate::lobe::grid::{BASE_LEVELS, LOBE_TEXELS, LobeGrid, RESOLUTIONS};
use crate::lobe::window_filter::Window;
use crate::wavelet::energy::Energies;
use crate::wavelet::energy_interpolation::{
    Axis, Pixels, RowPixels, RowSamples, interpolate_row, interpolate_window_row,
};
use crate::wavelet::local_bandwidth::Estimator;
use crate::wavelet::simd_dispatch::dispatch_simd;
use crate::wavelet::spectrum::Spectra;

/// Samples along a side at which the map is evaluated: four per texel.
const MAP_SAMPLES: usize = 4 * LOBE_TEXELS;

/// Pixels of a texel at which the map is evaluated, per resolution: the outermost ones are there. In the core of the finest
/// window all are.
const WITHIN: [[usize; 4]; RESOLUTIONS] = [[0, 1, 2, 3], [0, 2, 5, 7], [0, 5, 10, 15]];

/// Samples along one side of a lobe, four per texel.
struct Raster {
    axis: Axis,
    pixels: Pixels,
}

/// Incident directions at which lobes are evaluated.
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
                let axis = Axis::new(MAP_SAMPLES, BASE_LEVELS, within.map(|pixel| (pixel as f64 + 0.5) / pixels));
                Raster { axis, pixels: Pixels { cell: 2 + r, within } }
            };
            std::iter::once(WITHIN[r]).chain(all).map(raster).collect()
        });
        Self { rasters }
    }
}

/// Memory for one map after the other.
#[derive(Clone, Debug, Default)]
pub(crate) struct MapMemory {
    spectra: Spectra,
    blocks: Vec<f32>,
    lines: Vec<f32>,
}

/// Inputs of the map of a channel.
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
    pub(crate) fn map(&self, input: &MapInput<'_>, memory: &mut MapMemory) -> Vec<f32> {
        let rows = if input.symmetric { LOBE_TEXELS / 2 } else { LOBE_TEXELS };
        let mut texels = vec![f32::NEG_INFINITY; LOBE_TEXELS * LOBE_TEXELS];
        let (some, all) = self.rasters[input.windows.len()].split_at(1);
        input.raise([&some[0]; 2], &Window { rows: 0..rows, columns: 0..LOBE_TEXELS }, memory, &mut texels);
        if let Some(window) = input.windows.last().map(Window::core) {
            let window = Window { rows: window.rows.start..window.rows.end.min(rows), columns: window.columns.clone() };
            for row_raster in all {
                for raster in all {
                    input.raise([row_raster, raster], &window, memory, &mut texels);
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
    fn raise(&self, [row_raster, raster]: [&Raster; 2], window: &Window, memory: &mut MapMemory, texels: &mut [f32]) {
        let resolution = self.windows.len();
        let cells = &window.columns;
        memory.spectra.shape(4 * cells.len(), BASE_LEVELS + resolution);
        memory.blocks.resize(MAP_SAMPLES, 0.0);
        let mut meets = [true; RESOLUTIONS];
        for row in 4 * window.rows.start..4 * window.rows.end {
            let pixels = RowPixels { rows: &row_raster.pixels, row, columns: &raster.pixels, cells: cells.clone() };
            for (level, energy) in self.energies.levels[..resolution].iter().enumerate() {
                let out = memory.spectra.level(level);
                let before = meets[level];
                meets[level] = interpolate_window_row(energy, level + 1, &pixels, out, before, &mut memory.lines);
            }
            let samples = RowSamples { rows: &row_raster.axis, row, columns: &raster.axis, cells: cells.clone() };
            let log2_scale = self.grid.log2_scale(resolution, row_raster.pixels.of(row));
            let out = &mut texels[row / 4 * LOBE_TEXELS..][..LOBE_TEXELS][cells.clone()];
            dispatch_simd(
                #[inline(always)]
                || self.raise_row(&samples, &raster.pixels, log2_scale, memory, out),
            );
        }
    }

    /// Raises the texels of a row to the samples of that row; the levels that are known in a window only are in the spectra.
    #[inline(always)]
    fn raise_row(
        &self,
        samples: &RowSamples<'_>,
        pixels: &Pixels,
        log2_scale: &[f32],
        memory: &mut MapMemory,
        out: &mut [f32],
    ) {
        let resolution = self.windows.len();
        let MapMemory { spectra, blocks, .. } = memory;
        for (level, energy) in self.energies.levels[resolution..].iter().enumerate() {
            let [sides, diagonals] = spectra.level(resolution + level);
            interpolate_row(&energy.sides, level, samples, sides, blocks);
            interpolate_row(&energy.diagonals, level, samples, diagonals, blocks);
        }
        interpolate_row(&self.energies.mean, BASE_LEVELS - 1, samples, spectra.mean(), blocks);
        let frequencies = self.estimator.frequencies(spectra);
        for ((c, out), frequencies) in samples.cells.clone().zip(out).zip(frequencies.chunks_exact(4)) {
            let scale = &log2_scale[c << (2 + resolution)..];
            for (within, frequency) in pixels.within.iter().zip(frequencies) {
                *out = out.max(frequency + scale[*within]);
            }
        }
    }
}
