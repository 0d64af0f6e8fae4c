//! The atlas: 256 tiles of 64 x 64 bandwidths in one square image, with its mip chain by maximum.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::atlas::error::AtlasError;
use crate::atlas::f16_round_up::f16_rounded_up;

/// Texels along one side of level 0.
pub const SIZE: usize = 1024;
/// Texels along one side of a tile in level 0.
pub const TILE: usize = 64;
/// Tiles along one side.
pub const TILES: usize = SIZE / TILE;
/// Levels, 1024, 512, .. 16: in the last one a tile is one texel.
pub const LEVELS: usize = 7;
/// Unit of every texel.
pub const UNITS: &str = "cycles per radian";
/// Largest texel, the largest finite number of half precision.
pub const LARGEST: f32 = 65504.0;

/// Incident directions of the tiles.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Layout {
    /// Tile t = column + 16 row is the elevation theta_i = (t + 1/2)/256 pi/2, enough for an isotropic material.
    Isotropic,
    /// The tiles are 16 x 16 incident directions on the same angular map as the texels of a tile.
    Hemisphere,
}

impl Layout {
    /// The name that files carry.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Isotropic => "isotropic",
            Self::Hemisphere => "hemisphere",
        }
    }
}

/// Channels of a texel.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum AtlasChannels {
    /// One channel, the maximum over red, green and blue.
    Max,
    /// Four channels: red, green, blue and the maximum of the three.
    Rgba,
}

impl AtlasChannels {
    /// Values per texel.
    #[must_use]
    pub fn count(self) -> usize {
        self.names().len()
    }

    /// Names of the values in the order in which a texel holds them; the channel names of an EXR file.
    #[must_use]
    pub fn names(self) -> &'static [&'static str] {
        match self {
            Self::Max => &["max"],
            Self::Rgba => &["R", "G", "B", "max"],
        }
    }
}

/// Texels along one side of level `level`.
#[must_use]
pub const fn level_size(level: usize) -> usize {
    SIZE >> level
}

/// One level of the chain.
#[derive(Clone, Debug, PartialEq)]
pub struct Level {
    size: usize,
    texels: Vec<f32>,
}

impl Level {
    /// Texels along one side.
    #[must_use]
    pub fn size(&self) -> usize {
        self.size
    }

    /// All values in cycles per radian, row by row from row 0, the channels of a texel side by side.
    #[must_use]
    pub fn texels(&self) -> &[f32] {
        &self.texels
    }

    /// The level half this size: the maximum over 2 x 2 texels of each channel. Tiles are powers of two, none are mixed.
    fn halved(&self, channels: usize) -> Self {
        let size = self.size / 2;
        let mut texels = Vec::with_capacity(size * size * channels);
        for rows in self.texels.chunks_exact(2 * self.size * channels) {
            let (upper, lower) = rows.split_at(self.size * channels);
            for (a, b) in upper.chunks_exact(2 * channels).zip(lower.chunks_exact(2 * channels)) {
                for c in 0..channels {
                    texels.push(a[c].max(a[c + channels]).max(b[c]).max(b[c + channels]));
                }
            }
        }
        Self { size, texels }
    }
}

/// The local bandwidth of a material's outgoing lobes. Every texel is finite, not negative and at most [`LARGEST`]; each
/// level is the maximum over 2 x 2 texels of the one before.
#[derive(Clone, Debug, PartialEq)]
pub struct Atlas {
    layout: Layout,
    channels: AtlasChannels,
    levels: Vec<Level>,
}

impl Atlas {
    /// Builds the mip chain on `texels`, the level 0: [`SIZE`] x [`SIZE`] texels in the order of [`Level::texels`].
    ///
    /// # Errors
    /// [`AtlasError::Texels`] if the length is wrong, a value is not finite, negative or above [`LARGEST`], or a fourth
    /// channel is not the maximum of the other three.
    pub fn from_level0(layout: Layout, channels: AtlasChannels, mut texels: Vec<f32>) -> Result<Self, AtlasError> {
        let expected = SIZE * SIZE * channels.count();
        if texels.len() != expected {
            return Err(AtlasError::Texels { why: format!("{} values instead of {expected}", texels.len()) });
        }
        // -0 becomes 0: which of the two a maximum picks is not defined
        texels.iter_mut().for_each(|texel| *texel += 0.0);
        let level0 = Level { size: SIZE, texels };
        check_values(0, &level0, channels).map_err(|why| AtlasError::Texels { why })?;
        let mut levels = vec![level0];
        while levels.len() < LEVELS {
            let next = levels[levels.len() - 1].halved(channels.count());
            levels.push(next);
        }
        Ok(Self { layout, channels, levels })
    }

    /// Incident directions of the tiles.
    #[must_use]
    pub fn layout(&self) -> Layout {
        self.layout
    }

    /// Channels of a texel.
    #[must_use]
    pub fn channels(&self) -> AtlasChannels {
        self.channels
    }

    /// Level `level`, 0 to 6.
    ///
    /// # Panics
    /// If there is no such level.
    #[must_use]
    pub fn level(&self, level: usize) -> &Level {
        &self.levels[level]
    }

    /// All levels from 1024 x 1024 to 16 x 16.
    #[must_use]
    pub fn levels(&self) -> &[Level] {
        &self.levels
    }

    /// The channels of one texel.
    ///
    /// # Panics
    /// If level, row or column are out of range.
    #[must_use]
    pub fn texel(&self, level: usize, row: usize, column: usize) -> &[f32] {
        let Level { size, texels } = &self.levels[level];
        assert!(column < *size, "column {column} of {size}");
        let count = self.channels.count();
        &texels[(row * size + column) * count..][..count]
    }

    /// Smallest and largest value of level 0 over all channels, cycles per radian.
    #[must_use]
    pub fn range(&self) -> (f32, f32) {
        let fold = |(low, high): (f32, f32), &value: &f32| (low.min(value), high.max(value));
        self.levels[0].texels.iter().fold((f32::INFINITY, 0.0), fold)
    }

    /// Every value replaced by the smallest number of half precision that is not below it ([`f16_rounded_up`]): what a file in
    /// half precision holds, in every level, since rounding up commutes with the maximum.
    #[must_use]
    pub fn rounded_up(&self) -> Self {
        let round = |level: &Level| Level {
            size: level.size,
            texels: level.texels.iter().map(|&value| f16_rounded_up(value).to_f32()).collect(),
        };
        Self { layout: self.layout, channels: self.channels, levels: self.levels.iter().map(round).collect() }
    }
}

/// Says which value of a level cannot be a bandwidth.
fn check_values(k: usize, level: &Level, channels: AtlasChannels) -> Result<(), String> {
    if let Some(at) = level.texels.iter().position(|value| !(0.0..=LARGEST).contains(value)) {
        let place = place(k, level, channels, at);
        return Err(format!("{place} is {}, not a bandwidth of 0 to {LARGEST} {UNITS}", level.texels[at]));
    }
    if channels == AtlasChannels::Rgba {
        let wrong = |texel: &[f32]| texel[3] != texel[0].max(texel[1]).max(texel[2]);
        if let Some(texel) = level.texels.chunks_exact(4).position(wrong) {
            return Err(format!("{} is not the maximum of R, G and B", place(k, level, channels, 4 * texel + 3)));
        }
    }
    Ok(())
}

/// Names the value at index `at` of a level.
pub(crate) fn place(k: usize, level: &Level, channels: AtlasChannels, at: usize) -> String {
    let (texel, channel) = (at / channels.count(), channels.names()[at % channels.count()]);
    format!("level {k}, row {}, column {}, channel {channel}", texel / level.size, texel % level.size)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn zeros(channels: AtlasChannels) -> Vec<f32> {
        vec![0.0; SIZE * SIZE * channels.count()]
    }

    #[test]
    fn sizes() {
        let atlas = Atlas::from_level0(Layout::Isotropic, AtlasChannels::Max, zeros(AtlasChannels::Max)).unwrap();
        let sizes: Vec<usize> = atlas.levels().iter().map(Level::size).collect();
        assert_eq!(sizes, [1024, 512, 256, 128, 64, 32, 16]);
        assert_eq!(TILE >> (LEVELS - 1), 1);
        assert_eq!(atlas.range(), (0.0, 0.0));
    }

    #[test]
    fn what_cannot_be_an_atlas() {
        let build = |channels, texels| Atlas::from_level0(Layout::Isotropic, channels, texels).unwrap_err().to_string();
        let with = |value| {
            let mut texels = zeros(AtlasChannels::Max);
            texels[3 * SIZE + 5] = value;
            build(AtlasChannels::Max, texels)
        };
        for (value, word) in [(f32::NAN, "NaN"), (-1.0, "-1"), (f32::INFINITY, "inf"), (65505.0, "65505")] {
            let message = with(value);
            assert!(message.contains(&format!("level 0, row 3, column 5, channel max is {word}, not")), "{message}");
        }
        assert!(build(AtlasChannels::Max, vec![0.0; 12]).contains("12 values instead of 1048576"));
        let mut texels = zeros(AtlasChannels::Rgba);
        texels[4 * 7 + 1] = 2.0;
        let message = build(AtlasChannels::Rgba, texels);
        assert!(message.contains("row 0, column 7, channel max is not the maximum"), "{message}");
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(24))]

        /// A single bright texel shows in each level exactly in the texel above it, so it never leaves its tile.
        #[test]
        fn one_texel_reaches_its_own_tile_only(row in 0..SIZE, column in 0..SIZE, value in 0.0_f32..LARGEST) {
            let mut texels = zeros(AtlasChannels::Max);
            texels[row * SIZE + column] = value;
            let atlas = Atlas::from_level0(Layout::Hemisphere, AtlasChannels::Max, texels).unwrap();
            for (k, level) in atlas.levels().iter().enumerate() {
                prop_assert_eq!(atlas.texel(k, row >> k, column >> k), &[value]);
                prop_assert_eq!(level.texels().iter().filter(|&&texel| texel > 0.0).count(), usize::from(value > 0.0));
            }
        }

        /// Level k at (row, column) is the maximum over the 2^k x 2^k texels of level 0 below it, for every channel.
        #[test]
        fn levels_are_maxima_of_level_0(seed in any::<u32>(), k in 0..LEVELS, row in 0..16_usize, column in 0..16_usize) {
            let atlas = speckled(seed);
            for c in 0..4 {
                let block = (0..1 << k).flat_map(|y| (0..1 << k).map(move |x| (y, x)));
                let expected = block.map(|(y, x)| atlas.texel(0, (row << k) + y, (column << k) + x)[c]);
                prop_assert_eq!(atlas.texel(k, row, column)[c], expected.fold(0.0, f32::max));
            }
            let (low, high) = atlas.range();
            prop_assert!(low <= high && atlas.level(6).texels().iter().all(|&texel| texel <= high));
        }

        /// Rounding up commutes with the mip chain and never lowers a value.
        #[test]
        fn rounding_up_keeps_the_chain(seed in any::<u32>()) {
            let atlas = speckled(seed);
            let rounded = atlas.rounded_up();
            let level0 = rounded.level(0).texels().to_vec();
            prop_assert_eq!(&Atlas::from_level0(atlas.layout(), atlas.channels(), level0).unwrap(), &rounded);
            for (a, b) in atlas.level(0).texels().iter().zip(rounded.level(0).texels()) {
                prop_assert!(b >= a && *b <= a * 1.001 + 6e-8);
            }
        }
    }

    fn speckled(seed: u32) -> Atlas {
        let value = |n: u32| f32::from_bits((n.wrapping_mul(0x9E37_79B9) ^ seed) % 0x477F_E000);
        let texel = |n: u32| {
            let [r, g, b] = [value(3 * n), value(3 * n + 1), value(3 * n + 2)];
            [r, g, b, r.max(g).max(b)]
        };
        let texels = (0..(SIZE * SIZE) as u32).flat_map(texel).collect();
        Atlas::from_level0(Layout::Isotropic, AtlasChannels::Rgba, texels).unwrap()
    }
}
