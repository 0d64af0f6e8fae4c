//! Densities over the unit square, bilinear between the nodes of a grid, one for each measured theta_i and linear between
//! them: evaluation, and the warp from uniform numbers to the density with its inverse.
//!
//! Each slice is normalised to integrate to one. Along a row the density is linear between nodes, so its cumulative function is
//! quadratic there; rows are combined linearly, and so are slices: the warp is exact for the interpolated density, not an
//! interpolation of warps. After Dupuy & Jakob 2018, section 4.

/// A place between two measured theta_i: the lower slice and the share of the one above it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Between {
    pub(crate) below: usize,
    pub(crate) share: f64,
}

impl Between {
    /// The place of `at` in a list of increasing numbers, held outside of it.
    pub(crate) fn of(list: &[f64], at: f64) -> Self {
        let below = list.partition_point(|&entry| entry <= at).clamp(1, list.len() - 1) - 1;
        let share = (at - list[below]) / (list[below + 1] - list[below]);
        Self { below, share: share.clamp(0.0, 1.0) }
    }

    /// Linear between what is said of the two slices.
    #[inline]
    pub(crate) fn mix(self, of: impl Fn(usize) -> f64) -> f64 {
        let lower = of(self.below);
        lower + self.share * (of(self.below + 1) - lower)
    }
}

/// Numbers at the nodes of grids over the unit square, one grid per slice; x is the innermost axis, nodes at 0 and 1 included.
#[derive(Clone, Debug)]
pub(crate) struct Grids {
    pub(crate) width: usize,
    pub(crate) height: usize,
    values: Vec<f32>,
}

/// A cell of a grid and a place in it.
#[derive(Clone, Copy, Debug)]
struct Patch {
    column: usize,
    row: usize,
    x: f64,
    y: f64,
}

impl Grids {
    /// # Panics
    /// If a side has fewer than two nodes or the values are not whole slices.
    pub(crate) fn new([height, width]: [usize; 2], values: Vec<f32>) -> Self {
        assert!(height >= 2 && width >= 2 && values.len().is_multiple_of(width * height), "{height} x {width}");
        Self { width, height, values }
    }

    /// All nodes, slice after slice.
    pub(crate) fn values(&self) -> &[f32] {
        &self.values
    }

    /// The cell around a point of the unit square.
    fn patch(&self, [x, y]: [f64; 2]) -> Patch {
        let split = |at: f64, nodes: usize| {
            let at = at.clamp(0.0, 1.0) * (nodes - 1) as f64;
            let below = (at as usize).min(nodes - 2);
            (below, at - below as f64)
        };
        let ((column, x), (row, y)) = (split(x, self.width), split(y, self.height));
        Patch { column, row, x, y }
    }

    #[inline]
    fn node(&self, slice: usize, row: usize, column: usize) -> f64 {
        f64::from(self.values[(slice * self.height + row) * self.width + column])
    }

    /// The four corners of a patch, between slices: row below, row above, each left and right.
    #[inline]
    fn corners(&self, patch: &Patch, slices: Between, of: impl Fn(usize) -> usize) -> [[f64; 2]; 2] {
        [0, 1].map(|up| {
            [0, 1].map(|right| slices.mix(|slice| self.node(of(slice), patch.row + up, patch.column + right)))
        })
    }

    /// The bilinear value at a point of slice `of(slice)`, linear between slices.
    pub(crate) fn value(&self, at: [f64; 2], slices: Between, of: impl Fn(usize) -> usize) -> f64 {
        let patch = self.patch(at);
        let [[a, b], [c, d]] = self.corners(&patch, slices, of);
        let (lower, upper) = (a + patch.x * (b - a), c + patch.x * (d - c));
        lower + patch.y * (upper - lower)
    }
}

/// Normalised densities with their cumulative tables.
#[derive(Clone, Debug)]
pub(crate) struct Warp {
    /// The densities per cell: divided by their integral in units of cells.
    density: Grids,
    /// Integral of the density along each row up to each node, in units of cells.
    along_row: Vec<f64>,
    /// Integral up to each row.
    over_rows: Vec<f64>,
}

impl Warp {
    /// `None` if a slice is zero everywhere.
    pub(crate) fn new(mut density: Grids) -> Option<Self> {
        let (width, height) = (density.width, density.height);
        let mut along_row = vec![0.0; density.values.len()];
        let mut over_rows = vec![0.0; density.values.len() / width];
        let slices = density.values.chunks_exact_mut(width * height);
        for ((values, along), over) in
            slices.zip(along_row.chunks_exact_mut(width * height)).zip(over_rows.chunks_exact_mut(height))
        {
            for (values, along) in values.chunks_exact(width).zip(along.chunks_exact_mut(width)) {
                for column in 1..width {
                    along[column] =
                        along[column - 1] + 0.5 * (f64::from(values[column - 1]) + f64::from(values[column]));
                }
            }
            let whole = |row: usize| along[(row + 1) * width - 1];
            for row in 1..height {
                over[row] = over[row - 1] + 0.5 * (whole(row - 1) + whole(row));
            }
            let scale = 1.0 / over[height - 1];
            if !scale.is_finite() {
                return None;
            }
            values.iter_mut().for_each(|value| *value = (f64::from(*value) * scale) as f32);
            along.iter_mut().chain(over).for_each(|sum| *sum *= scale);
        }
        Some(Self { density, along_row, over_rows })
    }

    /// The densities per cell, and per slice their integrals along each row up to each node and over the rows up to each.
    pub(crate) fn parts(&self) -> (&Grids, &[f64], &[f64]) {
        (&self.density, &self.along_row, &self.over_rows)
    }

    /// Cells of a grid: the density per unit square is that per cell times this.
    fn cells(&self) -> f64 {
        ((self.density.width - 1) * (self.density.height - 1)) as f64
    }

    #[inline]
    fn row_sum(&self, slice: usize, row: usize, column: usize) -> f64 {
        self.along_row[(slice * self.density.height + row) * self.density.width + column]
    }

    /// The density at a point of the unit square; its integral over the square is one.
    pub(crate) fn pdf(&self, at: [f64; 2], slices: Between) -> f64 {
        self.density.value(at, slices, |slice| slice) * self.cells()
    }

    /// The uniform numbers that the warp takes to a point, and the density there.
    pub(crate) fn invert(&self, at: [f64; 2], slices: Between) -> ([f64; 2], f64) {
        let patch = self.density.patch(at);
        let Patch { column, row, x, y } = patch;
        let [[a, b], [c, d]] = self.density.corners(&patch, slices, |slice| slice);
        // along x, between the two rows
        let (left, right) = (a + y * (c - a), b + y * (d - b));
        let last = self.density.width - 1;
        let sum = |row: usize, column: usize| slices.mix(|slice| self.row_sum(slice, row, column));
        let whole = [sum(row, last), sum(row + 1, last)];
        let row_whole = whole[0] + y * (whole[1] - whole[0]);
        let before = [sum(row, column), sum(row + 1, column)];
        let part = before[0] + y * (before[1] - before[0]) + x * (left + 0.5 * x * (right - left));
        let u = if row_whole > 0.0 { part / row_whole } else { 0.0 };
        let below = slices.mix(|slice| self.over_rows[slice * self.density.height + row]);
        let v = below + y * (whole[0] + 0.5 * y * (whole[1] - whole[0]));
        ([u, v], (left + x * (right - left)) * self.cells())
    }

    /// The point to which the warp takes two uniform numbers, and the density there: the inverse of [`Self::invert`].
    pub(crate) fn sample(&self, [u, v]: [f64; 2], slices: Between) -> ([f64; 2], f64) {
        let (width, height) = (self.density.width, self.density.height);
        let over = |row: usize| slices.mix(|slice| self.over_rows[slice * height + row]);
        let sum = |row: usize, column: usize| slices.mix(|slice| self.row_sum(slice, row, column));
        let row = last_at_most(height - 1, v, over);
        let whole = [sum(row, width - 1), sum(row + 1, width - 1)];
        let y = solve(whole[0], whole[1], v - over(row));
        let target = u * (whole[0] + y * (whole[1] - whole[0]));
        let before = |column: usize| {
            let [lower, upper] = [sum(row, column), sum(row + 1, column)];
            lower + y * (upper - lower)
        };
        let column = last_at_most(width - 1, target, before);
        let [[a, b], [c, d]] = self.density.corners(&Patch { column, row, x: 0.0, y }, slices, |slice| slice);
        let (left, right) = (a + y * (c - a), b + y * (d - b));
        let x = solve(left, right, target - before(column));
        let point = [(column as f64 + x) / (width - 1) as f64, (row as f64 + y) / (height - 1) as f64];
        (point, (left + x * (right - left)) * self.cells())
    }
}

/// The last of `0..count` at which an increasing function is at most `at`; 0 where none is.
fn last_at_most(count: usize, at: f64, function: impl Fn(usize) -> f64) -> usize {
    let (mut low, mut high) = (0, count);
    while high - low > 1 {
        let middle = low.midpoint(high);
        if function(middle) <= at { low = middle } else { high = middle }
    }
    low
}

/// The x in [0, 1] up to which a density that goes linearly from `a` to `b` integrates to `part`.
fn solve(a: f64, b: f64, part: f64) -> f64 {
    let part = part.max(0.0);
    let root = (a * a + 2.0 * part * (b - a)).max(0.0).sqrt();
    let divisor = a + root;
    if divisor > 0.0 { (2.0 * part / divisor).min(1.0) } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    const SHAPE: [usize; 2] = [5, 7];

    fn warp(values: Vec<f32>) -> Warp {
        Warp::new(Grids::new(SHAPE, values)).unwrap()
    }

    fn values(least: f32) -> impl Strategy<Value = Vec<f32>> {
        prop::collection::vec(least..4.0_f32, 2 * 35)
    }

    proptest! {
        #[test]
        fn the_inverse_undoes_the_warp(
            values in values(1e-3), u in 0.0..1.0_f64, v in 0.0..1.0_f64, share in 0.0..1.0_f64
        ) {
            let (warp, slices) = (warp(values), Between { below: 0, share });
            let (point, density) = warp.sample([u, v], slices);
            let (back, same) = warp.invert(point, slices);
            prop_assert!((back[0] - u).abs() < 1e-6 && (back[1] - v).abs() < 1e-6, "{back:?} {u} {v}");
            prop_assert!((density / same - 1.0).abs() < 1e-6 && (density / warp.pdf(point, slices) - 1.0).abs() < 1e-6);
        }

        /// Simpson's rule on each cell is exact for what is bilinear.
        #[test]
        fn the_density_integrates_to_one(values in values(0.0), share in 0.0..1.0_f64) {
            let (warp, slices) = (warp(values), Between { below: 0, share });
            let mut sum = 0.0;
            for row in 0..8 {
                for column in 0..12 {
                    let weight = |n: usize| if n % 2 == 1 { 4.0 } else { 1.0 };
                    for (a, b) in [(0, 0), (0, 1), (0, 2), (1, 0), (1, 1), (1, 2), (2, 0), (2, 1), (2, 2)] {
                        let at = [(column as f64 + 0.5 * b as f64) / 12.0, (row as f64 + 0.5 * a as f64) / 8.0];
                        sum += weight(a) * weight(b) / 36.0 / 96.0 * warp.pdf(at, slices);
                    }
                }
            }
            prop_assert!((sum - 1.0).abs() < 1e-6, "{sum}");
        }
    }

    /// Numbers by hand: on a square of four nodes with densities 0, 2 at the bottom and 0, 2 at the top the density is 2 x.
    #[test]
    fn a_ramp_has_a_square_root() {
        let ramp = Warp::new(Grids::new([2, 2], vec![0.0, 2.0, 0.0, 2.0, 0.0, 2.0, 0.0, 2.0])).unwrap();
        let slices = Between { below: 0, share: 0.3 };
        let (point, density) = ramp.sample([0.25, 0.7], slices);
        assert!((point[0] - 0.5).abs() < 1e-12 && (point[1] - 0.7).abs() < 1e-12 && (density - 1.0).abs() < 1e-12);
        assert_eq!(ramp.invert([0.5, 0.7], slices).0, [0.25, 0.7]);
    }

    #[test]
    fn zeros_have_no_warp() {
        assert!(Warp::new(Grids::new([2, 2], vec![0.0; 8])).is_none());
    }

    #[test]
    fn places_between_slices() {
        let list = [0.0, 1.0, 3.0];
        assert_eq!(Between::of(&list, 2.0), Between { below: 1, share: 0.5 });
        assert_eq!(Between::of(&list, -1.0), Between { below: 0, share: 0.0 });
        assert_eq!(Between::of(&list, 9.0), Between { below: 1, share: 1.0 });
        assert_eq!(Between::of(&list, 1.0), Between { below: 1, share: 0.0 });
    }
}
