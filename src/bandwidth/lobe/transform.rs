//! The wavelet transform of one channel of a sampled lobe, and the energies of its bands.

use crate::lobe::grid::{BASE, BASE_LEVELS, size};
use crate::lobe::sampled::SampledLobe;
use crate::lobe::window_filter::{FilterMemory, Patch, Window, reflect};
use crate::wavelet::daubechies::Border;
use crate::wavelet::energy::{Energies, LevelEnergy, Reflected};
use crate::wavelet::local_bandwidth::Estimator;
use crate::wavelet::pyramid::{Bands, Pyramid};

/// Samples by which the approximation of a smooth image reads beyond its own.
const REACH: usize = 2;

/// The transform of a reflection of one channel. Its memory serves one lobe after the other.
#[derive(Clone, Debug, Default)]
struct Transform {
    /// Levels of the coarsest resolution and beyond.
    pyramid: Pyramid<f32>,
    /// Detail inside the windows, finest last.
    bands: [Bands<f32>; 2],
    /// The channel as it is transformed.
    image: Vec<f32>,
    /// A reflected window.
    turned: Patch,
    /// The approximation of the finer resolutions: everywhere, and around the coarser window.
    approximation: Patch,
    around: Patch,
    /// The samples of the coarsest resolution and some beyond.
    smooth: Patch,
    filter: FilterMemory,
    scratch: Vec<f32>,
}

/// The energies per band of one lobe. Their memory serves one lobe after the other.
#[derive(Clone, Debug, Default)]
pub(crate) struct LobeEnergies {
    /// Of the channels R, G, B, averaged over the reflections.
    pub(crate) channels: [Energies; 3],
    /// Of two reflections.
    pair: Energies,
    transform: Transform,
}

impl LobeEnergies {
    /// Energies of all channels and bands at the present resolution of the lobe.
    pub(crate) fn compute(&mut self, lobe: &SampledLobe, estimator: &Estimator) {
        let fine = lobe.resolution();
        for channel in 0..3 {
            let energies = &mut self.channels[channel];
            for (level, window) in lobe.windows.iter().rev().enumerate() {
                clear_window(energies, level, window, fine - level);
            }
            energies.clear_pyramid(fine, BASE, BASE, BASE_LEVELS);
            let transform = &mut self.transform;
            add_reflections(energies, &mut self.pair, lobe.symmetric, estimator, false, |reflected, pair| {
                transform.whole(lobe, channel, reflected);
                for (level, bands) in transform.bands[..fine].iter().rev().enumerate() {
                    pair.add_bands(level, bands, reflected, estimator.weight());
                }
                pair.add_pyramid(fine, &transform.pyramid, reflected, estimator.weight());
            });
        }
    }

    /// Takes the energies of the last window in front of those of the resolution before.
    pub(crate) fn add_window(&mut self, lobe: &SampledLobe, estimator: &Estimator) {
        let finest = lobe.resolution() - 1;
        for channel in 0..3 {
            let energies = &mut self.channels[channel];
            energies.levels.insert(0, LevelEnergy::default());
            clear_window(energies, 0, &lobe.windows[finest], lobe.resolution());
            let transform = &mut self.transform;
            add_reflections(energies, &mut self.pair, lobe.symmetric, estimator, true, |reflected, pair| {
                transform.windows(lobe, channel, reflected);
                pair.add_bands(0, &transform.bands[finest], reflected, estimator.weight());
            });
        }
    }
}

/// Adds to `energies`, or to their finest level alone, what `add` finds for each reflection. A symmetric lobe is its own reflection
/// about the plane of incidence, so half of them follow from the others. `pair` is memory.
///
/// Pairs first: so the sum for a mirrored lobe is the mirrored sum bit for bit.
fn add_reflections(
    energies: &mut Energies,
    pair: &mut Energies,
    symmetric: bool,
    estimator: &Estimator,
    finest_only: bool,
    mut add: impl FnMut(Reflected, &mut Energies),
) {
    let turned = estimator.turned();
    for &rows in if symmetric { &turned[..1] } else { turned } {
        pair.clear_like(energies, finest_only);
        for &columns in turned {
            add(Reflected { columns, rows }, pair);
        }
        energies.add(pair, false);
        if symmetric && estimator.reflections {
            energies.add(pair, true);
        }
    }
}

/// Makes room for the energies of a window of which a texel has `2^(zoom + 1)` blocks along a side.
fn clear_window(energies: &mut Energies, level: usize, window: &Window, zoom: usize) {
    let blocks = 2 << zoom;
    let place = [window.rows.start, window.columns.start].map(|texel| texel * blocks);
    energies.clear_level(level, place, [window.rows.len(), window.columns.len()].map(|texels| texels * blocks));
}

impl Transform {
    /// All bands of one reflection: those of the windows, and the pyramid.
    fn whole(&mut self, lobe: &SampledLobe, channel: usize, reflected: Reflected) {
        if lobe.windows.is_empty() {
            self.base(lobe, channel, reflected);
        } else {
            self.windows(lobe, channel, reflected);
            self.pyramid.analyse_rows(&self.approximation.values, BASE, BASE, Border::Reflect);
        }
    }

    /// The pyramid of one reflection of the samples at the coarsest resolution.
    fn base(&mut self, lobe: &SampledLobe, channel: usize, reflected: Reflected) {
        let base = &lobe.base[channel];
        if reflected == Reflected::default() {
            self.pyramid.analyse_rows(base, BASE, BASE, Border::Reflect);
            return;
        }
        let rows = base.len() / BASE;
        self.image.clear();
        for r in 0..rows {
            let row = &base[if reflected.rows { rows - 1 - r } else { r } * BASE..][..BASE];
            if reflected.columns { self.image.extend(row.iter().rev()) } else { self.image.extend(row) }
        }
        self.pyramid.analyse_rows(&self.image, BASE, BASE, Border::Reflect);
    }

    /// Filters the windows of one reflection, finest first: the detail inside goes to `bands`, and the approximation, over the
    /// smooth one of the next resolution, ends in `approximation`.
    fn windows(&mut self, lobe: &SampledLobe, channel: usize, reflected: Reflected) {
        let fine = lobe.resolution();
        lobe.patches[0][channel].reflected(size(1), reflected.columns, reflected.rows, &mut self.turned);
        if fine == 2 {
            let Self { turned, around, bands, filter, scratch, .. } = self;
            around.resize(
                turned.top + 2..turned.top + turned.rows as isize - 2,
                turned.left + 2..turned.left + turned.columns as isize - 2,
            );
            turned.shifted(1, around, scratch);
            lobe.patches[1][channel].reflected(size(2), reflected.columns, reflected.rows, turned);
            turned.trim(2).filter(around, &mut bands[1], filter);
            around.close(size(1));
        } else {
            self.around = self.turned.trim(2);
        }
        self.copy_base(lobe, channel, reflected);
        self.approximation.resize(0..BASE as isize, 0..BASE as isize);
        self.smooth.shifted(fine, &mut self.approximation, &mut self.scratch);
        self.around.filter(&mut self.approximation, &mut self.bands[0], &mut self.filter);
    }

    /// One reflection of the samples at the coarsest resolution, with what lies beyond its sides.
    fn copy_base(&mut self, lobe: &SampledLobe, channel: usize, reflected: Reflected) {
        let range = -(REACH as isize)..(BASE + REACH) as isize;
        self.smooth.resize(range.clone(), range);
        for (r, out) in self.smooth.values.chunks_exact_mut(BASE + 2 * REACH).enumerate() {
            let r = reflect(r as isize - REACH as isize, BASE);
            let inner = &mut out[REACH..BASE + REACH];
            inner.copy_from_slice(lobe.base_row(channel, if reflected.rows { BASE - 1 - r } else { r }));
            if reflected.columns {
                inner.reverse();
            }
            (out[0], out[1], out[BASE + 2], out[BASE + 3]) = (out[3], out[2], out[BASE + 1], out[BASE]);
        }
    }
}
