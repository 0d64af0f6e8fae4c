//! The bandwidth of one outgoing lobe.

use std::ops::Range;

use brdfit_brdf::{Brdf, Direction};

use crate::lobe::grid::{BASE, LEVELS, LobeGrid, LobeSamples, RESOLUTIONS, size};
use crate::lobe::map::{MapInput, Rasters};
use crate::lobe::window_choice::window;
use crate::lobe::window_filter::{FilterMemory, Patch, Window, reflect, sum_of_squares};
use crate::wavelet::daubechies::Border;
use crate::wavelet::energy::{Energies, LevelEnergy, Reflected};
use crate::wavelet::local_bandwidth::Estimator;
use crate::wavelet::pyramid::{Bands, Pyramid};
use crate::wavelet::spectrum::Spectra;

/// Samples that filters need around a window.
const HALO: isize = 4;

/// How the lobes of a material are estimated.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LobeOptions {
    /// The estimator; its border is always reflected.
    pub estimator: Estimator,
    /// The resolution is doubled where the finest level holds more than this share of a channel's energy.
    pub finest_share: f64,
    /// The highest resolution: 256, 512 or 1024 samples along a side.
    pub max_resolution: usize,
}

impl Default for LobeOptions {
    fn default() -> Self {
        Self { estimator: Estimator::default(), finest_share: 5e-4, max_resolution: 1024 }
    }
}

/// The local bandwidth of an outgoing lobe on the angular map, 64 x 64 texels, each the maximum over its samples.
#[derive(Clone, Debug, PartialEq)]
pub struct Lobe {
    /// Cycles per radian of the channels R, G, B, row-major; 0 where the lobe does not vary, NaN where it has values that are not
    /// finite.
    pub texels: [Vec<f32>; 3],
    /// Samples along a side on which it was estimated.
    pub resolution: usize,
    /// Whether the finest level still held too much at the highest resolution: the lobe is sharper than the map tells.
    pub saturated: bool,
}

/// A material made ready to have the bandwidth of its lobes estimated (paper 000, section 2.3; docs/theory.md, "Lobes").
pub struct LobeEstimator<'a> {
    samples: LobeSamples<'a>,
    options: LobeOptions,
    mirrored: bool,
    rasters: Rasters,
}

/// Memory for the estimation of one lobe after the other.
#[derive(Clone, Debug, Default)]
pub struct LobeMemory {
    base: [Vec<f32>; 3],
    image: Vec<f32>,
    pyramid: Pyramid<f32>,
    energies: [Energies; 3],
    /// Of two reflections.
    pair: Energies,
    /// Sums of squares of the samples.
    sums: [f64; 3],
    spectra: Spectra,
    scratch: Vec<f32>,
    patches: [[Patch; 3]; 2],
    turned: Patch,
    coarse: [Patch; 2],
    smooth: Patch,
    bands: [Bands<f32>; 2],
    filter: FilterMemory,
}

impl<'a> LobeEstimator<'a> {
    /// `mirrored` tells that `f(i, .)` is mirror symmetric about the plane of incidence, as that of every isotropic material
    /// is: for incident directions at azimuth zero half of the work is saved.
    ///
    /// # Panics
    /// If the highest resolution is none of 256, 512, 1024.
    pub fn new(brdf: &'a dyn Brdf, grid: &'a LobeGrid, mirrored: bool, options: LobeOptions) -> Self {
        assert!(
            (0..RESOLUTIONS).any(|r| size(r) == options.max_resolution),
            "no resolution {}",
            options.max_resolution
        );
        Self { samples: LobeSamples::new(brdf, grid), options, mirrored, rasters: Rasters::default() }
    }

    /// Estimates the lobe of an incident direction (unit, above the horizon).
    pub fn estimate(&self, i: &Direction, memory: &mut LobeMemory) -> Lobe {
        let symmetric = self.mirrored && i.y == 0.0;
        self.sample_base(i, symmetric, &mut memory.base);
        let mirrored = if symmetric { 2.0 } else { 1.0 };
        memory.sums = memory.base.each_ref().map(|base| mirrored * sum_of_squares(base));
        let mut windows: Vec<Window> = Vec::new();
        self.transform(symmetric, &windows, memory);
        let mut saturated = self.is_too_sharp(memory);
        while saturated && size(windows.len()) < self.options.max_resolution {
            let delta = self.options.estimator.delta;
            let Some(window) = window(&memory.energies, windows.len(), delta, symmetric, windows.last()) else { break };
            windows.push(window);
            self.sample_window(i, symmetric, &windows, &mut memory.patches[windows.len() - 1]);
            self.add_window(symmetric, &windows, memory);
            Self::add_to_sums(&windows, memory);
            saturated = self.is_too_sharp(memory);
        }
        if !windows.is_empty() {
            self.transform(symmetric, &windows, memory);
        }
        let mut texels = [0, 1, 2].map(|channel| self.map(symmetric, &windows, channel, memory));
        // no map of what is not finite: an atlas refuses it
        if memory.sums.iter().any(|sum| !sum.is_finite()) {
            texels.iter_mut().for_each(|channel| channel.fill(f32::NAN));
        }
        Lobe { texels, resolution: size(windows.len()), saturated }
    }

    /// Whether the finest level holds too much of the energy of the lobe, the sum of squares of its samples, in any channel.
    fn is_too_sharp(&self, memory: &LobeMemory) -> bool {
        let channels = memory.energies.iter().zip(memory.sums);
        channels.into_iter().any(|(energies, sum)| energies.finest() > self.options.finest_share * sum)
    }

    /// Sums of squares of the samples of all channels, when the last window has been added: those outside, four times
    /// as dense as they were, and those of the window.
    fn add_to_sums(windows: &[Window], memory: &mut LobeMemory) {
        let (window, resolution) = (&windows[windows.len() - 1], windows.len());
        let pixels = |texels: &Range<usize>, resolution: usize| {
            (texels.start << (2 + resolution)) as isize..(texels.end << (2 + resolution)) as isize
        };
        for channel in 0..3 {
            let inside = |resolution: usize| {
                let (rows, columns) = (pixels(&window.rows, resolution), pixels(&window.columns, resolution));
                if resolution > 0 {
                    return memory.patches[resolution - 1][channel].energy(rows, columns);
                }
                let given = memory.base[channel].len() / BASE;
                let row = |r: isize| if (r as usize) < given { r as usize } else { BASE - 1 - r as usize };
                let columns = columns.start as usize..columns.end as usize;
                rows.map(|r| sum_of_squares(&memory.base[channel][row(r) * BASE..][columns.clone()])).sum()
            };
            memory.sums[channel] = 4.0 * (memory.sums[channel] - inside(resolution - 1)) + inside(resolution);
        }
    }

    /// Samples the whole lobe, or its upper half where the lower one mirrors it.
    fn sample_base(&self, i: &Direction, symmetric: bool, base: &mut [Vec<f32>; 3]) {
        let rows = if symmetric { BASE / 2 } else { BASE };
        let [r, g, b] = base;
        for plane in [&mut *r, &mut *g, &mut *b] {
            plane.resize(rows * BASE, 0.0);
        }
        let lines = r.chunks_exact_mut(BASE).zip(g.chunks_exact_mut(BASE)).zip(b.chunks_exact_mut(BASE));
        for (row, ((r, g), b)) in lines.enumerate() {
            self.samples.row(0, i, row, 0, [r, g, b]);
        }
    }

    /// Samples a window and its surroundings at a higher resolution.
    fn sample_window(&self, i: &Direction, symmetric: bool, windows: &[Window], out: &mut [Patch; 3]) {
        let (resolution, window) = (windows.len(), &windows[windows.len() - 1]);
        let (side, pixels) = (size(resolution) as isize, 4 << resolution);
        let around =
            |texels: &Range<usize>| (texels.start * pixels) as isize - HALO..(texels.end * pixels) as isize + HALO;
        for patch in &mut *out {
            patch.resize(around(&window.rows), around(&window.columns));
        }
        let [r, g, b] = out;
        let (columns, left) = (r.columns, r.left);
        let (first, last) = (left.max(0), (left + columns as isize).min(side));
        let inside = (first - left) as usize..(last - left) as usize;
        for row in 0..r.rows {
            let y = r.top + row as isize;
            if !(0..side).contains(&y) {
                continue;
            }
            let mirror = side - 1 - y - r.top;
            if symmetric && mirror >= 0 && mirror < row as isize {
                let from = mirror as usize * columns;
                for patch in [&mut *r, &mut *g, &mut *b] {
                    patch.values.copy_within(from..from + columns, row * columns);
                }
                continue;
            }
            let values = [&mut *r, &mut *g, &mut *b]
                .map(|patch| &mut patch.values[row * columns..(row + 1) * columns][inside.clone()]);
            self.samples.row(resolution, i, y as usize, first as usize, values);
        }
        for patch in out {
            patch.close(side as usize);
        }
    }

    /// Adds to `energies` what `add` finds for each reflection. A symmetric lobe is its own reflection about the plane of
    /// incidence, so half of them follow from the others.
    ///
    /// Pairs first: so the sum for a mirrored lobe is the mirrored sum bit for bit.
    fn add_reflections(
        &self,
        symmetric: bool,
        energies: &mut Energies,
        finest_only: bool,
        memory: &mut LobeMemory,
        mut add: impl FnMut(Reflected, &mut Energies, &mut LobeMemory),
    ) {
        let turned = self.options.estimator.turned();
        let mut pair = std::mem::take(&mut memory.pair);
        for &rows in if symmetric { &turned[..1] } else { turned } {
            pair.clear_like(energies, finest_only);
            for &columns in turned {
                add(Reflected { columns, rows }, &mut pair, memory);
            }
            energies.add(&pair, false);
            if symmetric && self.options.estimator.reflections {
                energies.add(&pair, true);
            }
        }
        memory.pair = pair;
    }

    /// Takes the energies of the finest window in front of those of the coarser resolution.
    fn add_window(&self, symmetric: bool, windows: &[Window], memory: &mut LobeMemory) {
        let finest = windows.len() - 1;
        for channel in 0..3 {
            let mut energies = std::mem::take(&mut memory.energies[channel]);
            energies.levels.insert(0, LevelEnergy::default());
            clear_window(&mut energies, 0, &windows[finest], windows.len());
            self.add_reflections(symmetric, &mut energies, true, memory, |reflected, pair, memory| {
                self.refine(channel, reflected, windows, memory);
                pair.add_bands(0, &memory.bands[finest], reflected, self.options.estimator.weight());
            });
            memory.energies[channel] = energies;
        }
    }

    /// Energies of all channels, averaged over the reflections, at the resolution of the last window.
    fn transform(&self, symmetric: bool, windows: &[Window], memory: &mut LobeMemory) {
        let fine = windows.len();
        for channel in 0..3 {
            let mut energies = std::mem::take(&mut memory.energies[channel]);
            for (level, window) in windows.iter().rev().enumerate() {
                clear_window(&mut energies, level, window, fine - level);
            }
            energies.clear_pyramid(fine, BASE, BASE, LEVELS);
            self.add_reflections(symmetric, &mut energies, false, memory, |reflected, pair, memory| {
                if windows.is_empty() {
                    self.transform_base(channel, reflected, memory);
                } else {
                    self.refine(channel, reflected, windows, memory);
                    memory.pyramid.analyse_rows(&memory.coarse[0].values, BASE, BASE, Border::Reflect);
                }
                for (level, bands) in memory.bands[..fine].iter().rev().enumerate() {
                    pair.add_bands(level, bands, reflected, self.options.estimator.weight());
                }
                pair.add_pyramid(fine, &memory.pyramid, reflected, self.options.estimator.weight());
            });
            memory.energies[channel] = energies;
        }
    }

    /// Transforms one reflection of one channel as it was sampled at the coarsest resolution.
    fn transform_base(&self, channel: usize, reflected: Reflected, memory: &mut LobeMemory) {
        let LobeMemory { base, image, pyramid, .. } = memory;
        let base = &base[channel];
        if reflected == Reflected::default() {
            pyramid.analyse_rows(base, BASE, BASE, Border::Reflect);
            return;
        }
        let rows = base.len() / BASE;
        image.clear();
        for r in 0..rows {
            let row = &base[if reflected.rows { rows - 1 - r } else { r } * BASE..][..BASE];
            if reflected.columns { image.extend(row.iter().rev()) } else { image.extend(row) }
        }
        pyramid.analyse_rows(image, BASE, BASE, Border::Reflect);
    }

    /// Filters the windows of one reflection of one channel, finest first: the detail inside goes to `bands` (finest last), and
    /// the approximation, over the smooth one of the next resolution, ends in `coarse[0]`.
    fn refine(&self, channel: usize, reflected: Reflected, windows: &[Window], memory: &mut LobeMemory) {
        let LobeMemory { base, patches, turned, coarse, smooth, bands, filter, scratch, .. } = memory;
        let [whole, around] = coarse;
        let fine = windows.len();
        patches[0][channel].reflected(size(1), reflected.columns, reflected.rows, turned);
        if fine == 2 {
            around.resize(
                turned.top + 2..turned.top + turned.rows as isize - 2,
                turned.left + 2..turned.left + turned.columns as isize - 2,
            );
            turned.shifted(1, around, scratch);
            patches[1][channel].reflected(size(2), reflected.columns, reflected.rows, turned);
            turned.trim(2).filter(around, &mut bands[1], filter);
            around.close(size(1));
        } else {
            *around = turned.trim(2);
        }
        smooth.resize(-2..BASE as isize + 2, -2..BASE as isize + 2);
        let rows = base[channel].len() / BASE;
        for (r, out) in smooth.values.chunks_exact_mut(BASE + 4).enumerate() {
            let r = reflect(r as isize - 2, BASE);
            let r = if reflected.rows { BASE - 1 - r } else { r };
            let row = &base[channel][if r < rows { r } else { BASE - 1 - r } * BASE..][..BASE];
            let inner = &mut out[2..BASE + 2];
            inner.copy_from_slice(row);
            if reflected.columns {
                inner.reverse();
            }
            (out[0], out[1], out[BASE + 2], out[BASE + 3]) = (out[3], out[2], out[BASE + 1], out[BASE]);
        }
        whole.resize(0..BASE as isize, 0..BASE as isize);
        smooth.shifted(fine, whole, scratch);
        around.filter(whole, &mut bands[0], filter);
    }

    fn map(&self, symmetric: bool, windows: &[Window], channel: usize, memory: &mut LobeMemory) -> Vec<f32> {
        let LobeMemory { energies, spectra, scratch, .. } = memory;
        let (energies, grid, estimator) = (&energies[channel], self.samples.grid(), &self.options.estimator);
        self.rasters.map(&MapInput { energies, windows, grid, estimator, symmetric }, spectra, scratch)
    }
}

/// Makes room for the energies of a window of which a texel has `2^(zoom + 1)` blocks along a side.
fn clear_window(energies: &mut Energies, level: usize, window: &Window, zoom: usize) {
    let blocks = 2 << zoom;
    let place = [window.rows.start, window.columns.start].map(|texel| texel * blocks);
    energies.clear_level(level, place, [window.rows.len(), window.columns.len()].map(|texels| texels * blocks));
}
