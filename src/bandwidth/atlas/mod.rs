//! The atlas: texture, levels, look-ups, files.

pub(crate) mod compute;
pub(crate) mod error;
pub mod exr;
pub(crate) mod f16_round_up;
pub mod ktx2;
pub(crate) mod sampling;
pub(crate) mod shader;
pub mod sidecar;
pub(crate) mod texture;
