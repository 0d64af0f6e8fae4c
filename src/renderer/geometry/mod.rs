//! G-buffers and their differentials, mappings of the sphere, sample points.

pub(crate) mod differentials;
pub(crate) mod gbuffer;
pub(crate) mod grazing;
pub mod octahedral;
pub mod sobol;
pub(crate) mod spherical_rectangle;
pub(crate) mod vec3;
