//! The samples of one lobe: the whole lobe at the coarsest resolution, a window at each finer one.

use std::ops::Range;

use brdfit_brdf::Direction;

use crate::lobe::grid::{BASE, LobeSampler, RESOLUTIONS, size};
use crate::lobe::window_filter::{Patch, Window, sum_of_squares};

/// Samples that filters need around a window.
const HALO: isize = 4;

/// A lobe of a material, sampled as finely as it was asked for.
#[derive(Clone, Debug, Default)]
pub(crate) struct SampledLobe {
    /// Whether the lower half mirrors the upper one; then the lower half of `base` is not there.
    pub(crate) symmetric: bool,
    /// Channels R, G, B at the coarsest resolution, row by row.
    pub(crate) base: [Vec<f32>; 3],
    /// The windows of the finer resolutions, finest last.
    pub(crate) windows: Vec<Window>,
    /// The channels in each window and a little around it.
    pub(crate) patches: [[Patch; 3]; RESOLUTIONS - 1],
    /// Sums of squares of all samples per channel, those of a finer resolution where there are some.
    sums: [f64; 3],
}

impl SampledLobe {
    /// Number of doublings of the resolution.
    pub(crate) fn resolution(&self) -> usize {
        self.windows.len()
    }

    /// Energy per channel: the sum of squares of the samples, at the present resolution.
    pub(crate) fn energies(&self) -> [f64; 3] {
        self.sums
    }

    /// Row `r` of a channel at the coarsest resolution, also of the half that mirrors the other.
    pub(crate) fn base_row(&self, channel: usize, r: usize) -> &[f32] {
        let base = &self.base[channel];
        let r = if r < base.len() / BASE { r } else { BASE - 1 - r };
        &base[r * BASE..][..BASE]
    }

    /// Samples the whole lobe, or its upper half where the lower one mirrors it, at the coarsest resolution.
    pub(crate) fn sample(&mut self, sampler: &LobeSampler<'_>, i: &Direction, symmetric: bool) {
        self.symmetric = symmetric;
        self.windows.clear();
        let rows = if symmetric { BASE / 2 } else { BASE };
        let [r, g, b] = &mut self.base;
        for plane in [&mut *r, &mut *g, &mut *b] {
            plane.resize(rows * BASE, 0.0);
        }
        let lines = r.chunks_exact_mut(BASE).zip(g.chunks_exact_mut(BASE)).zip(b.chunks_exact_mut(BASE));
        for (row, ((r, g), b)) in lines.enumerate() {
            sampler.row(0, i, row, 0, [r, g, b]);
        }
        let copies = if symmetric { 2.0 } else { 1.0 };
        self.sums = self.base.each_ref().map(|base| copies * sum_of_squares(base));
    }

    /// Doubles the resolution in a window, which lies inside the one before.
    pub(crate) fn sample_window(&mut self, sampler: &LobeSampler<'_>, i: &Direction, window: Window) {
        self.windows.push(window);
        self.sample_patches(sampler, i);
        self.update_sums();
    }

    /// Samples the last window and its surroundings.
    fn sample_patches(&mut self, sampler: &LobeSampler<'_>, i: &Direction) {
        let resolution = self.resolution();
        let window = &self.windows[resolution - 1];
        let out = &mut self.patches[resolution - 1];
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
            if self.symmetric && mirror >= 0 && mirror < row as isize {
                let from = mirror as usize * columns;
                for patch in [&mut *r, &mut *g, &mut *b] {
                    patch.values.copy_within(from..from + columns, row * columns);
                }
                continue;
            }
            let values = [&mut *r, &mut *g, &mut *b]
                .map(|patch| &mut patch.values[row * columns..(row + 1) * columns][inside.clone()]);
            sampler.row(resolution, i, y as usize, first as usize, values);
        }
        for patch in out {
            patch.close(side as usize);
        }
    }

    /// Sums of squares when the last window has been added: of the samples outside, four times as dense as they were, and of
    /// those inside.
    fn update_sums(&mut self) {
        let resolution = self.resolution();
        for channel in 0..3 {
            let [before, now] = [resolution - 1, resolution].map(|resolution| self.energy_inside(channel, resolution));
            self.sums[channel] = 4.0 * (self.sums[channel] - before) + now;
        }
    }

    /// Sum of squares of a channel in the last window, at a resolution.
    fn energy_inside(&self, channel: usize, resolution: usize) -> f64 {
        let window = &self.windows[self.windows.len() - 1];
        let pixels = |texels: &Range<usize>| {
            (texels.start << (2 + resolution)) as isize..(texels.end << (2 + resolution)) as isize
        };
        let (rows, columns) = (pixels(&window.rows), pixels(&window.columns));
        if resolution > 0 {
            return self.patches[resolution - 1][channel].energy(rows, columns);
        }
        let columns = columns.start as usize..columns.end as usize;
        rows.map(|r| sum_of_squares(&self.base_row(channel, r as usize)[columns.clone()])).sum()
    }
}
