//! What each pixel sees and how it changes; mappings of the sphere; sample points.

pub(crate) mod differentials;
pub(crate) mod gbuffer;
pub mod octahedral;
pub mod sobol;
pub(crate) mod spherical_rectangle;
pub(crate) mod vec3;
