//! The pinhole camera.

use nalgebra::Vector3;

use crate::geometry::vec3::Vec3;
use crate::scene::document::CameraDocument;

/// Ray directions of pixels: pixel (x, y) is the direction through its centre, row 0 at the top.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    /// Columns.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// Position of the eye, world units.
    pub eye: Vec3,
    /// Angle of a pixel at the centre of the image, `2 tan(fov_y / 2) / height`, radians.
    pub pixel_angle: f32,
    /// The view, one pixel to the right and one pixel down, for a view of length 1.
    forward: Vector3<f64>,
    right: Vector3<f64>,
    down: Vector3<f64>,
}

impl Camera {
    /// The camera of a document that has been checked.
    pub(crate) fn new(document: &CameraDocument) -> Self {
        let CameraDocument { eye, target, up, vertical_fov, width, height } = document;
        let eye = Vector3::from(*eye);
        let forward = (Vector3::from(*target) - eye).normalize();
        let right = forward.cross(&Vector3::from(*up).normalize()).normalize();
        let pixel_angle = 2.0 * libm::tan(vertical_fov.to_radians() / 2.0) / *height as f64;
        Self {
            width: *width,
            height: *height,
            eye: eye.cast(),
            pixel_angle: pixel_angle as f32,
            forward,
            right: right * pixel_angle,
            down: forward.cross(&right) * pixel_angle,
        }
    }

    /// Unit vectors of the world along which columns and rows grow.
    #[must_use]
    pub fn axes(&self) -> [Vec3; 2] {
        [self.right, self.down].map(|axis| axis.normalize().cast())
    }

    /// The unit direction from the eye through the point (x, y) of the image, in pixels from its upper left corner.
    #[must_use]
    pub fn direction(&self, x: f64, y: f64) -> Vec3 {
        let (x, y) = (x - self.width as f64 / 2.0, y - self.height as f64 / 2.0);
        (self.forward + self.right * x + self.down * y).normalize().cast()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_corners_of_the_image() {
        // from -x towards the origin: right is -y, up is z; 90 degrees: half the height is as far away as the image
        let camera = Camera::new(&CameraDocument {
            eye: [-2.0, 0.0, 0.0],
            target: [0.0; 3],
            up: [0.3, 0.0, 2.0],
            vertical_fov: 90.0,
            width: 20,
            height: 10,
        });
        assert!((camera.pixel_angle - 0.2).abs() < 1e-7);
        for (x, y, to) in [
            (10.0, 5.0, [1.0, 0.0, 0.0]),
            (20.0, 5.0, [1.0, -2.0, 0.0]),
            (0.0, 0.0, [1.0, 2.0, 1.0]),
            (10.0, 10.0, [1.0, 0.0, -1.0]),
        ] {
            assert!((camera.direction(x, y) - Vec3::from(to).normalize()).norm() < 1e-6, "{x} {y}");
        }
    }
}
