//! Why a frame cannot be rendered.

use crate::frame::options::OptionsError;

/// Why a frame cannot be rendered.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum FrameError {
    /// The G-buffer counts a material that is not there.
    #[error(
        "pixel {pixel} has material {material}, and there are {materials}; give one for each index of the G-buffer"
    )]
    NoMaterial {
        /// The first such pixel, row-major.
        pixel: usize,
        /// Its index.
        material: u16,
        /// Number of materials.
        materials: usize,
    },
    /// Options that cannot be used.
    #[error(transparent)]
    Options(#[from] OptionsError),
}
