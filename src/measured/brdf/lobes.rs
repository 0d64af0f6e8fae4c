//! Batched evaluation for fixed outgoing directions, eight at a time in single precision.

use brdfit_brdf::{Direction, Directions, FixedOutgoing};
use std::f32::consts::PI;
use wide::{f32x4, f32x8};

use crate::brdf::angle::angle;
use crate::brdf::table::{H_PER_RADIAN, HALF, LAST, PER_RADIAN, QUARTER, ROWS, Table};

/// Texels from the first to the last of the eight around a point.
pub(super) const fn span(width: usize) -> usize {
    (ROWS + 1) * width + 2
}

/// A table made ready for a set of outgoing directions.
///
/// In units of a bin, coordinates lie within 3e-5 of those that [`Table::coordinates`] computes.
pub(super) struct MeasuredLobes<'a> {
    table: &'a Table,
    o: &'a Directions,
    /// What the rounding of its components took from the length of each direction.
    short: Vec<f32>,
}

impl<'a> MeasuredLobes<'a> {
    pub(super) fn new(table: &'a Table, o: &'a Directions) -> Self {
        let square = |n: usize| [o.x[n], o.y[n], o.z[n]].map(|v| f64::from(v) * f64::from(v)).iter().sum::<f64>();
        let short = (0..o.len()).map(|n| (1.0 / square(n).sqrt() - 1.0) as f32).collect();
        Self { table, o, short }
    }

    fn run<const WIDTH: usize, const SPAN: usize>(&self, i: &Direction, first: usize, values: [&mut [f32]; 3]) {
        let count = values[0].len();
        let [x, y, z, short] = [&self.o.x, &self.o.y, &self.o.z, &self.short].map(|all| &all[first..first + count]);
        let incident = Incident::new(i);
        let [r, g, b] = values;
        for start in (0..count).step_by(8) {
            let end = count.min(start + 8);
            let load = |all: &[f32]| match all[start..].first_chunk() {
                Some(&eight) => f32x8::new(eight),
                None => {
                    let mut eight = [0.0; 8];
                    eight[..end - start].copy_from_slice(&all[start..]);
                    f32x8::new(eight)
                }
            };
            let o = [load(x), load(y), load(z)];
            let lit = o[2].simd_gt(f32x8::ZERO);
            if lit.none() {
                for channel in [&mut *r, &mut *g, &mut *b] {
                    channel[start..end].fill(0.0);
                }
                continue;
            }
            let rgb = incident
                .coordinates::<WIDTH>(o, load(short), self.table.offset as f32)
                .look_up::<WIDTH, SPAN>(&self.table.texels);
            for (channel, found) in [&mut *r, &mut *g, &mut *b].into_iter().zip(rgb) {
                let found = (f32x8::new(found) & lit).to_array();
                match channel[start..].first_chunk_mut() {
                    Some(eight) => *eight = found,
                    None => channel[start..].copy_from_slice(&found[..end - start]),
                }
            }
        }
    }
}

impl FixedOutgoing for MeasuredLobes<'_> {
    fn values(&self, i: &Direction, first: usize, values: [&mut [f32]; 3]) {
        let [r, g, b] = &values;
        assert!(r.len() == g.len() && g.len() == b.len(), "the channels differ in length");
        if i.z <= 0.0 {
            values.into_iter().for_each(|channel| channel.fill(0.0));
        } else if self.table.width == QUARTER {
            self.run::<QUARTER, { span(QUARTER) }>(i, first, values);
        } else {
            self.run::<HALF, { span(HALF) }>(i, first, values);
        }
    }
}

/// An incident direction, or eight, each component as the sum of two numbers in single precision: half and difference vectors keep
/// their relative accuracy where they are short.
pub(super) struct Incident {
    pub(super) high: [f32x8; 3],
    pub(super) low: [f32x8; 3],
}

/// Positions of eight points in a table: the first of the eight texels around each, and the shares of the later ones.
pub(super) struct Coordinates {
    first: [i32; 8],
    shares: [[f32; 8]; 3],
}

impl Incident {
    fn new(i: &Direction) -> Self {
        let parts = [i.x, i.y, i.z];
        Self {
            high: parts.map(|v| f32x8::splat(v as f32)),
            low: parts.map(|v| f32x8::splat((v - f64::from(v as f32)) as f32)),
        }
    }

    /// As [`Table::coordinates`]. Operations without contraction, the same on every machine.
    #[inline]
    pub(super) fn coordinates<const WIDTH: usize>(&self, o: [f32x8; 3], short: f32x8, offset: f32) -> Coordinates {
        let rest = o.map(|v| v * short);
        let [hx, hy, hz] = [0, 1, 2].map(|n: usize| (self.high[n] + o[n]) + (self.low[n] + rest[n]));
        let [dx, dy, dz] = [0, 1, 2].map(|n: usize| (self.high[n] - o[n]) + (self.low[n] - rest[n]));
        let across_square = hx * hx + hy * hy;
        let length_h = (across_square + hz * hz).sqrt();
        let theta_h = angle(across_square.sqrt(), hz);
        let theta_d = angle((dx * dx + dy * dy + dz * dz).sqrt(), length_h);
        let x = hz * (hx * dx + hy * dy) - across_square * dz;
        let y = length_h * (hx * dy - hy * dx);
        let mut phi_d = angle(y.abs(), x.abs());
        if WIDTH != QUARTER {
            phi_d = x.simd_lt(f32x8::ZERO).select(f32x8::splat(PI) - phi_d, phi_d);
        }
        let (offset, per_radian) = (f32x8::splat(offset), f32x8::splat(PER_RADIAN as f32));
        let (slab, s) = split((theta_h * f32x8::splat(H_PER_RADIAN as f32)).sqrt() - offset, LAST);
        let (row, t) = split(theta_d * per_radian - offset, LAST);
        let (column, u) = split(phi_d * per_radian + offset, WIDTH - 2);
        // whole numbers below 2^24, exact
        let first = (slab * f32x8::splat(ROWS as f32) + row) * f32x8::splat(WIDTH as f32) + column;
        Coordinates { first: first.fast_trunc_int().to_array(), shares: [s, t, u].map(f32x8::to_array) }
    }
}

impl Coordinates {
    /// Per channel the trilinear interpolation at the eight points.
    #[inline]
    pub(super) fn look_up<const WIDTH: usize, const SPAN: usize>(&self, texels: &[f32x4]) -> [[f32; 8]; 3] {
        let mut rgb = [[0.0; 8]; 3];
        for n in 0..8 {
            let near: &[f32x4; SPAN] = texels[self.first[n] as usize..].first_chunk().expect("inside the table");
            let [s, t, u] = [0, 1, 2].map(|axis: usize| f32x4::splat(self.shares[axis][n]));
            let along_row = |at: usize| near[at] + (near[at + 1] - near[at]) * u;
            let in_slab = |at: usize| {
                let lower = along_row(at);
                lower + (along_row(at + WIDTH) - lower) * t
            };
            let lower = in_slab(0);
            let [r, g, b, _] = (lower + (in_slab(ROWS * WIDTH) - lower) * s).to_array();
            (rgb[0][n], rgb[1][n], rgb[2][n]) = (r, g, b);
        }
        rgb
    }
}

/// The sample below a coordinate, at most `last`, and the share of the next one; coordinates outside are held.
#[inline]
fn split(at: f32x8, last: usize) -> (f32x8, f32x8) {
    // in this order a coordinate that is not a number becomes zero
    let at = at.fast_max(f32x8::ZERO).fast_min(f32x8::splat((last + 1) as f32));
    let below = f32x8::from_i32x8(at.fast_trunc_int()).fast_min(f32x8::splat(last as f32));
    (below, at - below)
}

#[cfg(test)]
mod tests {
    use brdfit_brdf::{HalfDifference, direction};

    use super::*;

    /// In units of a bin; down to half and difference vectors that are a millionth of a radian long.
    #[test]
    fn coordinates_are_those_in_double_precision() {
        let check = |width: usize| {
            let table = Table { texels: Vec::new(), width, offset: 0.5 };
            let mut worst = [0.0_f64; 3];
            for n in 0..20_000 {
                let [a, b, c] =
                    [0.819_172_513, 0.671_043_606, 0.549_700_477].map(|step| (0.5 + f64::from(n) * step) % 1.0);
                let angles = HalfDifference {
                    theta_h: 1.5 * if n % 3 == 0 { libm::exp(-14.0 * a) } else { a },
                    theta_d: 1.5 * if n % 5 == 0 { libm::exp(-14.0 * b) } else { b },
                    phi_d: 6.3 * c,
                };
                let (i, o) = angles.to_directions();
                let turned = |v: Direction| direction(libm::acos(v.z.min(1.0)), libm::atan2(v.y, v.x) + f64::from(n));
                let (i, o) = (turned(i), turned(o));
                if i.z <= 0.0 || o.z <= 0.0 {
                    continue;
                }
                let o: Directions = [o].into_iter().collect();
                let lobes = MeasuredLobes::new(&table, &o);
                let [x, y, z, short] = [o.x[0], o.y[0], o.z[0], lobes.short[0]].map(f32x8::splat);
                let incident = Incident::new(&i);
                let found = if width == QUARTER {
                    incident.coordinates::<QUARTER>([x, y, z], short, 0.5)
                } else {
                    incident.coordinates::<HALF>([x, y, z], short, 0.5)
                };
                let first = found.first[0] as usize;
                let below = [first / width / ROWS, first / width % ROWS, first % width];
                let exact = table.coordinates(&i, &o.get(0));
                for axis in 0..3 {
                    let found = below[axis] as f64 + f64::from(found.shares[axis][0]);
                    let held = if axis < 2 { exact[axis].clamp(0.0, 89.0) } else { exact[axis] };
                    worst[axis] = worst[axis].max((found - held).abs());
                }
            }
            let [h, d, p] = worst;
            println!("{width} columns: largest errors in bins: theta_h {h:.1e}, theta_d {d:.1e}, phi_d {p:.1e}");
            assert!(worst.iter().all(|&worst| worst < 3e-5), "{worst:?}");
        };
        check(QUARTER);
        check(HALF);
    }
}
