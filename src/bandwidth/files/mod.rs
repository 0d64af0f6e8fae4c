//! Files of atlases: OpenEXR and KTX2.

mod attributes;
pub mod exr;
pub mod ktx2;

use std::io::Read;

use crate::atlas::error::AtlasError;
use crate::atlas::texture::{Atlas, AtlasChannels, Layout, place};

/// No atlas file is longer, in bytes; a reader stops there.
const LONGEST: u64 = 64 << 20;

/// The bytes of a whole file.
fn read_all(input: impl Read) -> Result<Vec<u8>, AtlasError> {
    let mut bytes = Vec::new();
    input.take(LONGEST).read_to_end(&mut bytes)?;
    Ok(bytes)
}

impl AtlasError {
    fn damaged(why: impl Into<String>) -> Self {
        Self::Damaged { why: why.into() }
    }

    fn unsupported(why: impl Into<String>) -> Self {
        Self::Unsupported { why: why.into() }
    }
}

/// The atlas of a file that stored every level; `levels[k]` has the length of level k.
///
/// # Errors
/// [`AtlasError::Damaged`] if a texel cannot be a bandwidth or a level is not the maximum of the one before.
fn atlas_of_levels(layout: Layout, channels: AtlasChannels, levels: Vec<Vec<f32>>) -> Result<Atlas, AtlasError> {
    let mut stored = levels.into_iter();
    let level0 = stored.next().unwrap_or_default();
    let atlas = Atlas::from_level0(layout, channels, level0).map_err(|error| match error {
        AtlasError::Texels { why } => AtlasError::damaged(why),
        other => other,
    })?;
    for (k, (texels, level)) in (1..).zip(stored.zip(&atlas.levels()[1..])) {
        if let Some(at) = texels.iter().zip(level.texels()).position(|(a, b)| a != b) {
            let (stored, right) = (texels[at], level.texels()[at]);
            let place = place(k, level, channels, at);
            return Err(AtlasError::damaged(format!(
                "{place} is {stored} where the maximum of level {} is {right}",
                k - 1
            )));
        }
    }
    Ok(atlas)
}
