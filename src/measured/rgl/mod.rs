//! The RGL tensor files of isotropic materials (Dupuy & Jakob 2018): container, tables, the BRDF that they describe.

pub(crate) mod batch;
pub(crate) mod brdf;
pub(crate) mod container;
pub(crate) mod measurement;
pub(crate) mod tables;
pub(crate) mod warp;
