//! Lights: texels, look-ups, sampling, bandwidth, files.

pub(crate) mod alias_table;
pub(crate) mod bandwidth;
pub(crate) mod document;
pub(crate) mod environment;
pub(crate) mod environment_map;
pub(crate) mod error;
pub(crate) mod light_batch;
pub(crate) mod light_level;
pub(crate) mod light_set;
pub(crate) mod lighting;
pub(crate) mod octahedral_light;
pub(crate) mod procedural;
pub(crate) mod rectangle;
