//! Look-ups in an atlas, in single precision and step by step as the shaders of [`crate::shader`] do them.
//!
//! Directions point away from the surface, in its frame: the normal is +z. They need not have length one. A direction below
//! the rim, arccos 0.02 from the normal, counts as the one on the rim with the same azimuth, and the azimuth of the normal is
//! zero. Incident directions at and below the horizon take the outermost tile of an isotropic atlas.

use std::f32::consts::FRAC_PI_2;

use crate::atlas::texture::{Atlas, LEVELS, Layout, TILE, TILES};

/// Polar angle of the rim, arccos 0.02.
const RIM: f32 = 1.550_795;
/// Sine of the polar angle below which a direction has no azimuth, per unit of length. Its square is far above the smallest
/// normal number, so hardware that flushes the others to zero takes the same branch.
const NO_AZIMUTH: f32 = 1e-12;

/// Position of a pair of directions in an atlas, for every level.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AtlasPlace {
    /// Column and row of the tile, 0 to 15 each.
    pub tile: [usize; 2],
    /// Position inside the tile, `(u + 1)/2` and `(v + 1)/2` of the angular map.
    pub position: [f32; 2],
}

impl AtlasPlace {
    /// The place of a pair of directions, of any length above zero, in an atlas of the given layout.
    ///
    /// The incident direction takes the tile that it lies in, which is the nearest elevation (isotropic) or texel of the
    /// angular map of 16 x 16 directions (hemisphere). The outgoing direction is turned by `-phi_i` in the isotropic layout
    /// and taken as it is in the other one.
    #[must_use]
    pub fn new(layout: Layout, i: [f32; 3], o: [f32; 3]) -> Self {
        match layout {
            Layout::Isotropic => {
                let ([cos, sin], across) = azimuth(i);
                let tile = part(libm::atan2f(across, i[2]) / FRAC_PI_2, TILES * TILES);
                let turned = [cos * o[0] + sin * o[1], cos * o[1] - sin * o[0], o[2]];
                Self { tile: [tile % TILES, tile / TILES], position: angular_map(turned) }
            }
            Layout::Hemisphere => {
                Self { tile: angular_map(i).map(|position| part(position, TILES)), position: angular_map(o) }
            }
        }
    }
}

impl Atlas {
    /// The texel of a level that a place lies in, cycles per radian. The four values are what a shader reads: the maximum
    /// over the colours, 0, 0 and 1, or the bandwidths of red, green and blue and their maximum.
    ///
    /// # Panics
    /// If there is no such level.
    #[must_use]
    pub fn nearest(&self, place: &AtlasPlace, level: usize) -> [f32; 4] {
        let n = tile_size(level);
        let [column, row] = place.position.map(|position| part(position, n));
        self.texel_of_tile(place, level, row, column)
    }

    /// As [`Self::nearest`], but bilinear between the centres of the four nearest texels of the tile. Other tiles are never
    /// read: beyond the outermost centres the value stays that of the outermost texels.
    ///
    /// # Panics
    /// If there is no such level.
    #[must_use]
    pub fn bilinear(&self, place: &AtlasPlace, level: usize) -> [f32; 4] {
        let n = tile_size(level);
        let [x, y] = place.position.map(|position| (position * n as f32 - 0.5).clamp(0.0, (n - 1) as f32));
        let (column, row) = (x as usize, y as usize);
        let (right, below) = ((column + 1).min(n - 1), (row + 1).min(n - 1));
        let mix = |a: [f32; 4], b: [f32; 4], t: f32| std::array::from_fn(|c| a[c] + (b[c] - a[c]) * t);
        let texel = |row, column| self.texel_of_tile(place, level, row, column);
        let top = mix(texel(row, column), texel(row, right), x - x.floor());
        let bottom = mix(texel(below, column), texel(below, right), x - x.floor());
        mix(top, bottom, y - y.floor())
    }

    /// A texel of the tile of a place, as a shader reads it.
    fn texel_of_tile(&self, place: &AtlasPlace, level: usize, row: usize, column: usize) -> [f32; 4] {
        let corner = place.tile.map(|index| index * tile_size(level));
        match *self.texel(level, corner[1] + row, corner[0] + column) {
            [r, g, b, max] => [r, g, b, max],
            ref one => [one[0], 0.0, 0.0, 1.0],
        }
    }
}

/// Texels along one side of a tile.
fn tile_size(level: usize) -> usize {
    assert!(level < LEVELS, "level {level} of {LEVELS}");
    TILE >> level
}

/// Cosine and sine of the azimuth of `d`, and the length of its projection on the surface.
fn azimuth(d: [f32; 3]) -> ([f32; 2], f32) {
    let across = (d[0] * d[0] + d[1] * d[1]).sqrt();
    if across < NO_AZIMUTH { ([1.0, 0.0], across) } else { ([d[0] / across, d[1] / across], across) }
}

/// Position of `d` on the angular map, (u, v) moved to 0 to 1.
fn angular_map(d: [f32; 3]) -> [f32; 2] {
    let (azimuth, across) = azimuth(d);
    let r = libm::atan2f(across, d[2]).min(RIM) / FRAC_PI_2;
    azimuth.map(|component| 0.5 + 0.5 * r * component)
}

/// Index of the part out of `n` that a position from 0 to 1 lies in.
fn part(position: f32, n: usize) -> usize {
    ((position * n as f32) as usize).min(n - 1)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::atlas::texture::{AtlasChannels, SIZE};
    use crate::lobe::mapping::{AngularMap, direction_to_position};
    use brdfit_brdf::{Direction, direction};
    use proptest::prelude::*;
    use std::sync::LazyLock;

    /// An atlas in which a texel differs from all those near it.
    fn numbered(layout: Layout) -> Atlas {
        let texels = (0..SIZE * SIZE).map(|k| (k % 65_497) as f32).collect();
        Atlas::from_level0(layout, AtlasChannels::Max, texels).unwrap()
    }

    static ISOTROPIC: LazyLock<Atlas> = LazyLock::new(|| numbered(Layout::Isotropic));

    fn single(d: Direction) -> [f32; 3] {
        [d.x as f32, d.y as f32, d.z as f32]
    }

    /// The direction of a texel of the map, drawn in to the rim where it lies outside.
    fn texel_direction(n: usize, row: usize, column: usize) -> [f32; 3] {
        single(AngularMap::new(n).direction(row, column))
    }

    proptest! {
        #[test]
        fn a_texel_is_found_by_its_directions(
            t in 0..256_usize, level in 0..5_usize, row in 0..64_usize, column in 0..64_usize, phi_i in -3.1..3.1_f64,
        ) {
            let n = TILE >> level;
            let (row, column) = (row % n, column % n);
            let map = AngularMap::new(n);
            let [u, v] = map.position(row, column);
            prop_assume!(u.hypot(v) < 0.985);
            let theta_i = (t as f64 + 0.5) / 256.0 * std::f64::consts::FRAC_PI_2;
            let o = map.direction(row, column);
            let turned = direction(libm::acos(o.z.min(1.0)), libm::atan2(o.y, o.x) + phi_i);
            let place = AtlasPlace::new(Layout::Isotropic, single(direction(theta_i, phi_i)), single(turned));
            let texel = ISOTROPIC.texel(level, (t / 16) * n + row, (t % 16) * n + column)[0];
            prop_assert_eq!(ISOTROPIC.nearest(&place, level), [texel, 0.0, 0.0, 1.0]);
        }

        #[test]
        fn a_tile_of_the_hemisphere_is_found_by_its_direction(row in 0..16_usize, column in 0..16_usize) {
            let [u, v] = AngularMap::new(16).position(row, column);
            prop_assume!(u.hypot(v) < 0.985);
            let place = AtlasPlace::new(Layout::Hemisphere, texel_direction(16, row, column), [0.0, 0.0, 1.0]);
            prop_assert_eq!(place, AtlasPlace { tile: [column, row], position: [0.5, 0.5] });
        }

        #[test]
        fn positions_agree_with_the_map_in_double_precision(theta in 0.0..3.1_f64, phi in -3.1..3.1_f64) {
            let d = direction(theta, phi);
            let [u, v] = direction_to_position(&d);
            let place = AtlasPlace::new(Layout::Hemisphere, [0.0, 0.0, 1.0], single(d * 5.0));
            prop_assert!((f64::from(place.position[0]) - (0.5 + 0.5 * u)).abs() < 5e-7);
            prop_assert!((f64::from(place.position[1]) - (0.5 + 0.5 * v)).abs() < 5e-7);
        }

        #[test]
        fn a_common_turn_changes_nothing(theta_o in 0.0..3.0_f64, phi in -3.1..3.1_f64, turn in -3.1..3.1_f64) {
            let place = |turn| {
                let o = single(direction(theta_o, phi + turn));
                AtlasPlace::new(Layout::Isotropic, single(direction(0.7, turn)), o)
            };
            let (a, b) = (place(0.0), place(turn));
            prop_assert_eq!(a.tile, b.tile);
            prop_assert!((0..2).all(|k| (a.position[k] - b.position[k]).abs() < 5e-7));
        }

        #[test]
        fn bilinear_stays_between_the_texels_of_its_tile(
            tile in [0..16_usize, 0..16_usize], position in [0.0_f32..1.0, 0.0_f32..1.0], level in 0..LEVELS,
        ) {
            // each tile holds its own number: whatever another tile adds would show
            let number = |row: usize, column: usize| (1 + column / TILE + TILES * (row / TILE)) as f32;
            static ATLAS: LazyLock<Atlas> = LazyLock::new(|| {
                let texels = (0..SIZE * SIZE).map(|k| (1 + (k % SIZE) / TILE + TILES * (k / SIZE / TILE)) as f32);
                Atlas::from_level0(Layout::Isotropic, AtlasChannels::Max, texels.collect()).unwrap()
            });
            let place = AtlasPlace { tile, position };
            prop_assert_eq!(ATLAS.bilinear(&place, level)[0], number(tile[1] * TILE, tile[0] * TILE));
        }
    }

    #[test]
    fn bilinear_meets_the_texels_and_their_means() {
        let place = |column: f32, row: f32| AtlasPlace { tile: [3, 2], position: [column / 64.0, row / 64.0] };
        let texel = |row: usize, column: usize| ISOTROPIC.texel(0, 128 + row, 192 + column)[0];
        assert_eq!(ISOTROPIC.bilinear(&place(10.5, 7.5), 0)[0], texel(7, 10));
        assert_eq!(ISOTROPIC.bilinear(&place(11.0, 7.5), 0)[0], 0.5 * (texel(7, 10) + texel(7, 11)));
        assert_eq!(ISOTROPIC.bilinear(&place(10.5, 7.75), 0)[0], texel(7, 10) + 0.25 * (texel(8, 10) - texel(7, 10)));
        // beyond the outermost centres
        assert_eq!(ISOTROPIC.bilinear(&place(0.1, 0.1), 0)[0], texel(0, 0));
        assert_eq!(ISOTROPIC.bilinear(&place(64.0, 64.0), 0)[0], texel(63, 63));
    }

    #[test]
    fn four_channels_come_out_as_they_are() {
        let texels = (0..SIZE * SIZE).flat_map(|k| [1.0, (k % 7) as f32, 2.0, ((k % 7) as f32).max(2.0)]).collect();
        let atlas = Atlas::from_level0(Layout::Hemisphere, AtlasChannels::Rgba, texels).unwrap();
        let place = AtlasPlace { tile: [0, 0], position: [5.5 / 64.0, 0.5 / 64.0] };
        assert_eq!(atlas.nearest(&place, 0), [1.0, 5.0, 2.0, 5.0]);
        assert_eq!(atlas.bilinear(&place, 0), [1.0, 5.0, 2.0, 5.0]);
    }

    #[test]
    fn the_normal_and_the_horizon_are_defined() {
        let normal = [0.0, 0.0, 1.0];
        // the azimuth of the normal is zero: nothing is turned
        let o = single(direction(0.4, 1.0));
        let place = AtlasPlace::new(Layout::Isotropic, normal, o);
        assert_eq!(
            place,
            AtlasPlace { tile: [0, 0], position: AtlasPlace::new(Layout::Hemisphere, normal, o).position }
        );
        // at and below the horizon: the last elevation
        for i in [[1.0, 0.0, 0.0], [0.6, 0.0, -0.8], [0.0, 0.0, -1.0]] {
            assert_eq!(AtlasPlace::new(Layout::Isotropic, i, normal).tile, [15, 15]);
        }
        // o at and below the horizon: the rim at its azimuth, which is zero straight below
        for o in [[0.0, 2.0, 0.0], [0.0, 0.6, -0.8]] {
            let place = AtlasPlace::new(Layout::Hemisphere, normal, o);
            assert_eq!(place.position, [0.5, 0.5 + 0.5 * RIM / FRAC_PI_2]);
        }
        assert_eq!(AtlasPlace::new(Layout::Hemisphere, normal, [0.0, 0.0, -1.0]).position[1], 0.5);
        assert!((libm::cos(f64::from(RIM)) - crate::lobe::mapping::COS_RIM).abs() < 1e-7);
    }
}
