//! Selection of the window of a lobe that needs a higher resolution.

use std::ops::Range;

use crate::lobe::grid::{BASE_LEVELS, LOBE_TEXELS, RESOLUTIONS};
use crate::lobe::window_filter::Window;
use crate::wavelet::energy::{Energies, LevelEnergy, Plane};

/// Texels of a window beyond those in which the finest level counts.
const MARGIN: usize = 2;

/// Texels along a side of a window at most, by the resolution that it refines.
const LARGEST_WINDOW: [usize; RESOLUTIONS - 1] = [16, 12];

impl Window {
    /// The window without the outer half of its margin.
    pub(crate) fn core(&self) -> Self {
        let core = |texels: &Range<usize>| {
            let margin = |at_the_border: bool| if at_the_border { 0 } else { MARGIN / 2 };
            texels.start + margin(texels.start == 0)..texels.end - margin(texels.end == LOBE_TEXELS)
        };
        let [rows, columns] = [core(&self.rows), core(&self.columns)];
        if rows.is_empty() || columns.is_empty() { self.clone() } else { Self { rows, columns } }
    }
}

/// The texels around which the finest level counts at the present resolution, in any channel; inside the window in which it
/// is known. `None` where it counts nowhere.
///
/// A window that would be large is one around the peak alone, where most of the finest energy lies: measured lobes
/// have fine detail along the whole rim, which is noise of grazing measurements. Unless there is no other, the peak is
/// sought away from there. The window of a symmetric lobe lies around the plane of incidence.
pub(crate) fn window(
    energies: &[Energies; 3],
    resolution: usize,
    delta: f64,
    symmetric: bool,
    known: Option<&Window>,
) -> Option<Window> {
    let all = 0..LOBE_TEXELS;
    let bounds = known.map_or((all.clone(), all), |window| (window.rows.clone(), window.columns.clone()));
    let mut found: Option<Window> = None;
    let mut peak: Option<(bool, f32, [usize; 2])> = None;
    for row in bounds.0.clone() {
        for column in bounds.1.clone() {
            let finest = energies.iter().filter_map(|energies| counted(energies, resolution, delta, [row, column]));
            let Some(finest) = finest.max_by(f32::total_cmp) else { continue };
            found = Some(match found {
                None => Window { rows: row..row + 1, columns: column..column + 1 },
                Some(Window { rows, columns }) => Window {
                    rows: rows.start..row + 1,
                    columns: columns.start.min(column)..columns.end.max(column + 1),
                },
            });
            let inside = !is_near_rim(row, column);
            if peak.is_none_or(|(found_inside, most, _)| (inside, finest) > (found_inside, most)) {
                peak = Some((inside, finest, [row, column]));
            }
        }
    }
    let (found, (_, _, [row, column])) = (found?, peak?);
    let half = LARGEST_WINDOW[resolution] / 2;
    let around = |range: Range<usize>, near: Range<usize>, bounds: &Range<usize>| {
        let wide = range.start.saturating_sub(MARGIN)..range.end + MARGIN;
        let chosen = if wide.len() > 2 * half { near.start.max(wide.start)..near.end.min(wide.end) } else { wide };
        chosen.start.max(bounds.start)..chosen.end.min(bounds.end)
    };
    let near = |peak: usize| peak.saturating_sub(half)..peak + 1 + half;
    // the window of a symmetric lobe is symmetric, and of a lobe that peaks in the middle the same
    let middle = LOBE_TEXELS / 2;
    let in_the_middle = symmetric || row == middle || row == middle - 1;
    let near_rows = if in_the_middle { middle - half..middle + half } else { near(row) };
    let rows = around(found.rows, near_rows, &bounds.0);
    Some(Window { rows, columns: around(found.columns, near(column), &bounds.1) })
}

/// Whether a texel lies within four texels of the rim (above 79 degrees), or outside.
fn is_near_rim(row: usize, column: usize) -> bool {
    let from_centre = |n: usize| n as f64 + 0.5 - LOBE_TEXELS as f64 / 2.0;
    let radius = LOBE_TEXELS as f64 / 2.0 - 4.0;
    from_centre(row).powi(2) + from_centre(column).powi(2) > radius * radius
}

/// The largest energy of the finest level in a texel, where it counts or nearly so.
fn counted(energies: &Energies, resolution: usize, delta: f64, [row, column]: [usize; 2]) -> Option<f32> {
    // levels with blocks of half a texel and less: the largest block; the others: the block itself
    let largest = |level: usize, plane: &Plane| {
        let energy = &energies.levels[level];
        let per_texel = (2 << resolution) >> level;
        if per_texel == 0 {
            let shift = level - resolution - 1;
            return plane.values[(row >> shift) * plane.columns + (column >> shift)];
        }
        let inside = |texel: usize, first: usize, count: usize| {
            (texel * per_texel).max(first) - first..((texel + 1) * per_texel).clamp(first, first + count) - first
        };
        let columns = inside(column, energy.left, plane.columns);
        let rows = inside(row, energy.top, plane.rows);
        let blocks = rows.flat_map(|r| &plane.values[r * plane.columns..][columns.clone()]);
        blocks.fold(0.0_f32, |largest, &energy| largest.max(energy))
    };
    let of = |level: usize| {
        let LevelEnergy { sides, diagonals, .. } = &energies.levels[level];
        (largest(level, sides), largest(level, diagonals))
    };
    let (sides, diagonals) = of(0);
    let finest = sides.max(diagonals);
    // half the limit: the neighbours' share in the interpolation
    let counts = |all: f32| f64::from(finest) > 0.5 * delta * delta * f64::from(all);
    // from the coarsest level on: most texels are settled there
    let shift = BASE_LEVELS - 2;
    let mut all = energies.mean.values[(row >> shift) * energies.mean.columns + (column >> shift)];
    for level in (0..energies.levels.len()).rev() {
        if !counts(all) {
            return None;
        }
        let (sides, diagonals) = of(level);
        all += sides + diagonals;
    }
    counts(all).then_some(finest)
}
