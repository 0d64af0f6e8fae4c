//! The angular map between the hemisphere and square images.

use std::f64::consts::{FRAC_2_PI, FRAC_PI_2};

use brdfit_brdf::{Direction, direction};

/// Cosine of the largest polar angle an image holds; texels further out, up to the corners, repeat it.
pub const COS_RIM: f64 = 0.02;

/// The angular map on an image of `size` x `size` texels (docs/theory.md, "Mapping of the hemisphere").
///
/// A texel (row, column) has its centre at `u = 2 (column + 1/2) / size - 1`, `v = 2 (row + 1/2) / size - 1`; row 0 lies at
/// v = -1. A position (u, v) of radius r stands for the direction at `theta = min(r pi/2, arccos 0.02)`, `phi = atan2(v, u)`:
/// whatever lies outside the disc repeats the rim.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct AngularMap {
    size: usize,
}

impl AngularMap {
    /// The map on an image of `size` x `size` texels.
    ///
    /// # Panics
    /// If `size` is zero.
    pub fn new(size: usize) -> Self {
        assert!(size > 0, "an image without texels");
        Self { size }
    }

    /// Texels along one side.
    pub fn size(&self) -> usize {
        self.size
    }

    /// The centre (u, v) of a texel, each in (-1, 1).
    pub fn position(&self, row: usize, column: usize) -> [f64; 2] {
        [column, row].map(|index| (2 * index + 1) as f64 / self.size as f64 - 1.0)
    }

    /// The unit vector that a texel stands for, never below the rim.
    pub fn direction(&self, row: usize, column: usize) -> Direction {
        position_to_direction(self.position(row, column))
    }

    /// Cycles per radian that one cycle per texel stands for at a texel: `size/2` texels per unit of u and v over the scale of
    /// the map there, see [`mapping_scale`].
    pub fn cycles_per_radian(&self, row: usize, column: usize) -> f64 {
        0.5 * self.size as f64 / mapping_scale(self.position(row, column))
    }
}

/// The unit vector at a position (u, v) of the angular map, of any radius.
pub fn position_to_direction([u, v]: [f64; 2]) -> Direction {
    let theta = (libm::hypot(u, v) * FRAC_PI_2).min(libm::acos(COS_RIM));
    direction(theta, libm::atan2(v, u))
}

/// The position (u, v) of a direction of any length above zero on the angular map: the inverse of [`position_to_direction`]
/// down to the rim; directions below the rim lie on it. The normal, which has no azimuth, lies at (0, 0), and its
/// opposite at phi = 0.
pub fn direction_to_position(direction: &Direction) -> [f64; 2] {
    let across = libm::hypot(direction.x, direction.y);
    let r = libm::atan2(across, direction.z).min(libm::acos(COS_RIM)) * FRAC_2_PI;
    if across == 0.0 { [r, 0.0] } else { [r * direction.x / across, r * direction.y / across] }
}

/// Radians per unit of (u, v) at a position: the geometric mean of the two singular values, pi/2 along the radius and
/// `sin(r pi/2) / r` across it, of the derivative of the direction. It is continuous: pi/2 at the centre, 1.2533 (the square
/// root of pi/2) from r = 1 outwards, where r counts as 1.
pub fn mapping_scale([u, v]: [f64; 2]) -> f64 {
    let r = libm::hypot(u, v).min(1.0);
    // below this radius sin(x)/x rounds to one
    let across = if r < 1e-8 { FRAC_PI_2 } else { libm::sin(r * FRAC_PI_2) / r };
    (FRAC_PI_2 * across).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// The geometric mean of the singular values of a 3 x 2 matrix of central differences.
    fn numeric_scale([u, v]: [f64; 2]) -> f64 {
        let h = 1e-5;
        let by_u = (position_to_direction([u + h, v]) - position_to_direction([u - h, v])) / (2.0 * h);
        let by_v = (position_to_direction([u, v + h]) - position_to_direction([u, v - h])) / (2.0 * h);
        by_u.cross(&by_v).norm().sqrt()
    }

    proptest! {
        #[test]
        fn positions_and_directions_are_inverse(r in 0.0..0.98_f64, phi in -3.1..3.1_f64) {
            let position = [r * libm::cos(phi), r * libm::sin(phi)];
            let d = position_to_direction(position);
            prop_assert!((d.norm() - 1.0).abs() < 1e-14);
            let back = direction_to_position(&(d * 3.0));
            prop_assert!((back[0] - position[0]).abs() < 1e-13 && (back[1] - position[1]).abs() < 1e-13);
        }

        #[test]
        fn the_scale_is_that_of_the_derivative(r in 1e-3..0.98_f64, phi in -3.1..3.1_f64) {
            let position = [r * libm::cos(phi), r * libm::sin(phi)];
            prop_assert!((mapping_scale(position) / numeric_scale(position) - 1.0).abs() < 1e-8);
        }

        #[test]
        fn whatever_is_beyond_the_rim_lies_on_it(r in 0.99..1.4_f64, phi in -3.1..3.1_f64) {
            let d = position_to_direction([r * libm::cos(phi), r * libm::sin(phi)]);
            prop_assert!((d.z - COS_RIM).abs() < 1e-15);
            let below = direction_to_position(&direction(r * 2.0, phi));
            prop_assert!((libm::hypot(below[0], below[1]) * FRAC_PI_2 - libm::acos(COS_RIM)).abs() < 1e-14);
            prop_assert!((libm::atan2(below[1], below[0]) - phi).abs() < 1e-13);
        }
    }

    #[test]
    fn texels_lie_where_the_definition_puts_them() {
        let map = AngularMap::new(4);
        assert_eq!(map.position(0, 0), [-0.75, -0.75]);
        assert_eq!(map.position(0, 3), [0.75, -0.75]);
        assert_eq!(map.position(2, 1), [-0.25, 0.25]);
        // the middle of an image with an odd number of texels is the normal
        assert_eq!(AngularMap::new(5).direction(2, 2), Direction::new(0.0, 0.0, 1.0));
    }

    #[test]
    fn the_mirror_direction_lies_on_the_negative_u_axis() {
        let theta_i = 0.7;
        let i = direction(theta_i, 0.0);
        let mirror = Direction::new(-i.x, -i.y, i.z);
        let [u, v] = direction_to_position(&mirror);
        assert!((u + theta_i / FRAC_PI_2).abs() < 1e-15 && v.abs() < 1e-15);
    }

    #[test]
    fn undefined_azimuths_are_zero() {
        assert_eq!(direction_to_position(&Direction::new(0.0, 0.0, 1.0)), [0.0, 0.0]);
        let [u, v] = direction_to_position(&Direction::new(0.0, 0.0, -1.0));
        assert!((u - libm::acos(COS_RIM) / FRAC_PI_2).abs() < 1e-15 && v == 0.0);
    }

    #[test]
    fn the_scale_is_continuous_at_the_centre_and_constant_outside() {
        assert_eq!(mapping_scale([0.0, 0.0]), FRAC_PI_2);
        assert!((mapping_scale([1e-8, 0.0]) - FRAC_PI_2).abs() < 1e-15);
        assert_eq!(mapping_scale([1.0, 1.0]), FRAC_PI_2.sqrt());
        assert_eq!(mapping_scale([0.0, 1.0]), FRAC_PI_2.sqrt());
        // 256 texels across the disc: one cycle per texel is 128 per unit, and a unit is pi/2 at the centre
        let near_the_centre = AngularMap::new(256).cycles_per_radian(128, 128);
        assert!((near_the_centre - 128.0 / FRAC_PI_2).abs() < 1e-3);
    }
}
