//! Meshes, built-in shapes, rays, the camera.

pub(crate) mod camera;
pub(crate) mod gltf;
pub(crate) mod gradient_noise;
pub(crate) mod intersection;
pub(crate) mod mesh;
pub(crate) mod obj;
pub(crate) mod patch;
pub(crate) mod placement;
pub(crate) mod plane;
pub(crate) mod sphere;
pub(crate) mod torus;
pub(crate) mod visible_surfaces;
