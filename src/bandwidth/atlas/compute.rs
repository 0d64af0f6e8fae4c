//! The atlas of a material: all its lobes.

use brdfit_brdf::{Brdf, Direction, Symmetry, direction};
use rayon::prelude::*;

use crate::atlas::error::AtlasError;
use crate::atlas::sidecar::{AtlasOptions, AtlasStatistics, TileCount};
use crate::atlas::texture::{Atlas, AtlasChannels, Layout, SIZE, TILE, TILES};
use crate::lobe::estimate::{Lobe, LobeEstimator, LobeMemory, LobeOptions};
use crate::lobe::grid::{LobeGrid, RESOLUTIONS, size};
use crate::lobe::mapping::AngularMap;

/// The incident direction (unit) for which a tile of an atlas holds the lobe, and its light: `t = column + 16 row`.
///
/// Isotropic: `theta_i = (t + 1/2) / 256 pi/2` at azimuth 0. Hemisphere: the centre of texel (row, column) of a 16 x 16 angular
/// map, at the rim where that lies outside the disc.
///
/// # Panics
/// If there is no such tile.
pub fn incident_direction(layout: Layout, tile: usize) -> Direction {
    const COUNT: usize = TILES * TILES;
    assert!(tile < COUNT, "no tile {tile}");
    match layout {
        Layout::Isotropic => direction((tile as f64 + 0.5) / COUNT as f64 * std::f64::consts::FRAC_PI_2, 0.0),
        Layout::Hemisphere => AngularMap::new(TILES).direction(tile / TILES, tile % TILES),
    }
}

/// Precomputes the bandwidth atlas of a material (paper 000, section 2.3; docs/theory.md) on the threads of the current rayon pool.
///
/// The material's [`Symmetry`] saves work: of a mirror symmetric one the isotropic layout computes half, the hemisphere layout a
/// quarter. The same input gives the same bytes for every number of threads.
///
/// # Errors
/// [`AtlasError`] if a bandwidth cannot be stored: the material has values that are not finite.
///
/// # Panics
/// If the layout is isotropic and the material is not.
pub fn compute_atlas(
    brdf: &dyn Brdf,
    layout: Layout,
    channels: AtlasChannels,
    grid: &LobeGrid,
    options: &LobeOptions,
) -> Result<(Atlas, AtlasStatistics), AtlasError> {
    let symmetry = brdf.symmetry();
    assert!(
        symmetry != Symmetry::None || layout == Layout::Hemisphere,
        "the isotropic layout needs an isotropic material"
    );
    let mirrored = symmetry == Symmetry::Mirror;
    let lobes = LobeEstimator::new(brdf, grid, mirrored, *options);
    // reflections of the material's own lobes need not be computed, where the estimate of a reflection is the reflected estimate
    let folded = layout == Layout::Hemisphere && mirrored && options.estimator.reflections;
    let computed = |tile: usize| !folded || (tile / TILES < TILES / 2 && tile % TILES < TILES / 2);
    let mut tiles: Vec<Option<Lobe>> = (0..TILES * TILES)
        .into_par_iter()
        .map_init(LobeMemory::default, |memory, tile| {
            computed(tile).then(|| lobes.estimate(&incident_direction(layout, tile), memory))
        })
        .collect();
    for tile in 0..tiles.len() {
        if tiles[tile].is_none() {
            let (row, column) = (tile / TILES, tile % TILES);
            let fold = |n: usize| n.min(TILES - 1 - n);
            let source = tiles[fold(row) * TILES + fold(column)].as_ref();
            tiles[tile] = source.map(|lobe| reflected(lobe, row != fold(row), column != fold(column)));
        }
    }
    let tiles: Vec<Lobe> = tiles.into_iter().flatten().collect();

    let mut texels = Vec::with_capacity(SIZE * SIZE * channels.count());
    for row in 0..SIZE {
        for column in 0..TILES {
            let lobe = &tiles[row / TILE * TILES + column];
            for texel in row % TILE * TILE..(row % TILE + 1) * TILE {
                let [r, g, b] = [0, 1, 2].map(|channel: usize| lobe.texels[channel][texel]);
                let max = r.max(g).max(b);
                match channels {
                    AtlasChannels::Max => texels.push(max),
                    AtlasChannels::Rgba => texels.extend([r, g, b, max]),
                }
            }
        }
    }
    let count = |resolution: usize| TileCount {
        resolution: size(resolution) as u32,
        tiles: tiles.iter().filter(|lobe| lobe.resolution == size(resolution)).count(),
    };
    let statistics = AtlasStatistics {
        tiles_per_resolution: (0..RESOLUTIONS).map(count).collect(),
        saturated_tiles: (0..tiles.len()).filter(|&tile| tiles[tile].saturated).collect(),
    };
    Ok((Atlas::from_level0(layout, channels, texels)?, statistics))
}

/// The lobe seen in a mirror.
fn reflected(lobe: &Lobe, rows: bool, columns: bool) -> Lobe {
    let texels = lobe.texels.each_ref().map(|channel| {
        let mut texels = channel.clone();
        if columns {
            texels.chunks_exact_mut(TILE).for_each(<[f32]>::reverse);
        }
        if rows { texels.chunks_exact(TILE).rev().flatten().copied().collect() } else { texels }
    });
    Lobe { texels, ..*lobe }
}

impl From<&LobeOptions> for AtlasOptions {
    fn from(options: &LobeOptions) -> Self {
        let estimator = options.estimator;
        Self {
            rule: estimator.rule,
            delta: estimator.delta,
            kappa: estimator.kappa(),
            reflections: estimator.reflections,
            finest_share: options.finest_share,
            resolutions: (0..RESOLUTIONS)
                .map(|r| size(r) as u32)
                .filter(|&n| n as usize <= options.max_resolution)
                .collect(),
        }
    }
}
