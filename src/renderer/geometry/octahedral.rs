//! The octahedral map between directions and the unit square.
//!
//! A direction `d` is projected onto the octahedron `|x| + |y| + |z| = 1`, whose lower half is folded outwards over the corners of the
//! square: +z lies in the middle, -z in the four corners. Source: Engelhardt and Dachsbacher, "Octahedron environment maps",
//! VMV 2008. Texel `(column, row)` of an `n x n` image covers `[column, column + 1] / n` of `u` and `[row, row + 1] / n` of `v`.

use crate::geometry::vec3::Vec3;
use wide::f32x8;

/// The place of a direction, which need not have length 1, in the unit square.
pub fn direction_to_square(d: Vec3) -> [f32; 2] {
    direction_to_signed_square(d).map(|p| p * 0.5 + 0.5)
}

/// The place of a direction in the square `[-1, 1]^2`.
pub(crate) fn direction_to_signed_square(d: Vec3) -> [f32; 2] {
    let inverse = 1.0 / l1_norm(d);
    let (p, q) = (d.x * inverse, d.y * inverse);
    if d.z < 0.0 { [(1.0 - q.abs()).copysign(p), (1.0 - p.abs()).copysign(q)] } else { [p, q] }
}

/// The unit direction at a place of the unit square.
pub fn square_to_direction(square: [f32; 2]) -> Vec3 {
    let [x, y, z] = octahedron(square);
    let inverse = 1.0 / (x * x + y * y + z * z).sqrt();
    Vec3::new(x * inverse, y * inverse, z * inverse)
}

/// [`square_to_direction`] of eight places, with the same results bit for bit.
#[inline(always)]
pub(crate) fn eight_to_directions([u, v]: [f32x8; 2]) -> [f32x8; 3] {
    let (p, q) = (u * 2.0 - 1.0, v * 2.0 - 1.0);
    let z = 1.0 - p.abs() - q.abs();
    let below = z.simd_lt(f32x8::ZERO);
    let folded = |a: f32x8, b: f32x8| below.bitselect(copy_sign(1.0 - b.abs(), a), a);
    let (x, y) = (folded(p, q), folded(q, p));
    let inverse = 1.0 / (x * x + y * y + z * z).sqrt();
    [x * inverse, y * inverse, z * inverse]
}

/// [`direction_to_signed_square`] of eight directions, and their [`l1_norm`], with the same results bit for bit.
#[inline(always)]
pub(crate) fn eight_to_square([x, y, z]: [f32x8; 3]) -> ([f32x8; 2], f32x8) {
    let norm = x.abs() + y.abs() + z.abs();
    let inverse = 1.0 / norm;
    let (p, q) = (x * inverse, y * inverse);
    let below = z.simd_lt(f32x8::ZERO);
    let folded = |a: f32x8, b: f32x8| below.bitselect(copy_sign(1.0 - b.abs(), a), a);
    ([folded(p, q), folded(q, p)], norm)
}

/// `magnitude >= 0` with the sign of `sign`.
#[inline(always)]
fn copy_sign(magnitude: f32x8, sign: f32x8) -> f32x8 {
    magnitude | (sign & f32x8::splat(-0.0))
}

/// Steradians per unit of area of the square at a unit direction: `4 / l^3`, `l` the distance of its point of the octahedron from
/// the origin. Between 4 at the axes and `4 3^(3/2)` in the middle of the octants.
pub fn solid_angle_per_area(d: Vec3) -> f32 {
    let norm = l1_norm(d);
    4.0 * norm * norm * norm
}

/// `|x| + |y| + |z|`, which is `1 / l` for a unit direction.
pub(crate) fn l1_norm(d: Vec3) -> f32 {
    d.x.abs() + d.y.abs() + d.z.abs()
}

/// The point of the octahedron at a place of the square.
fn octahedron([u, v]: [f32; 2]) -> [f32; 3] {
    let (p, q) = (u * 2.0 - 1.0, v * 2.0 - 1.0);
    let z = 1.0 - p.abs() - q.abs();
    if z < 0.0 { [(1.0 - q.abs()).copysign(p), (1.0 - p.abs()).copysign(q), z] } else { [p, q, z] }
}

/// The texel that lies at `(column, row)`, each from -1 to `n`: over an edge the image goes on at the same edge, read backwards, and
/// over a corner in the opposite corner.
pub fn wrap(n: usize, column: isize, row: isize) -> [usize; 2] {
    let last = n as isize - 1;
    let (mut column, mut row) = (column, row);
    if column < 0 || column > last {
        (column, row) = (column.clamp(0, last), last - row);
    }
    if row < 0 || row > last {
        (column, row) = (last - column, row.clamp(0, last));
    }
    [column as usize, row as usize]
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn texels_cover_the_sphere() {
        for n in [4, 64, 512_usize] {
            let centre = |k: usize| (k as f32 + 0.5) / n as f32;
            let angle = |k: usize| f64::from(solid_angle_per_area(square_to_direction([centre(k % n), centre(k / n)])));
            let sum = (0..n * n).map(angle).sum::<f64>() / (n * n) as f64;
            // the midpoint rule, second order
            let bound = 4.0 / (n * n) as f64 + 2e-7;
            assert!((sum / (4.0 * std::f64::consts::PI) - 1.0).abs() < bound, "{n}: {sum}");
        }
    }

    /// The area of a small spherical triangle pair against the density of the map.
    #[test]
    fn solid_angle_is_the_jacobian() {
        for [u, v] in [[0.5, 0.5], [0.3, 0.4], [0.05, 0.1], [0.93, 0.2], [0.7, 0.75_f32]] {
            let h = 1e-3;
            let d = |a: f32, b: f32| square_to_direction([u + a, v + b]).cast::<f64>();
            let (along, across) = (d(h, 0.0) - d(-h, 0.0), d(0.0, h) - d(0.0, -h));
            let area = along.cross(&across).norm() / (4.0 * f64::from(h * h));
            if (u, v) != (0.5, 0.5) {
                let expected = f64::from(solid_angle_per_area(square_to_direction([u, v])));
                assert!((area / expected - 1.0).abs() < 1e-3, "{u} {v}: {area} {expected}");
            }
        }
    }

    /// What lies over an edge, found by the geometry: one step over it is the direction mirrored in the square.
    #[test]
    fn neighbours_over_the_edges_are_close() {
        for n in [1, 2, 4, 8, 32_usize] {
            let direction = |[column, row]: [usize; 2]| {
                square_to_direction([(column as f32 + 0.5) / n as f32, (row as f32 + 0.5) / n as f32])
            };
            let near = |a: [usize; 2], b: [usize; 2]| {
                let angle = direction(a).angle(&direction(b));
                n < 4 || angle < 4.5 / n as f32
            };
            for k in 0..n as isize {
                let last = n as isize - 1;
                for (outside, inside) in
                    [([-1, k], [0, k]), ([n as isize, k], [last, k]), ([k, -1], [k, 0]), ([k, n as isize], [k, last])]
                {
                    let neighbour = wrap(n, outside[0], outside[1]);
                    assert!(near(neighbour, inside.map(|x| x as usize)), "{n}: {outside:?} {neighbour:?}");
                }
            }
            assert_eq!(wrap(n, -1, -1), [n - 1, n - 1]);
            assert_eq!(wrap(n, n as isize, -1), [0, n - 1]);
        }
    }

    proptest! {
        #[test]
        fn the_map_is_inverted(x in -1.0_f32..1.0, y in -1.0_f32..1.0, z in -1.0_f32..1.0) {
            prop_assume!(x * x + y * y + z * z > 1e-3);
            let d = Vec3::new(x, y, z).normalize();
            let square = direction_to_square(d);
            prop_assert!(square.iter().all(|s| (0.0..=1.0).contains(s)));
            prop_assert!((square_to_direction(square) - d).norm() < 6e-7);
        }

        #[test]
        fn eight_are_eight_times_one(u in prop::array::uniform8(0.0_f32..1.0), v in prop::array::uniform8(0.0_f32..1.0)) {
            let [x, y, z] = eight_to_directions([u, v].map(f32x8::from));
            let ([p, q], norm) = eight_to_square([x, y, z]);
            for n in 0..8 {
                let d = square_to_direction([u[n], v[n]]);
                prop_assert_eq!(d, Vec3::new(x.as_array()[n], y.as_array()[n], z.as_array()[n]));
                let square = [p, q].map(|p| p.as_array()[n] * 0.5 + 0.5);
                prop_assert_eq!(direction_to_square(d), square);
                prop_assert_eq!(l1_norm(d), norm.as_array()[n]);
            }
        }
    }
}
