//! The G-buffer: the visible surface at each pixel.

use crate::geometry::vec3::Vec3;

/// The material index of pixels that show no surface.
pub const BACKGROUND: u16 = u16::MAX;

/// Most columns and rows of a [`GBuffer`]: cells are counted in 16 bits.
const LARGEST_SIDE: usize = 1 << 16;
/// Most pixels of a [`GBuffer`]: pixels are counted in 32 bits, the last number is free.
const MOST_PIXELS: usize = u32::MAX as usize;

/// The visible surface at the centre of each pixel, row-major from the top left corner, one array per quantity as in the textures of
/// a deferred renderer.
#[derive(Clone, Debug, PartialEq)]
pub struct GBuffer {
    pub(crate) width: usize,
    pub(crate) height: usize,
    pub(crate) pixel_angle: f32,
    pub(crate) eye: Vec3,
    pub(crate) axes: [Vec3; 2],
    pub(crate) position: Vec<Vec3>,
    pub(crate) normal: Vec<Vec3>,
    pub(crate) view: Vec<Vec3>,
    pub(crate) depth: Vec<f32>,
    pub(crate) material: Vec<u16>,
    pub(crate) uv: Vec<[f32; 2]>,
    pub(crate) albedo: Vec<[f32; 3]>,
}

/// From where the surfaces of a [`GBuffer`] are seen.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Viewpoint {
    /// World units.
    pub eye: Vec3,
    /// Unit vectors of the world along which columns and rows grow.
    pub axes: [Vec3; 2],
    /// Angle of a pixel at the centre of the image, `2 tan(fov_y / 2) / height`, radians.
    pub pixel_angle: f32,
}

/// The arrays of a [`GBuffer`], one entry per pixel. Pixels of the background hold [`BACKGROUND`] as material, a view, an infinite
/// depth, and zeros.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Surfaces {
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
    /// Factor of the BRDF per channel: the material's texture or 1.
    pub albedo: Vec<[f32; 3]>,
}

/// Errors of building a [`GBuffer`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum GBufferError {
    /// An image without pixels, or with more than can be counted.
    #[error(
        "{width} x {height} pixels; a G-buffer has 1 to {LARGEST_SIDE} columns and rows and at most {MOST_PIXELS} pixels"
    )]
    Size {
        /// Columns.
        width: usize,
        /// Rows.
        height: usize,
    },
    /// An array of another length.
    #[error("{found} entries of {array} for {expected} pixels")]
    Length {
        /// Field of [`Surfaces`].
        array: &'static str,
        /// Its entries.
        found: usize,
        /// Pixels.
        expected: usize,
    },
}

impl GBuffer {
    /// The G-buffer of these arrays. Indices of materials are checked where materials are known:
    /// [`FrameInput::new`](crate::FrameInput::new).
    ///
    /// # Errors
    /// [`GBufferError`] if the size is outside of its limits or an array has another length.
    pub fn new(
        width: usize,
        height: usize,
        viewpoint: Viewpoint,
        surfaces: Surfaces,
    ) -> std::result::Result<Self, GBufferError> {
        let side = 1..=LARGEST_SIDE;
        if !side.contains(&width) || !side.contains(&height) || width * height > MOST_PIXELS {
            return Err(GBufferError::Size { width, height });
        }
        let Viewpoint { eye, axes, pixel_angle } = viewpoint;
        let Surfaces { position, normal, view, depth, material, uv, albedo } = surfaces;
        let expected = width * height;
        for (array, found) in [
            ("position", position.len()),
            ("normal", normal.len()),
            ("view", view.len()),
            ("depth", depth.len()),
            ("material", material.len()),
            ("uv", uv.len()),
            ("albedo", albedo.len()),
        ] {
            if found != expected {
                return Err(GBufferError::Length { array, found, expected });
            }
        }
        Ok(Self { width, height, pixel_angle, eye, axes, position, normal, view, depth, material, uv, albedo })
    }

    /// Columns and rows.
    #[must_use]
    pub fn size(&self) -> [usize; 2] {
        [self.width, self.height]
    }

    /// Position of the eye, world units.
    #[must_use]
    pub fn eye(&self) -> Vec3 {
        self.eye
    }

    /// Angle of a pixel at the centre of the image, `2 tan(fov_y / 2) / height`, radians.
    #[must_use]
    pub fn pixel_angle(&self) -> f32 {
        self.pixel_angle
    }

    /// Index of the material of each pixel, or [`BACKGROUND`].
    #[must_use]
    pub fn material(&self) -> &[u16] {
        &self.material
    }

    /// Unit vector to the eye at each pixel.
    #[must_use]
    pub fn view(&self) -> &[Vec3] {
        &self.view
    }

    /// Point on the surface at each pixel, world units; zero in the background.
    #[must_use]
    pub fn position(&self) -> &[Vec3] {
        &self.position
    }

    /// Unit normal at each pixel, on the side of the surface that the eye sees; zero in the background.
    #[must_use]
    pub fn normal(&self) -> &[Vec3] {
        &self.normal
    }

    /// Texture coordinates at each pixel.
    #[must_use]
    pub fn uv(&self) -> &[[f32; 2]] {
        &self.uv
    }

    /// Distance to the eye at each pixel, world units; infinite in the background.
    #[must_use]
    pub fn depth(&self) -> &[f32] {
        &self.depth
    }

    /// Factor of the BRDF at each pixel, per channel.
    #[must_use]
    pub fn albedo(&self) -> &[[f32; 3]] {
        &self.albedo
    }

    /// The pixels that show a surface.
    #[must_use]
    pub fn foreground(&self) -> Vec<bool> {
        self.material.iter().map(|&material| material != BACKGROUND).collect()
    }

    /// The view of a pixel mirrored at its normal, `2 (n.v) n - v`, unit length.
    pub(crate) fn mirror_direction(&self, pixel: usize) -> Vec3 {
        let (n, v) = (&self.normal[pixel], &self.view[pixel]);
        n * (2.0 * n.dot(v)) - v
    }

    /// Column and row of a pixel.
    #[inline]
    pub(crate) fn place(&self, pixel: usize) -> [usize; 2] {
        [pixel % self.width, pixel / self.width]
    }

    /// The pixels of surfaces in a square block, in row order, each with the square of twice its distance from the block's centre.
    pub(crate) fn surfaces_in_block(
        &self,
        [left, top]: [usize; 2],
        side: usize,
    ) -> impl Iterator<Item = (usize, usize)> {
        let off = move |at: usize, first: usize| (2 * (at - first)).abs_diff(side - 1).pow(2);
        (top..(top + side).min(self.height)).flat_map(move |y| {
            (left..(left + side).min(self.width))
                .map(move |x| (y * self.width + x, off(x, left) + off(y, top)))
                .filter(|&(pixel, _)| self.material[pixel] != BACKGROUND)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_scenes::sphere;

    fn surfaces(pixels: usize) -> Surfaces {
        Surfaces {
            position: vec![Vec3::zeros(); pixels],
            normal: vec![Vec3::z(); pixels],
            view: vec![Vec3::z(); pixels],
            depth: vec![1.0; pixels],
            material: vec![0; pixels],
            uv: vec![[0.0; 2]; pixels],
            albedo: vec![[1.0; 3]; pixels],
        }
    }

    const VIEWPOINT: Viewpoint = Viewpoint {
        eye: Vec3::new(0.0, 0.0, 1.0),
        axes: [Vec3::new(1.0, 0.0, 0.0), Vec3::new(0.0, -1.0, 0.0)],
        pixel_angle: 0.01,
    };

    #[test]
    fn sizes_that_cannot_be_counted_are_refused() {
        for [width, height] in [[0, 0], [0, 5], [5, 0], [65_537, 1], [1, 65_537], [65_536, 65_536], [usize::MAX, 2]] {
            let refused = GBuffer::new(width, height, VIEWPOINT, Surfaces::default());
            assert_eq!(refused, Err(GBufferError::Size { width, height }));
        }
        assert!(GBuffer::new(65_536, 1, VIEWPOINT, surfaces(65_536)).is_ok());
    }

    #[test]
    fn every_array_has_an_entry_per_pixel() {
        let short = Surfaces { uv: vec![[0.0; 2]; 5], ..surfaces(6) };
        let refused = GBuffer::new(3, 2, VIEWPOINT, short);
        assert_eq!(refused, Err(GBufferError::Length { array: "uv", found: 5, expected: 6 }));
        assert_eq!(GBuffer::new(3, 2, VIEWPOINT, surfaces(6)).unwrap().size(), [3, 2]);
    }

    #[test]
    fn blocks_are_measured_from_their_centre_and_cut_at_the_border() {
        let mut gbuffer = sphere(7, 4.0);
        gbuffer.material.fill(0);
        gbuffer.material[5 * 7 + 5] = BACKGROUND;
        // the block of 4 x 4 pixels from (4, 4) has the centre (5.5, 5.5); three columns and rows of it exist
        let found: Vec<(usize, usize)> = gbuffer.surfaces_in_block([4, 4], 4).collect();
        let all = [(4, 4, 18), (5, 4, 10), (6, 4, 10), (4, 5, 10), (6, 5, 2), (4, 6, 10), (5, 6, 2), (6, 6, 2)];
        assert_eq!(found, all.map(|(x, y, distance)| (y * 7 + x, distance)));
    }
}
