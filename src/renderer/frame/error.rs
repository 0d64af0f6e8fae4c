//! Errors of rendering a frame.

use crate::frame::options::OptionsError;

/// Errors of rendering a frame.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum FrameError {
    /// The G-buffer counts a material that is not there.
    #[error(
        "pixel {pixel} has material index {material}, materials: {materials}; give one for each index of the G-buffer"
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
