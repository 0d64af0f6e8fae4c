//! What is visible at each pixel.

use crate::Vec3;

/// The material index of pixels that show no surface.
pub const BACKGROUND: u16 = u16::MAX;

/// The visible surface at the centre of each pixel, row-major from the top left corner, one array per quantity as in the textures of
/// a deferred renderer. Pixels of the background hold [`BACKGROUND`] as material, a view, an infinite depth, and zeros.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct GBuffer {
    /// Columns.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// Angle of a pixel at the centre of the image, `2 tan(fov_y / 2) / height`, radians.
    pub pixel_angle: f32,
    /// Where the image is seen from, world units.
    pub eye: Vec3,
    /// Unit vectors of the world along which columns and rows grow.
    pub axes: [Vec3; 2],
    /// Point on the surface, world units.
    pub position: Vec<Vec3>,
    /// Interpolated unit normal, on the side of the surface that the eye sees; at least 0.01 in the direction of the eye.
    pub normal: Vec<Vec3>,
    /// Unit vector to the eye.
    pub view: Vec<Vec3>,
    /// Distance to the eye, world units.
    pub depth: Vec<f32>,
    /// Index of the material, or [`BACKGROUND`].
    pub material: Vec<u16>,
    /// Texture coordinates.
    pub uv: Vec<[f32; 2]>,
    /// What the whole BRDF is multiplied by, per channel: the material's texture or 1.
    pub albedo: Vec<[f32; 3]>,
}

impl GBuffer {
    /// The view of a pixel mirrored at its normal, `2 (n.v) n - v`, unit length.
    pub(crate) fn mirror_direction(&self, pixel: usize) -> Vec3 {
        let (n, v) = (&self.normal[pixel], &self.view[pixel]);
        n * (2.0 * n.dot(v)) - v
    }
}
