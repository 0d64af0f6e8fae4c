//! Linear interpolation of block energies to sample positions.

use std::ops::Range;

use crate::wavelet::energy::{LevelEnergy, Plane};

/// Samples along one side of an image, four to each cell; blocks of all levels are halves, wholes or multiples of cells.
///
/// For an image of pixels a cell is four of them. For the atlas a cell is a texel.
#[derive(Clone, Debug)]
pub(crate) struct Axis {
    /// Per level, where each sample lies between the centres of two blocks.
    fractions: Vec<Vec<f32>>,
}

impl Axis {
    /// `count` samples at the positions `within` (0 to 1, one in each quarter) of each cell, for levels whose blocks have 1/2, 1, 2, 4 .. cells.
    pub(crate) fn new(count: usize, levels: usize, within: [f64; 4]) -> Self {
        let fraction = |level: usize, n: usize| {
            let blocks = 2.0 / f64::from(1 << level);
            let place = ((n / 4) as f64 + within[n % 4]) * blocks + 0.5;
            (place - place.floor()) as f32
        };
        Self { fractions: (0..levels).map(|level| (0..count).map(|n| fraction(level, n)).collect()).collect() }
    }

    /// Sample n lies between the centres of the blocks k - 1 and k of a level, at this fraction.
    #[inline(always)]
    fn place(&self, level: usize, n: usize) -> (usize, f32) {
        // half a block has 2^level samples
        ((n + (1 << level)) >> (level + 1), self.fractions[level][n])
    }
}

/// Between two values. Fractions have few bits, so `1 - t` is exact and exchanging the values gives the same bits.
#[inline(always)]
fn mix(a: f32, b: f32, t: f32) -> f32 {
    a * (1.0 - t) + b * t
}

/// Samples along a part of a row.
#[derive(Clone)]
pub(crate) struct RowSamples<'a> {
    pub(crate) rows: &'a Axis,
    pub(crate) row: usize,
    pub(crate) columns: &'a Axis,
    /// Four samples in each.
    pub(crate) cells: Range<usize>,
}

/// Writes the energies of a level at samples of a row: linear between the centres of blocks, held outside the outermost ones.
/// `scratch` holds at least half as many values as there are samples, and 4 more.
#[inline(always)]
pub(crate) fn interpolate_row(
    plane: &Plane,
    level: usize,
    samples: &RowSamples<'_>,
    out: &mut [f32],
    scratch: &mut [f32],
) {
    let (start, end) = (4 * samples.cells.start, 4 * samples.cells.end);
    let first = samples.columns.place(level, start).0;
    let last = samples.columns.place(level, end - 1).0;
    let blocks = &mut scratch[..last + 2 - first];
    mix_lines(plane, samples.rows.place(level, samples.row), first..last, blocks);
    let fractions = &samples.columns.fractions[level][start..end];
    match level {
        0 => across_half_cells(blocks, fractions, out),
        1 => across_cells(blocks, fractions, out),
        _ => across_many_cells(blocks, fractions, out, |k| {
            // half a block at either end
            ((2 * (first + k) + 1) << level).min(end) - start
        }),
    }
}

/// Mixes the two lines of blocks next to a row: `blocks[n]` is block `first + n - 1`, held at both ends.
#[inline(always)]
fn mix_lines(plane: &Plane, (k, t): (usize, f32), Range { start: first, end: last }: Range<usize>, blocks: &mut [f32]) {
    let line = |k: usize| &plane.values[k * plane.columns..][..plane.columns];
    let (upper, lower) = (line(k.saturating_sub(1)), line(k.min(plane.rows - 1)));
    let at = |k: usize| mix(upper[k], lower[k], t);
    blocks[0] = at(first.saturating_sub(1));
    let inner = first..last.min(plane.columns);
    for ((out, upper), lower) in blocks[1..].iter_mut().zip(&upper[inner.clone()]).zip(&lower[inner]) {
        *out = mix(*upper, *lower, t);
    }
    blocks[last + 1 - first] = at(last.min(plane.columns - 1));
}

/// Two blocks to a cell.
#[inline(always)]
fn across_half_cells(blocks: &[f32], fractions: &[f32], out: &mut [f32]) {
    let near = blocks.windows(4).step_by(2);
    for ((out, t), near) in out.chunks_exact_mut(4).zip(fractions.chunks_exact(4)).zip(near) {
        out[0] = mix(near[0], near[1], t[0]);
        out[1] = mix(near[1], near[2], t[1]);
        out[2] = mix(near[1], near[2], t[2]);
        out[3] = mix(near[2], near[3], t[3]);
    }
}

/// One block to a cell.
#[inline(always)]
fn across_cells(blocks: &[f32], fractions: &[f32], out: &mut [f32]) {
    for ((out, t), near) in out.chunks_exact_mut(4).zip(fractions.chunks_exact(4)).zip(blocks.windows(3)) {
        out[0] = mix(near[0], near[1], t[0]);
        out[1] = mix(near[0], near[1], t[1]);
        out[2] = mix(near[1], near[2], t[2]);
        out[3] = mix(near[1], near[2], t[3]);
    }
}

/// Blocks of several cells, from one centre to the next: the samples between block k and the next end before `end_of(k)`.
#[inline(always)]
fn across_many_cells(blocks: &[f32], fractions: &[f32], out: &mut [f32], end_of: impl Fn(usize) -> usize) {
    let mut from = 0;
    for (k, pair) in blocks.windows(2).enumerate() {
        let to = end_of(k);
        for (out, t) in out[from..to].iter_mut().zip(&fractions[from..to]) {
            *out = mix(pair[0], pair[1], *t);
        }
        from = to;
    }
}

/// Pixels of each cell of an image at which its samples lie.
#[derive(Clone, Debug)]
pub(crate) struct Pixels {
    /// Base 2 logarithm of the pixels of a cell.
    pub(crate) cell: usize,
    /// The pixels, one in each quarter.
    pub(crate) within: [usize; 4],
}

impl Pixels {
    /// The pixel of a sample.
    #[inline(always)]
    pub(crate) fn of(&self, sample: usize) -> usize {
        ((sample / 4) << self.cell) + self.within[sample % 4]
    }
}

/// Samples along a part of a row, by their pixels.
#[derive(Clone)]
pub(crate) struct RowPixels<'a> {
    pub(crate) rows: &'a Pixels,
    pub(crate) row: usize,
    pub(crate) columns: &'a Pixels,
    /// Four samples in each.
    pub(crate) cells: Range<usize>,
}

/// Writes the energies of a level that is finer than half a cell and known in a window only (blocks of `2^block` pixels), zero
/// outside the window. Tells whether the row meets the window; where neither it nor the row before does (`before`), nothing
/// needs to be written. `lines` is memory to be used again.
pub(crate) fn interpolate_window_row(
    energy: &LevelEnergy,
    block: usize,
    samples: &RowPixels<'_>,
    [sides, diagonals]: [&mut [f32]; 2],
    before: bool,
    lines: &mut Vec<f32>,
) -> bool {
    let RowPixels { rows: row_pixels, row, columns: pixels, ref cells } = *samples;
    let (rows, columns) = (energy.sides.rows, energy.sides.columns);
    // between which blocks of the window a pixel lies, and where; none outside
    let place = |pixel: usize, first: usize, count: usize| {
        let at = (pixel as f32 + 0.5) / (1 << block) as f32 - first as f32;
        if at < 0.0 || at >= count as f32 {
            return None;
        }
        let at = (at - 0.5).clamp(0.0, count as f32 - 1.0);
        let k = at as usize;
        Some((k, (k + 1).min(count - 1), at - k as f32))
    };
    let meets = place(row_pixels.of(row), energy.top, rows);
    if meets.is_some() || before {
        sides.fill(0.0);
        diagonals.fill(0.0);
    }
    let Some((upper, lower, t)) = meets else { return false };
    // the lines of blocks above and below, mixed once for all samples between them
    let line = |plane: &Plane, line: &mut [f32]| {
        let (upper, lower) = (&plane.values[upper * columns..][..columns], &plane.values[lower * columns..][..columns]);
        let mixed = line.iter_mut().zip(upper).zip(lower);
        mixed.for_each(|((out, upper), lower)| *out = mix(*upper, *lower, t));
    };
    lines.resize(2 * columns, 0.0);
    let (side_line, diagonal_line) = lines.split_at_mut(columns);
    line(&energy.sides, side_line);
    line(&energy.diagonals, diagonal_line);
    // cells that the window meets
    let bits = pixels.cell - block;
    let met = (energy.left >> bits).max(cells.start)..((energy.left + columns).div_ceil(1 << bits)).min(cells.end);
    for n in 4 * met.start..4 * met.end.max(met.start) {
        let Some((left, right, s)) = place(pixels.of(n), energy.left, columns) else { continue };
        sides[n - 4 * cells.start] = mix(side_line[left], side_line[right], s);
        diagonals[n - 4 * cells.start] = mix(diagonal_line[left], diagonal_line[right], s);
    }
    true
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The same by the definition: `place` counts cells.
    fn slow(plane: &Plane, level: usize, place: [f64; 2]) -> f64 {
        let blocks = 2.0 / f64::from(1 << level);
        let at = |place: f64, count: usize| (place * blocks - 0.5).clamp(0.0, count as f64 - 1.0);
        let (y, x) = (at(place[0], plane.rows), at(place[1], plane.columns));
        let value = |r: f64, c: f64| {
            let (r, c) = ((r as usize).min(plane.rows - 1), (c as usize).min(plane.columns - 1));
            f64::from(plane.values[r * plane.columns + c])
        };
        let (ty, tx) = (y.fract(), x.fract());
        let (y, x) = (y.floor(), x.floor());
        let line = |y: f64| (1.0 - tx) * value(y, x) + tx * value(y, x + 1.0);
        (1.0 - ty) * line(y) + ty * line(y + 1.0)
    }

    fn plane(rows: usize, columns: usize) -> Plane {
        Plane { rows, columns, values: (0..rows * columns).map(|n| ((n * 7919) % 101) as f32).collect() }
    }

    #[test]
    fn samples_lie_between_the_centres_of_blocks() {
        for within in [[0.125, 0.375, 0.625, 0.875], [0.5 / 16.0, 5.5 / 16.0, 10.5 / 16.0, 15.5 / 16.0]] {
            let (rows, columns) = (Axis::new(64, 4, within), Axis::new(128, 4, within));
            for level in 0..4 {
                let plane = plane(32 >> level, 64 >> level);
                for row in [0, 1, 13, 30, 41, 63] {
                    for cells in [0..32, 0..7, 3..12, 29..32, 13..14] {
                        let mut out = vec![0.0; 4 * cells.len()];
                        let samples = RowSamples { rows: &rows, row, columns: &columns, cells: cells.clone() };
                        interpolate_row(&plane, level, &samples, &mut out, &mut [0.0; 68]);
                        for (n, out) in (4 * cells.start..).zip(&out) {
                            let place = [row, n].map(|n| (n / 4) as f64 + within[n % 4]);
                            let expected = slow(&plane, level, place);
                            assert!(
                                (f64::from(*out) - expected).abs() < 1e-4,
                                "level {level} row {row}: {out} {expected}"
                            );
                        }
                    }
                }
            }
        }
    }

    #[test]
    fn a_window_is_interpolated_inside_and_zero_outside() {
        // 16 pixels to a cell, blocks of 2 pixels; the window covers the cells 3 .. 5 of either side
        let energy = LevelEnergy { top: 24, left: 24, sides: plane(16, 16), diagonals: plane(16, 16) };
        let pixels = Pixels { cell: 4, within: [0, 5, 10, 15] };
        let (mut sides, mut diagonals) = ([9.0; 32], [9.0; 32]);
        for row in [11, 12, 17, 19, 20] {
            let out = [&mut sides[..], &mut diagonals[..]];
            let samples = RowPixels { rows: &pixels, row, columns: &pixels, cells: 0..8 };
            let meets = interpolate_window_row(&energy, 1, &samples, out, true, &mut Vec::new());
            assert_eq!(meets, (12..20).contains(&row));
            for (n, side) in sides.iter().enumerate() {
                let place = |n: usize| (pixels.of(n) as f64 + 0.5) / 4.0 - 12.0;
                let inside = |n: usize| (12..20).contains(&n);
                let expected =
                    if inside(row) && inside(n) { slow(&energy.sides, 0, [place(row), place(n)]) } else { 0.0 };
                assert!((f64::from(*side) - expected).abs() < 1e-4, "{row} {n}: {side} {expected}");
                assert_eq!(*side, diagonals[n]);
            }
        }
    }
}
