//! Placement of an object in the world.

use nalgebra::{Matrix3, Vector3};

use crate::geometry::vec3::Vec3;
use crate::scene::document::{ObjectDocument, UpAxis};

/// A similarity or, for the nodes of glTF, any affine map, with the matrix that keeps normals normal.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Placement {
    linear: Matrix3<f64>,
    offset: Vector3<f64>,
    /// The inverse transpose of `linear` up to a factor.
    normals: Matrix3<f64>,
}

impl Placement {
    /// The identity.
    pub(crate) fn identity() -> Self {
        Self { linear: Matrix3::identity(), offset: Vector3::zeros(), normals: Matrix3::identity() }
    }

    /// First `inner`, then this; `None` if that flattens space.
    pub(crate) fn after(&self, inner: &Self) -> Option<Self> {
        Self::affine(self.linear * inner.linear, self.linear * inner.offset + self.offset)
    }

    /// `x` goes to `linear x + offset`; `None` if that flattens space.
    pub(crate) fn affine(linear: Matrix3<f64>, offset: Vector3<f64>) -> Option<Self> {
        let [a, b, c] = [0, 1, 2].map(|column| linear.column(column).clone_owned());
        // the cofactors: inverse transpose times the determinant, whose sign keeps mirrored surfaces' normals on their side
        let determinant = a.cross(&b).dot(&c);
        let scale = a.norm() * b.norm() * c.norm();
        let sound = determinant.abs() > 1e-12 * scale && offset.iter().all(|x| x.is_finite());
        let normals = Matrix3::from_columns(&[b.cross(&c), c.cross(&a), a.cross(&b)]) * determinant.signum();
        sound.then_some(Self { linear, offset, normals })
    }

    /// That of an object, whose numbers have been checked: scaled, turned about x, y, z, moved.
    pub(crate) fn of_object(object: &ObjectDocument) -> Self {
        let [x, y, z] = object.rotate.map(|degrees| degrees.to_radians());
        let turn = |axis: usize, angle: f64| {
            let (sin, cos) = libm::sincos(angle);
            let (j, k) = ((axis + 1) % 3, (axis + 2) % 3);
            let mut m = Matrix3::identity();
            (m[(j, j)], m[(j, k)], m[(k, j)], m[(k, k)]) = (cos, -sin, sin, cos);
            m
        };
        let rotation = turn(2, z) * turn(1, y) * turn(0, x);
        Self { linear: rotation * object.scale, offset: Vector3::from(object.translate), normals: rotation }
    }

    /// From the axes of a file to those of the world.
    pub(crate) fn of_axes(up: UpAxis) -> Self {
        match up {
            UpAxis::Y => {
                let linear = Matrix3::new(1.0, 0.0, 0.0, 0.0, 0.0, -1.0, 0.0, 1.0, 0.0);
                Self { linear, offset: Vector3::zeros(), normals: linear }
            }
            UpAxis::Z => Self::identity(),
        }
    }

    pub(crate) fn point(&self, p: Vec3) -> Vec3 {
        (self.linear * p.cast::<f64>() + self.offset).cast()
    }

    /// Direction of the unit normal `n` in the world.
    pub(crate) fn direction(&self, n: Vec3) -> Vec3 {
        let n = self.normals * n.cast::<f64>();
        (n / n.norm()).cast()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::document::MeshDocument;

    fn object(rotate: [f64; 3], translate: [f64; 3], scale: f64) -> ObjectDocument {
        let mesh = MeshDocument::Sphere { radius: 1.0 };
        ObjectDocument { mesh, material: String::new(), scale, rotate, translate }
    }

    #[test]
    fn scale_then_turns_about_x_y_z_then_move() {
        // a quarter turn about x takes y to z, one about z then keeps it: y ends at z; x ends at y
        let placement = Placement::of_object(&object([90.0, 0.0, 90.0], [10.0, 20.0, 30.0], 2.0));
        for (from, to) in [(Vec3::x(), Vec3::y()), (Vec3::y(), Vec3::z()), (Vec3::z(), Vec3::x())] {
            assert!((placement.point(from) - (to * 2.0 + Vec3::new(10.0, 20.0, 30.0))).norm() < 1e-5);
            assert!((placement.direction(from) - to).norm() < 1e-6);
        }
    }

    #[test]
    fn normals_stay_normal_under_unequal_scales_and_mirrors() {
        let linear = Matrix3::new(2.0, 0.3, 0.0, 0.0, -0.5, 0.1, 0.2, 0.0, 3.0);
        let placement = Placement::affine(linear, Vector3::zeros()).unwrap();
        let (s, t) = (Vec3::new(1.0, 2.0, -1.0), Vec3::new(0.5, -1.0, 2.0));
        let n = placement.direction(s.cross(&t).normalize());
        assert!(n.dot(&placement.point(s)).abs() < 1e-5 && n.dot(&placement.point(t)).abs() < 1e-5);
        // the side: a point on the front stays on the front
        assert!(n.dot(&placement.point(s.cross(&t))) > 0.0);
        assert!(
            Placement::affine(Matrix3::new(1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0), Vector3::zeros()).is_none()
        );
        assert!(Placement::affine(Matrix3::identity() * f64::NAN, Vector3::zeros()).is_none());
    }

    #[test]
    fn the_up_axis_of_a_file_becomes_z() {
        let placement = Placement::of_axes(UpAxis::Y);
        assert_eq!(placement.point(Vec3::new(1.0, 2.0, 3.0)), Vec3::new(1.0, -3.0, 2.0));
        assert_eq!(Placement::of_axes(UpAxis::Z).point(Vec3::new(1.0, 2.0, 3.0)), Vec3::new(1.0, 2.0, 3.0));
    }
}
