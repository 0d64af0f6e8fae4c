//! Atlases of random values and, for random look-ups in them, what the Rust functions return;
//! scripts/validate/atlas/check_shaders.sh compares the shaders with it.
//!
//!     cargo run --example sampling_vectors -- FOLDER
//!
//! writes FOLDER/{isotropic,hemisphere}.ktx2 and beside each a .rows file: little-endian f32, 16 per look-up, i and the
//! level, o and 0, the nearest texel and the bilinear value.

use std::f64::consts::{FRAC_PI_2, PI};
use std::path::Path;

use brdfit_bandwidth::sidecar::{Provenance, Source};
use brdfit_bandwidth::{Atlas, AtlasChannels, AtlasPlace, LEVELS, Layout, SIZE, TILE, TILES, ktx2};
use brdfit_brdf::direction;

/// Look-ups per layout, beside the special ones.
const LOOKUPS: usize = 20_000;
/// How far look-ups stay from the border between two texels, in texels: there, rounding decides which one is nearest.
const MARGIN: f32 = 1e-3;

/// Steele's SplitMix64.
struct Random(u64);

impl Random {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ (z >> 31)
    }

    /// Uniform in [0, 1).
    fn uniform(&mut self) -> f64 {
        (self.next() >> 11) as f64 / (1_u64 << 53) as f64
    }
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let folder = std::env::args().nth(1).ok_or("sampling_vectors FOLDER")?;
    let source = Source { name: "random".to_owned(), sha256: None, kind: "fit".to_owned() };
    let provenance = Provenance { program: "sampling_vectors".to_owned(), source };
    for (layout, channels) in [(Layout::Isotropic, AtlasChannels::Max), (Layout::Hemisphere, AtlasChannels::Rgba)] {
        let mut random = Random(layout as u64);
        let atlas = random_atlas(layout, channels, &mut random)?;
        let path = Path::new(&folder).join(layout.name());
        std::fs::write(path.with_extension("ktx2"), ktx2::to_bytes(&atlas, &provenance))?;
        let mut rows = Vec::new();
        for (i, o) in special_pairs() {
            (0..LEVELS).for_each(|level| look_up(&atlas, i, o, level, &mut rows));
        }
        for _ in 0..LOOKUPS {
            let level = (random.next() % LEVELS as u64) as usize;
            let (i, o) = random_pair(layout, TILE >> level, &mut random);
            look_up(&atlas, i, o, level, &mut rows);
        }
        let bytes: Vec<u8> = rows.iter().flat_map(|value: &f32| value.to_le_bytes()).collect();
        std::fs::write(path.with_extension("rows"), bytes)?;
    }
    Ok(())
}

/// Multiples of 1/16 below 128: exact in half precision.
fn random_atlas(
    layout: Layout,
    channels: AtlasChannels,
    random: &mut Random,
) -> Result<Atlas, Box<dyn std::error::Error>> {
    let mut texels = Vec::with_capacity(SIZE * SIZE * channels.count());
    for _ in 0..SIZE * SIZE {
        let colours: [f32; 3] = std::array::from_fn(|_| (random.next() % 2048) as f32 / 16.0);
        if channels == AtlasChannels::Rgba {
            texels.extend(colours);
        }
        texels.push(colours.into_iter().fold(0.0, f32::max));
    }
    Ok(Atlas::from_level0(layout, channels, texels)?)
}

/// Where the azimuth is undefined, and at and below the horizon.
fn special_pairs() -> Vec<([f32; 3], [f32; 3])> {
    let special = [
        [0.0, 0.0, 1.0],
        [0.0, 0.0, 0.25],
        [1e-14, -1e-14, 1.0],
        [1.0, 0.0, 0.0],
        [0.36, 0.48, -0.8],
        [0.0, 0.0, -1.0],
        [0.48, 0.6, 0.64],
    ];
    special.iter().flat_map(|&i| special.iter().map(move |&o| (i, o))).collect()
}

/// A pair of directions of any length, o on the whole sphere, that lies well inside a texel of n x n and inside a tile.
fn random_pair(layout: Layout, n: usize, random: &mut Random) -> ([f32; 3], [f32; 3]) {
    let inside = |position: f32, n: usize| {
        let texel = position * n as f32;
        (texel - texel.round()).abs() > MARGIN
    };
    loop {
        let mut draw = |largest: f64| {
            let d = direction(largest * random.uniform(), 2.0 * PI * random.uniform()) * (0.5 + random.uniform());
            [d.x as f32, d.y as f32, d.z as f32]
        };
        let (i, o) = (draw(1.1 * FRAC_PI_2), draw(PI));
        let place = AtlasPlace::new(layout, i, o);
        let tile_inside = match layout {
            Layout::Isotropic => {
                let theta_i = f64::from(i[0].hypot(i[1])).atan2(f64::from(i[2]));
                inside((theta_i / FRAC_PI_2) as f32, TILES * TILES)
            }
            Layout::Hemisphere => {
                AtlasPlace::new(layout, [0.0, 0.0, 1.0], i).position.iter().all(|&at| inside(at, TILES))
            }
        };
        if tile_inside && place.position.iter().all(|&at| inside(at, n)) {
            return (i, o);
        }
    }
}

fn look_up(atlas: &Atlas, i: [f32; 3], o: [f32; 3], level: usize, rows: &mut Vec<f32>) {
    let place = AtlasPlace::new(atlas.layout(), i, o);
    rows.extend(i.into_iter().chain([level as f32]).chain(o).chain([0.0]));
    rows.extend(atlas.nearest(&place, level).into_iter().chain(atlas.bilinear(&place, level)));
}
