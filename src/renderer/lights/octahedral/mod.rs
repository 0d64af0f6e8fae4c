//! A light at infinite distance as an octahedral image: texels with their averages, look-ups, draws.

pub(crate) mod alias_table;
mod batch;
pub(crate) mod level;
pub(crate) mod light;
