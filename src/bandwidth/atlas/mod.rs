//! The atlas: texture, levels, look-ups, document.

pub(crate) mod compute;
pub(crate) mod error;
pub(crate) mod f16_round_up;
pub(crate) mod sampling;
pub(crate) mod shader;
pub mod sidecar;
pub(crate) mod texture;
