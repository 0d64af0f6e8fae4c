//! Lights: texels, look-ups, sampling, bandwidth, files.

pub(crate) mod bandwidth;
pub(crate) mod document;
pub(crate) mod environment;
pub(crate) mod environment_map;
pub(crate) mod error;
pub(crate) mod light_set;
pub(crate) mod lighting;
pub(crate) mod octahedral;
pub(crate) mod procedural;
pub(crate) mod rectangle;
