//! Batched evaluation of pairs of directions, eight at a time in single precision.

use std::f32::consts::{FRAC_2_PI, PI};

use brdfit_brdf::{BatchBrdf, Direction, Directions, FixedOutgoing, HalfVectorSampler, HalfVectors, by_eights};
use wide::{f32x4, f32x8};

use crate::brdf::angle::angle;
use crate::grid::dimensions::CHANNELS;
use crate::rgl::tables::Tables;
use crate::rgl::warp::{Between, Grids};

/// The tables laid out so that what one evaluation reads lies together.
///
/// Values lie within 1e-4, relative, of those of [`crate::rgl::brdf::RglBrdf`] but beside zeros and between nodes that differ by orders of
/// magnitude (a test prints the figures).
#[derive(Clone, Debug)]
pub(crate) struct Batch {
    theta_i: Vec<f32>,
    /// Per slice and node (density, sum along the row, -, -).
    nodes: Vec<f32x4>,
    /// Per slice and row (sum of the row, sum of the rows before, -, -).
    rows: Vec<f32x4>,
    size: [usize; 2],
    /// Per slice and node (R, G, B, -).
    colours: Vec<f32x4>,
    colour_size: [usize; 2],
    ndf: Vec<f32>,
    ndf_size: [usize; 2],
    /// `1 / (4 sigma)` at the nodes of u(theta_i), as `ndf` is to be multiplied by it.
    area: Vec<f32>,
}

/// Coordinates of eight pairs of directions.
struct Eight {
    theta_i: [f32; 8],
    u: [f32; 8],
    v: [f32; 8],
    cos_o: [f32; 8],
}

/// A node of a grid, and the shares of the next column and the next row.
struct Patch {
    first: usize,
    x: f32,
    y: f32,
}

impl Batch {
    pub(crate) fn new(tables: &Tables) -> Self {
        let (density, along, over) = tables.vndf.parts();
        let [height, width] = [density.height, density.width];
        let node = |n: usize| f32x4::new([density.values()[n], along[n] as f32, 0.0, 0.0]);
        let row = |n: usize| f32x4::new([along[(n + 1) * width - 1] as f32, over[n] as f32, 0.0, 0.0]);
        let rgb = &tables.rgb;
        let plane = rgb.height * rgb.width;
        let colour = |n: usize| {
            let at = |channel: usize| rgb.values()[(CHANNELS * (n / plane) + channel) * plane + n % plane];
            f32x4::new([at(0), at(1), at(2), 0.0])
        };
        // without a factor both tables are one
        let (ndf, area) =
            if tables.jacobian { (tables.ndf.clone(), area(&tables.sigma)) } else { (ones(), vec![1.0; 2]) };
        Self {
            theta_i: tables.theta_i.iter().map(|&theta| theta as f32).collect(),
            nodes: (0..along.len()).map(node).collect(),
            rows: (0..over.len()).map(row).collect(),
            size: [height, width],
            colours: (0..tables.theta_i.len() * plane).map(colour).collect(),
            colour_size: [rgb.height, rgb.width],
            ndf_size: [ndf.height, ndf.width],
            ndf: ndf.values().to_vec(),
            area,
        }
    }

    /// f for eight pairs: zero where a direction is at or below the horizon.
    #[inline]
    fn values(&self, i: [f32x8; 3], o: [f32x8; 3]) -> [f32x8; 3] {
        let above = i[2].simd_gt(f32x8::ZERO) & o[2].simd_gt(f32x8::ZERO);
        if above.none() {
            return [f32x8::ZERO; 3];
        }
        let eight = coordinates(i, o);
        let mut rgb = [[0.0; 8]; 3];
        for n in 0..8 {
            let found = self.value(eight.theta_i[n], eight.u[n], eight.v[n]) / f32x4::splat(eight.cos_o[n]);
            let [r, g, b, _] = found.to_array();
            (rgb[0][n], rgb[1][n], rgb[2][n]) = (r, g, b);
        }
        rgb.map(|channel| above & f32x8::new(channel))
    }

    /// f cos theta_o from theta_i, u(theta_m) and u(phi_m - phi_i).
    #[inline]
    fn value(&self, theta_i: f32, u: f32, v: f32) -> f32x4 {
        let below = self.theta_i.partition_point(|&angle| angle <= theta_i).clamp(1, self.theta_i.len() - 1) - 1;
        let share = (theta_i - self.theta_i[below]) / (self.theta_i[below + 1] - self.theta_i[below]);
        let share = f32x4::splat(share.clamp(0.0, 1.0));
        let [s, t] = self.uniform(below, share, u, v);
        let [height, width] = self.colour_size;
        let patch = patch(self.colour_size, s, t);
        let slice = |slice: usize| bilinear(&self.colours[slice * height * width..], width, &patch);
        let lower = slice(below);
        (lower + (slice(below + 1) - lower) * share) * f32x4::splat(self.factor(theta_i, u, v))
    }

    /// The uniform numbers that the warp takes to (u, v): `Warp::invert`.
    #[inline]
    fn uniform(&self, below: usize, share: f32x4, u: f32, v: f32) -> [f32; 2] {
        let [height, width] = self.size;
        let Patch { first, x, y } = patch(self.size, u, v);
        let mixed = |table: &[f32x4], at: usize, step: usize| {
            let lower = table[at];
            lower + (table[at + step] - lower) * share
        };
        let up = f32x4::splat(y);
        let column = |at: usize| {
            let at = below * height * width + first + at;
            let lower = mixed(&self.nodes, at, height * width);
            lower + (mixed(&self.nodes, at + width, height * width) - lower) * up
        };
        let [left, sum, ..] = column(0).to_array();
        let [right, ..] = column(1).to_array();
        let row = below * height + first / width;
        let [[whole, before, ..], [next, ..]] = [row, row + 1].map(|row| mixed(&self.rows, row, height).to_array());
        let part = sum + x * (left + 0.5 * x * (right - left));
        let all = whole + y * (next - whole);
        let s = if all > 0.0 { part / all } else { 0.0 };
        [s, before + y * (whole + 0.5 * y * (next - whole))]
    }

    /// `ndf / (4 sigma)`.
    #[inline]
    fn factor(&self, theta_i: f32, u: f32, v: f32) -> f32 {
        let width = self.ndf_size[1];
        let Patch { first, x, y } = patch(self.ndf_size, u, v);
        let along = |at: usize| self.ndf[at] + x * (self.ndf[at + 1] - self.ndf[at]);
        let lower = along(first);
        let distribution = lower + y * (along(first + width) - lower);
        let Patch { first, x, .. } = patch([2, self.area.len()], (theta_i * FRAC_2_PI).sqrt(), 0.0);
        let area = self.area[first] + x * (self.area[first + 1] - self.area[first]);
        if area > 0.0 { distribution / area } else { 0.0 }
    }
}

/// `4 sigma` between the rows of the table, where the azimuth of i is.
fn area(sigma: &Grids) -> Vec<f32> {
    let whole = Between { below: 0, share: 0.0 };
    let at = |n: usize| [n as f64 / (sigma.width - 1) as f64, 0.5];
    (0..sigma.width).map(|n| (4.0 * sigma.value(at(n), whole, |_| 0)) as f32).collect()
}

fn ones() -> Grids {
    Grids::new([2, 2], vec![1.0; 4])
}

/// The cell around a point of the unit square.
#[inline]
fn patch([height, width]: [usize; 2], x: f32, y: f32) -> Patch {
    let split = |at: f32, nodes: usize| {
        let at = at.clamp(0.0, 1.0) * (nodes - 1) as f32;
        let below = (at as usize).min(nodes - 2);
        (below, at - below as f32)
    };
    let ((column, x), (row, y)) = (split(x, width), split(y, height));
    Patch { first: row * width + column, x, y }
}

#[inline]
fn bilinear(grid: &[f32x4], width: usize, patch: &Patch) -> f32x4 {
    let along = |at: usize| grid[at] + (grid[at + 1] - grid[at]) * f32x4::splat(patch.x);
    let lower = along(patch.first);
    lower + (along(patch.first + width) - lower) * f32x4::splat(patch.y)
}

/// Half vectors near the normal keep an absolute error of 1e-7 rad, a thousandth of the distance of the closest nodes.
#[inline]
fn coordinates(i: [f32x8; 3], o: [f32x8; 3]) -> Eight {
    let [x, y, z] = [0, 1, 2].map(|n: usize| i[n] + o[n]);
    let u = (angle((x * x + y * y).sqrt(), z) * FRAC_2_PI).sqrt();
    let across = (i[0] * i[0] + i[1] * i[1]).sqrt();
    // the half vector in the frame of i; at the pole the azimuth of i is 0
    let pole = across.simd_le(f32x8::ZERO);
    let ix = pole.select(f32x8::ONE, i[0]);
    let (along, aside) = (x * ix + y * i[1], y * ix - x * i[1]);
    let acute = angle(aside.abs(), along.abs());
    let turn = along.simd_lt(f32x8::ZERO).select(f32x8::splat(PI) - acute, acute);
    let turn = aside.simd_lt(f32x8::ZERO).select(-turn, turn);
    let v = turn * (0.5 / PI) + 0.5;
    Eight { theta_i: angle(across, i[2]).to_array(), u: u.to_array(), v: v.to_array(), cos_o: o[2].to_array() }
}

/// [`FixedOutgoing`] of the tables.
pub(crate) struct RglLobes<'a> {
    pub(crate) batch: &'a Batch,
    pub(crate) o: &'a Directions,
}

impl FixedOutgoing for RglLobes<'_> {
    fn values(&self, i: &Direction, first: usize, values: [&mut [f32]; 3]) {
        let range = first..first + values[0].len();
        let o = [&self.o.x, &self.o.y, &self.o.z].map(|component| &component[range.clone()]);
        let i = [i.x, i.y, i.z].map(|component| f32x8::splat(component as f32));
        by_eights(o, values, |o| self.batch.values(i, o));
    }
}

/// [`BatchBrdf`] of the tables: half vectors are drawn from the measured distribution, averaged over elevations.
pub(crate) struct RglShading<'a> {
    pub(crate) batch: &'a Batch,
    pub(crate) sampler: HalfVectorSampler,
}

impl BatchBrdf for RglShading<'_> {
    fn sample(&self, o: [&[f32]; 3], u: [&[f32]; 2], i: [&mut [f32]; 3]) {
        self.sampler.sample_many(o, u, i);
    }

    fn evaluate(&self, i: [&[f32]; 3], o: [&[f32]; 3], values: [&mut [f32]; 3], density: &mut [f32]) {
        let [r, g, b] = values;
        by_eights([i[0], i[1], i[2], o[0], o[1], o[2]], [r, g, b, density], |[ix, iy, iz, ox, oy, oz]| {
            let (i, o) = ([ix, iy, iz], [ox, oy, oz]);
            let above = iz.simd_gt(f32x8::ZERO) & oz.simd_gt(f32x8::ZERO);
            let [r, g, b] = self.batch.values(i, o);
            [r, g, b, above & self.sampler.density(&HalfVectors::new(i, o), iz)]
        });
    }
}
