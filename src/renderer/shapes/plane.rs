//! The square.

use nalgebra::Vector3;

use crate::shapes::mesh::Mesh;
use crate::shapes::patch::Patch;

/// A square of side `size` around the origin in the x-y plane, its front at +z.
pub(crate) fn plane(size: f64) -> Mesh {
    let patch = Patch { columns: 1, rows: 1, closed_u: false, closed_v: false };
    patch.mesh(|u, v| (Vector3::new(u - 0.5, v - 0.5, 0.0) * size, Vector3::z()))
}
