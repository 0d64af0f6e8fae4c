//! Stencils of interpolated cells: weights of the four nearest cells of the next coarser level, or Catmull-Rom over sixteen
//! where the surface is smooth enough.

use wide::f32x4;

use crate::geometry::gbuffer::GBuffer;
use crate::geometry::grazing::LEAST_COSINE;
use crate::passes::pyramid::{Cell, Extent};

/// A cell with a smaller total weight cannot be interpolated.
const LEAST_WEIGHT: f32 = 0.01;
/// Least weight of a parent, that of a perpendicular normal: a poor parent is better than none.
const LEAST_NORMAL_WEIGHT: f32 = 1e-6;
/// Catmull-Rom needs parents whose normals have at least this cosine with the cell's.
const CUBIC_NORMAL: f32 = 0.7;
/// and that lie within this many parent cells of the cell's tangent plane.
const CUBIC_PLANE: f32 = 2.0;
/// Depth at which the published depth Gaussian has fallen to 1/e, per unit of depth.
const PUBLISHED_DEPTH: f32 = 0.03;

/// Catmull-Rom weights along one axis at the quarter position of an even child, for parents X - 2 .. X + 1; an odd child takes
/// them reversed for X - 1 .. X + 2.
const CUBIC: [f32; 4] = [-0.0234375, 0.2265625, 0.8671875, -0.0703125];
/// Bilinear weights of parents X - 1 and X for an even child; an odd child takes them reversed for X and X + 1.
const LINEAR: [f32; 2] = [0.25, 0.75];

/// Up-sampling filter.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Upsampling {
    /// Weights by the distance from each other's tangent plane and by normals; Catmull-Rom on smooth surfaces.
    #[default]
    EdgeAware,
    /// As published: Gaussians of depth and of the position, stretched along the projected normal (Bagher et al. 2013, section 3.2).
    Published,
}

/// The level above: its cells, and which of them have a value.
pub(crate) struct Coarser<'a, F: Fn(usize) -> bool> {
    pub(crate) extent: Extent,
    pub(crate) cells: &'a [Cell],
    pub(crate) has_value: F,
}

/// The stencil of one cell.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Stencil {
    /// Weights of the four bilinear parents in row order, sum 1.
    pub(crate) weights: [f32; 4],
    /// Whether Catmull-Rom over sixteen parents is used instead.
    pub(crate) cubic: bool,
}

impl Stencil {
    /// The parents of the cell at column and row `at` of level `k` in the level `above`; `None` if none has enough weight.
    pub(crate) fn find(
        cell: &Cell,
        at: [usize; 2],
        k: usize,
        above: &Coarser<'_, impl Fn(usize) -> bool>,
        gbuffer: &GBuffer,
        upsampling: Upsampling,
    ) -> Option<Self> {
        let size = gbuffer.pixel_angle * (1 << (k + 1)) as f32;
        let mut off = [1e9_f32; 4];
        let mut facing = [0.0_f32; 4];
        let mut alpha = [0.0_f32; 4];
        for (n, parent) in linear_parents(at).into_iter().enumerate() {
            let Some(index) = inside(parent, above.extent).filter(|&index| (above.has_value)(index)) else { continue };
            let parent_cell = &above.cells[index];
            if parent_cell.material != cell.material {
                continue;
            }
            alpha[n] = linear_weight(n, at);
            match upsampling {
                Upsampling::EdgeAware => {
                    off[n] = cell.plane_distance(parent_cell) / (cell.depth * size);
                    facing[n] = cell.normal.dot(&parent_cell.normal);
                }
                Upsampling::Published => {
                    let depth = (cell.depth - parent_cell.depth) / (PUBLISHED_DEPTH * cell.depth);
                    off[n] = (depth * depth + stretched(cell, n, at, gbuffer)).sqrt();
                    facing[n] = 1.0;
                }
            }
        }
        let (off, facing) = (f32x4::from(off), f32x4::from(facing).fast_max(f32x4::ZERO));
        let second = facing * facing;
        let fourth = second * second;
        let eighth = fourth * fourth;
        let by_normal = (eighth * eighth).fast_max(f32x4::splat(LEAST_NORMAL_WEIGHT));
        // far away is zero: the exponential is cut where it no longer counts
        let squared = (off * off).fast_min(f32x4::splat(80.0));
        let weights = f32x4::from(alpha) * (-squared).exp() * by_normal;
        let total = weights.reduce_add();
        if total <= LEAST_WEIGHT {
            return None;
        }
        let cubic = upsampling == Upsampling::EdgeAware && is_smooth(cell, at, above, size);
        Some(Self { weights: (weights / total).to_array(), cubic })
    }

    /// The value of the cell at `at` from those of the level above.
    #[inline]
    pub(crate) fn value(&self, at: [usize; 2], width: usize, values: &[f32x4]) -> f32x4 {
        let parent = |[x, y]: [isize; 2]| y as usize * width + x as usize;
        let [a, b, c, d] = linear_parents(at);
        if !self.cubic {
            let of = |place: [isize; 2], weight: f32| {
                if weight > 0.0 { values[parent(place)] * weight } else { f32x4::ZERO }
            };
            let [u, v, w, x] = self.weights;
            return of(a, u) + of(b, v) + (of(c, w) + of(d, x));
        }
        let four = [a, b, c, d].map(|place| values[parent(place)]);
        let low = four[0].fast_min(four[1]).fast_min(four[2].fast_min(four[3]));
        let high = four[0].fast_max(four[1]).fast_max(four[2].fast_max(four[3]));
        let margin = (high - low) * 0.25;
        let [first, top] = cubic_corner(at).map(|first| first as usize);
        let (across, down) = (cubic_weights(at[0]), cubic_weights(at[1]));
        let mut sum = f32x4::ZERO;
        for (row, weight) in down.into_iter().enumerate() {
            let from = &values[(top + row) * width + first..][..4];
            sum += ((from[0] * across[0] + from[1] * across[1]) + (from[2] * across[2] + from[3] * across[3])) * weight;
        }
        sum.fast_max((low - margin).fast_max(f32x4::ZERO)).fast_min(high + margin)
    }
}

/// The four nearest parents in row order; some may lie outside.
#[inline]
fn linear_parents([x, y]: [usize; 2]) -> [[isize; 2]; 4] {
    let first = |at: usize| (at / 2) as isize - isize::from(at.is_multiple_of(2));
    let (x, y) = (first(x), first(y));
    [[x, y], [x + 1, y], [x, y + 1], [x + 1, y + 1]]
}

/// The bilinear weight of the n-th of [`linear_parents`].
#[inline]
fn linear_weight(n: usize, at: [usize; 2]) -> f32 {
    let along = |second: usize, at: usize| LINEAR[second ^ (at % 2)];
    along(n % 2, at[0]) * along(n / 2, at[1])
}

/// Index of a parent, if it exists.
#[inline]
fn inside([x, y]: [isize; 2], extent: Extent) -> Option<usize> {
    let (x, y) = (usize::try_from(x).ok()?, usize::try_from(y).ok()?);
    (x < extent.width && y < extent.height).then(|| y * extent.width + x)
}

/// First column and row of the sixteen parents.
#[inline]
fn cubic_corner(at: [usize; 2]) -> [isize; 2] {
    at.map(|at| (at / 2) as isize - if at.is_multiple_of(2) { 2 } else { 1 })
}

#[inline]
fn cubic_weights(at: usize) -> [f32; 4] {
    let [a, b, c, d] = CUBIC;
    if at.is_multiple_of(2) { CUBIC } else { [d, c, b, a] }
}

/// Whether all sixteen parents have a value and belong to one smooth surface with the cell.
fn is_smooth(cell: &Cell, at: [usize; 2], above: &Coarser<'_, impl Fn(usize) -> bool>, size: f32) -> bool {
    let [left, top] = cubic_corner(at);
    let (width, height) = (above.extent.width as isize, above.extent.height as isize);
    if left < 0 || top < 0 || left + 4 > width || top + 4 > height {
        return false;
    }
    let farthest = CUBIC_PLANE * cell.depth * size;
    (top..top + 4).all(|y| {
        let first = (y * width + left) as usize;
        above.cells[first..first + 4].iter().zip(first..).all(|(parent, index)| {
            parent.coherent
                && parent.material == cell.material
                && (above.has_value)(index)
                && parent.normal.dot(&cell.normal) >= CUBIC_NORMAL
                && (parent.position - cell.position).dot(&cell.normal).abs() <= farthest
        })
    })
}

/// The published exponent `v^T M v`: the step to the n-th parent in units of parent cells, stretched by `1 / cos theta_x` along
/// the normal as the image shows it, which is where the surface turns away.
fn stretched(cell: &Cell, n: usize, at: [usize; 2], gbuffer: &GBuffer) -> f32 {
    let step = [n % 2, n / 2].into_iter().zip(at).map(|(second, at)| {
        // the near parent lies a quarter off, the far one three quarters on the other side
        let sign = if second == 0 { -1.0 } else { 1.0 };
        sign * (1.0 - LINEAR[second ^ (at % 2)])
    });
    let normal = gbuffer.axes.map(|axis| cell.normal.dot(&axis));
    let cos_theta_x = cell.normal.dot(&((gbuffer.eye - cell.position) / cell.depth)).clamp(LEAST_COSINE, 1.0);
    let length = (normal[0] * normal[0] + normal[1] * normal[1]).sqrt();
    let (along, total) = step.zip(normal).fold((0.0, 0.0), |(along, total), (step, normal)| {
        (along + step * normal / length.max(f32::MIN_POSITIVE), total + step * step)
    });
    total + along * along * (1.0 / (cos_theta_x * cos_theta_x) - 1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn weights_reproduce_constants_and_planes() {
        assert_eq!(CUBIC.iter().sum::<f32>(), 1.0);
        assert_eq!((0..4).map(|n| linear_weight(n, [4, 7])).sum::<f32>(), 1.0);
        // an even child lies a quarter of a parent before the centre of its own
        let mean = |first: f32, weights: &[f32]| {
            weights.iter().zip(0..).map(|(weight, n)| weight * (first + n as f32)).sum::<f32>()
        };
        for at in [6, 7] {
            let centre = (at as f32 + 0.5) / 2.0 - 0.5;
            assert_eq!(mean(cubic_corner([at, at])[0] as f32, &cubic_weights(at)), centre);
            let first = linear_parents([at, at])[0][0] as f32;
            assert_eq!(
                mean(
                    first,
                    &[
                        linear_weight(0, [at, at]) + linear_weight(2, [at, at]),
                        linear_weight(1, [at, at]) + linear_weight(3, [at, at])
                    ]
                ),
                centre
            );
        }
    }
}
