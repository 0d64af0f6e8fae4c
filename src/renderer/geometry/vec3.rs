//! Points and directions of the world.

/// Points and directions of the world, single precision.
pub type Vec3 = nalgebra::Vector3<f32>;
