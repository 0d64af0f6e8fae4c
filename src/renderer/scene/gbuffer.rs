//! The G-buffer of a scene.

use rayon::prelude::*;

use crate::geometry::gbuffer::{BACKGROUND, GBuffer, Surfaces, Viewpoint};
use crate::geometry::grazing::LEAST_COSINE;
use crate::geometry::vec3::Vec3;
use crate::scene::Scene;
use crate::shapes::intersection::Ray;

/// One pixel of a [`GBuffer`].
struct Surface {
    position: Vec3,
    normal: Vec3,
    view: Vec3,
    depth: f32,
    material: u16,
    uv: [f32; 2],
    albedo: [f32; 3],
}

impl Scene {
    /// What is visible at the centre of each pixel; one that shows a light at a finite distance counts as background. Rows are spread over the threads of the current pool; the result is the same for
    /// every number of them.
    #[must_use]
    pub fn gbuffer(&self) -> GBuffer {
        let (width, height) = (self.camera.width, self.camera.height);
        let pixels = width * height;
        let mut buffers = Surfaces {
            position: vec![Vec3::zeros(); pixels],
            normal: vec![Vec3::zeros(); pixels],
            view: vec![Vec3::zeros(); pixels],
            depth: vec![f32::INFINITY; pixels],
            material: vec![BACKGROUND; pixels],
            uv: vec![[0.0; 2]; pixels],
            albedo: vec![[0.0; 3]; pixels],
        };
        let rows = (
            buffers.position.par_chunks_mut(width),
            buffers.normal.par_chunks_mut(width),
            buffers.view.par_chunks_mut(width),
            buffers.depth.par_chunks_mut(width),
            buffers.material.par_chunks_mut(width),
            buffers.uv.par_chunks_mut(width),
            buffers.albedo.par_chunks_mut(width),
        );
        rows.into_par_iter().enumerate().for_each_init(
            Vec::new,
            |waiting, (y, (position, normal, view, depth, material, uv, albedo))| {
                for x in 0..width {
                    let Some(surface) = self.surface(x, y, waiting) else {
                        view[x] = -self.camera.direction(x as f64 + 0.5, y as f64 + 0.5);
                        continue;
                    };
                    position[x] = surface.position;
                    normal[x] = surface.normal;
                    view[x] = surface.view;
                    depth[x] = surface.depth;
                    material[x] = surface.material;
                    uv[x] = surface.uv;
                    albedo[x] = surface.albedo;
                }
            },
        );
        let viewpoint =
            Viewpoint { eye: self.camera.eye, axes: self.camera.axes(), pixel_angle: self.camera.pixel_angle };
        GBuffer::new(width, height, viewpoint, buffers).expect("the size of the image has been checked")
    }

    /// The surface at the centre of a pixel.
    fn surface(&self, x: usize, y: usize, waiting: &mut Vec<(usize, f32)>) -> Option<Surface> {
        let direction = self.camera.direction(x as f64 + 0.5, y as f64 + 0.5);
        let ray = Ray::new(self.camera.eye, direction);
        let (triangle, hit) = self.visibility.first(&self.mesh, &ray, waiting)?;
        let corners = self.mesh.triangles[triangle].map(|vertex| vertex as usize);
        let mix = |values: &[Vec3]| {
            let [a, b, c] = corners.map(|vertex| values[vertex]);
            a * hit.weights[0] + b * hit.weights[1] + c * hit.weights[2]
        };
        let position = mix(&self.mesh.positions);
        let to_eye = self.camera.eye - position;
        let depth = to_eye.norm();
        if self.near_lights.nearest(self.camera.eye, direction).is_some_and(|light| light.distance < depth) {
            return None;
        }
        let view = to_eye / depth;
        let uv =
            std::array::from_fn(|k| (0..3).map(|corner| self.mesh.uv[corners[corner]][k] * hit.weights[corner]).sum());
        let material = self.triangle_materials[triangle];
        Some(Surface {
            position,
            normal: seen_normal(mix(&self.mesh.normals), corners.map(|vertex| self.mesh.positions[vertex]), view),
            view,
            depth,
            material,
            uv,
            albedo: self.albedo[usize::from(material)].at(uv),
        })
    }
}

/// The interpolated normal as a unit vector, on the side of the triangle that the eye sees, and turned towards the eye where it is closer to
/// perpendicular than [`LEAST_COSINE`] or turned away.
fn seen_normal(interpolated: Vec3, [a, b, c]: [Vec3; 3], view: Vec3) -> Vec3 {
    let geometric = (b - a).cross(&(c - a)).try_normalize(0.0).unwrap_or(view);
    let geometric = if geometric.dot(&view) < 0.0 { -geometric } else { geometric };
    let normal = interpolated.try_normalize(1e-6).unwrap_or(geometric);
    let normal = if normal.dot(&geometric) < 0.0 { -normal } else { normal };
    if normal.dot(&view) >= LEAST_COSINE {
        return normal;
    }
    // in double precision: a normal that nearly points away leaves few digits
    let (normal, view, cos) = (normal.cast::<f64>(), view.cast::<f64>(), f64::from(LEAST_COSINE));
    let across = (normal - view * (normal.dot(&view) / view.norm_squared())).try_normalize(1e-6);
    across.map_or(view, |across| view * cos + across * (1.0 - cos * cos).sqrt()).cast()
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;
    use crate::scene::document::SceneDocument;
    use crate::shapes::sphere::DisplacedSphere;

    #[test]
    fn curvature_from_neighbouring_normals_is_that_of_the_surface() {
        for (shape, limit) in [
            (DisplacedSphere { radius: 1.0, amplitude: 0.08, frequency: 4.0, octaves: 1, seed: 0 }, 0.05),
            (DisplacedSphere { radius: 1.0, amplitude: 0.4, frequency: 1.2, octaves: 1, seed: 0 }, 0.03),
        ] {
            let DisplacedSphere { amplitude, frequency, .. } = shape;
            let json = format!(
                r#"{{ "camera": {{ "eye": [0.5, -3.5, 1.5], "target": [0, 0, 0], "vertical_fov": 40, "width": 512, "height": 512 }},
                    "light": {{ "procedural": {{ "kind": "uniform" }} }},
                    "materials": {{ "grey": {{ "source": {{ "lambert": [0.5, 0.5, 0.5] }} }} }},
                    "objects": [{{ "material": "grey", "mesh": {{ "displaced_sphere":
                        {{ "amplitude": {amplitude}, "frequency": {frequency} }} }} }}] }}"#
            );
            let seen = Scene::load(&SceneDocument::read(json.as_bytes()).unwrap(), Path::new(".")).unwrap().gbuffer();
            let exact = |pixel: usize| shape.surface(seen.position[pixel].cast::<f64>().normalize()).1;
            let facing = |pixel: usize| seen.material[pixel] == 0 && seen.normal[pixel].dot(&seen.view[pixel]) > 0.3;
            let (mut error, mut total, mut worst) = (0.0, 0.0, 0.0f64);
            for at in (0..512 * 512 - 512).filter(|at| at % 512 != 511) {
                for next in [at + 1, at + 512] {
                    let step = (seen.depth[at] - seen.depth[next]).abs();
                    if facing(at) && facing(next) && step < 0.05 {
                        let [a, b] = [at, next].map(|pixel| seen.normal[pixel].cast::<f64>());
                        let change = exact(next) - exact(at);
                        error += (b - a - change).norm_squared();
                        total += change.norm_squared();
                        worst = worst.max((a - exact(at)).norm());
                    }
                }
            }
            let relative = (error / total).sqrt();
            assert!(relative < limit && worst < 0.01, "{shape:?}: {relative} {worst}");
        }
    }

    #[test]
    fn the_normal_is_on_the_side_of_the_eye() {
        let triangle = [Vec3::zeros(), Vec3::x(), Vec3::y()];
        let n = Vec3::new(0.3, 0.0, 2.0);
        let above = Vec3::new(0.6, 0.0, 0.8);
        assert!((seen_normal(n, triangle, above) - n.normalize()).norm() < 1e-6);
        assert!((seen_normal(n, triangle, -above) + n.normalize()).norm() < 1e-6);
        // a triangle that runs the other way round than its normals say
        assert!((seen_normal(-n, triangle, above) - n.normalize()).norm() < 1e-6);
        // opposed normals at the corners leave that of the triangle
        assert_eq!(seen_normal(Vec3::zeros(), triangle, above), Vec3::z());
    }

    #[test]
    fn grazing_normals_are_turned_to_the_eye() {
        let triangle = [Vec3::zeros(), Vec3::x(), Vec3::y()];
        let view = Vec3::new(1.0, 0.0, 0.001).normalize();
        for n in [Vec3::new(-0.2, 0.3, 0.9), Vec3::new(0.0, 0.0, 1.0), Vec3::new(-1.0, 0.0, 0.01)] {
            let seen = seen_normal(n, triangle, view);
            assert!((seen.norm() - 1.0).abs() < 1e-6 && (seen.dot(&view) - LEAST_COSINE).abs() < 1e-6);
            // it stays in the plane of the normal and the view
            assert!(seen.dot(&n.cross(&view)).abs() < 1e-6 && seen.dot(&n) > 0.0);
        }
    }
}
