//! The part of a lobe that is worth a higher resolution.

use std::ops::Range;

use crate::energy::{Energies, Plane};
use crate::lobe::LOBE_TEXELS;
use crate::lobe_grid::{LEVELS, RESOLUTIONS};
use crate::refine::Window;

/// Texels of a window beyond those in which the finest level counts.
const MARGIN: usize = 2;

/// Texels along a side of a window at most, by the resolution that it refines.
const LARGEST_WINDOW: [usize; RESOLUTIONS - 1] = [20, 14];

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
    let mut all = 0.0;
    let mut finest = 0.0;
    for (level, energy) in energies.levels.iter().enumerate() {
        let largest = |plane: &Plane| {
            let per_texel = (2 << resolution) >> level;
            if per_texel == 0 {
                let shift = level - resolution - 1;
                return plane.values[(row >> shift) * plane.columns + (column >> shift)];
            }
            let (top, left) = (row * per_texel, column * per_texel);
            let mut largest = 0.0_f32;
            for r in top..top + per_texel {
                for c in left..left + per_texel {
                    let inside = r >= energy.top && c >= energy.left;
                    if inside && r - energy.top < plane.rows && c - energy.left < plane.columns {
                        largest = largest.max(plane.values[(r - energy.top) * plane.columns + c - energy.left]);
                    }
                }
            }
            largest
        };
        let (sides, diagonals) = (largest(&energy.sides), largest(&energy.diagonals));
        if level == 0 {
            finest = sides.max(diagonals);
        }
        all += sides + diagonals;
    }
    let shift = LEVELS - 2;
    all += energies.mean.values[(row >> shift) * energies.mean.columns + (column >> shift)];
    // half the limit: the neighbours' share in the interpolation
    (f64::from(finest) > 0.5 * delta * delta * f64::from(all)).then_some(finest)
}
