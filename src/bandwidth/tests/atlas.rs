//! Atlases of whole materials.

use brdfit_bandwidth::{
    Atlas, AtlasChannels, AtlasError, Layout, LobeEstimator, LobeGrid, LobeMemory, LobeOptions, SIZE, TILE, TILES,
    compute_atlas, incident_direction,
};
use brdfit_brdf::{Brdf, Direction, Lambert, Symmetry, direction};

fn options() -> LobeOptions {
    LobeOptions { max_resolution: 256, ..LobeOptions::default() }
}

/// A lobe around the mirror direction that takes no time to evaluate; isotropic, different in all channels.
struct Cheap;

impl Brdf for Cheap {
    fn value(&self, i: &Direction, o: &Direction) -> [f64; 3] {
        let from_mirror = 1.0 - (i.z * o.z - i.x * o.x - i.y * o.y);
        [20.0, 50.0, 120.0].map(|k| {
            let lobe = 1.0 / (1.0 + k * from_mirror);
            0.02 + lobe * lobe
        })
    }
}

fn cheap(layout: Layout, channels: AtlasChannels) -> Atlas {
    compute_atlas(&Cheap, layout, channels, &LobeGrid::default(), &options()).unwrap().0
}

/// The texels of channel `channel` in a tile.
fn tile(atlas: &Atlas, tile: usize, channel: usize) -> Vec<f32> {
    let (top, left) = (tile / TILES * TILE, tile % TILES * TILE);
    (0..TILE * TILE).map(|n| atlas.texel(0, top + n / TILE, left + n % TILE)[channel]).collect()
}

#[test]
fn tiles_hold_the_lobes_of_their_directions() {
    let (grid, mut memory) = (LobeGrid::default(), LobeMemory::default());
    let lobes = LobeEstimator::new(&Cheap, &grid, true, options());
    let atlas = cheap(Layout::Isotropic, AtlasChannels::Rgba);
    for n in [0, 17, 130, 255] {
        let lobe = lobes.estimate(&incident_direction(Layout::Isotropic, n), &mut memory);
        for channel in 0..3 {
            assert_eq!(tile(&atlas, n, channel), lobe.texels[channel], "tile {n}");
        }
    }
    // what a file in half precision holds is never below what was computed
    let stored = atlas.rounded_up();
    assert!(atlas.levels().iter().zip(stored.levels()).all(|(computed, stored)| {
        computed.texels().iter().zip(stored.texels()).all(|(computed, stored)| stored >= computed)
    }));
}

/// A quarter of the tiles is computed, the others are its reflections: they are what would have been computed, but for rounding.
#[test]
fn every_quarter_of_the_hemisphere_is_estimated_right() {
    let (grid, mut memory) = (LobeGrid::default(), LobeMemory::default());
    let lobes = LobeEstimator::new(&Cheap, &grid, false, options());
    let atlas = cheap(Layout::Hemisphere, AtlasChannels::Rgba);
    let mut worst = 0.0_f32;
    for (row, column) in [(2, 5), (5, 12), (13, 3), (11, 9), (0, 15), (8, 8), (15, 7)] {
        let n = row * TILES + column;
        let lobe = lobes.estimate(&incident_direction(Layout::Hemisphere, n), &mut memory);
        for channel in 0..3 {
            for (ours, direct) in tile(&atlas, n, channel).iter().zip(&lobe.texels[channel]) {
                if ours != direct {
                    worst = worst.max((ours / direct - 1.0).abs().min(f32::MAX));
                }
            }
        }
    }
    println!("reflected tiles: {worst:.1e} from direct estimates");
    assert!(worst < 1e-4, "{worst}");
}

#[test]
fn the_number_of_threads_changes_no_byte() {
    let atlases = [1, 2, 3].map(|threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let atlas = pool.install(|| cheap(Layout::Hemisphere, AtlasChannels::Max));
        atlas.level(0).texels().iter().flat_map(|texel| texel.to_le_bytes()).collect::<Vec<u8>>()
    });
    assert!(atlases[0] == atlases[1] && atlases[0] == atlases[2]);
}

#[test]
fn a_constant_has_an_atlas_of_zeros() {
    let lambert = Lambert { albedo: [0.2, 0.5, 0.7] };
    for layout in [Layout::Isotropic, Layout::Hemisphere] {
        let (atlas, statistics) =
            compute_atlas(&lambert, layout, AtlasChannels::Max, &LobeGrid::default(), &LobeOptions::default()).unwrap();
        assert_eq!(atlas.range(), (0.0, 0.0));
        let tiles: Vec<_> = statistics.tiles_per_resolution.iter().map(|n| (n.resolution, n.tiles)).collect();
        assert_eq!(tiles, [(256, 256), (512, 0), (1024, 0)]);
        assert!(statistics.saturated_tiles.is_empty());
    }
}

/// Brushed metal that is a mirror for light near the normal.
struct Brushed;

impl Brdf for Brushed {
    fn symmetry(&self) -> Symmetry {
        Symmetry::None
    }

    fn value(&self, i: &Direction, o: &Direction) -> [f64; 3] {
        let (x, y) = (i.x + o.x, i.y + o.y);
        let k = if i.z > 0.9 { 1e5 } else { 10.0 };
        let lobe = 1.0 / (1.0 + k * (x * x + 3.0 * y * y + x * y));
        [lobe * lobe; 3]
    }
}

#[test]
fn anisotropic_materials_have_all_their_tiles() {
    let (layout, grid) = (Layout::Hemisphere, LobeGrid::default());
    let (atlas, statistics) = compute_atlas(&Brushed, layout, AtlasChannels::Max, &grid, &options()).unwrap();
    let saturated: Vec<usize> = (0..256).filter(|&n| incident_direction(layout, n).z > 0.9).collect();
    assert_eq!(statistics.saturated_tiles, saturated);
    let tiles: Vec<_> = statistics.tiles_per_resolution.iter().map(|n| (n.resolution, n.tiles)).collect();
    assert_eq!(tiles, [(256, 256), (512, 0), (1024, 0)]);
    let lobes = LobeEstimator::new(&Brushed, &grid, false, options());
    for n in [3, 75, 180, 250] {
        let lobe = lobes.estimate(&incident_direction(layout, n), &mut LobeMemory::default());
        assert_eq!(tile(&atlas, n, 0), lobe.texels[0], "tile {n}");
    }
}

#[test]
fn tiles_are_where_the_documentation_puts_them() {
    let close = |a: Direction, b: Direction| assert!((a - b).norm() < 1e-14, "{a} {b}");
    let half = std::f64::consts::FRAC_PI_2;
    close(incident_direction(Layout::Isotropic, 0), direction(half / 512.0, 0.0));
    close(incident_direction(Layout::Isotropic, 255), direction(half * 511.0 / 512.0, 0.0));
    // row 8, column 11 of 16: u = 7/16, v = 1/16
    let theta = half * libm::hypot(7.0, 1.0) / 16.0;
    close(incident_direction(Layout::Hemisphere, 8 * 16 + 11), direction(theta, libm::atan2(1.0, 7.0)));
    assert!((incident_direction(Layout::Hemisphere, 0).z - 0.02).abs() < 1e-14);
    assert!(std::panic::catch_unwind(|| incident_direction(Layout::Isotropic, SIZE)).is_err());
}

#[test]
#[should_panic(expected = "isotropic")]
fn the_isotropic_layout_needs_an_isotropic_material() {
    let _ = compute_atlas(&Brushed, Layout::Isotropic, AtlasChannels::Max, &LobeGrid::default(), &options());
}

/// Fine but for one direction in which it has no value.
struct Broken(f64);

impl Brdf for Broken {
    fn value(&self, i: &Direction, o: &Direction) -> [f64; 3] {
        let value = if i.z > 0.5 && o.x > 0.1 && o.y > 0.1 && o.x + o.y < 0.21 { self.0 } else { 0.3 + 0.1 * o.x };
        [0.2, value, 0.2]
    }
}

#[test]
fn values_that_are_not_finite_are_refused() {
    for value in [f64::NAN, f64::INFINITY] {
        let (layout, grid) = (Layout::Hemisphere, LobeGrid::default());
        let result = compute_atlas(&Broken(value), layout, AtlasChannels::Max, &grid, &options());
        assert!(matches!(result, Err(AtlasError::Texels { .. })), "{value} went unnoticed");
    }
}
