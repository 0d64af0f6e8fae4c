//! Lights: texels, look-ups, sampling, bandwidth, files.

pub(crate) mod alias_table;
pub(crate) mod bandwidth;
pub(crate) mod environment_map;
pub(crate) mod error;
pub(crate) mod from_document;
pub(crate) mod light_batch;
pub(crate) mod light_level;
pub(crate) mod octahedral_light;
pub(crate) mod procedural;
