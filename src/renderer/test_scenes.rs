//! Surfaces in closed form that tests of passes render.

use crate::geometry::gbuffer::{BACKGROUND, GBuffer, Surfaces, Viewpoint};
use crate::geometry::vec3::Vec3;

/// The unit sphere around the origin of material 0, seen along -x from `distance`, filling most of a square image.
pub(crate) fn sphere(size: usize, distance: f32) -> GBuffer {
    let tan_half = 1.1 / (distance * distance - 1.0).sqrt();
    let eye = Vec3::new(distance, 0.0, 0.0);
    let viewpoint = Viewpoint { eye, axes: [Vec3::y(), -Vec3::z()], pixel_angle: 2.0 * tan_half / size as f32 };
    let mut surfaces = Surfaces::default();
    for pixel in 0..size * size {
        let place = |n: usize| ((n as f32 + 0.5) / size as f32 * 2.0 - 1.0) * tan_half;
        let ray = Vec3::new(-1.0, place(pixel % size), -place(pixel / size)).normalize();
        let along = -eye.dot(&ray);
        let inside = along * along - (distance * distance - 1.0);
        let hit = inside > 0.0;
        let depth = if hit { along - inside.sqrt() } else { f32::INFINITY };
        let position = if hit { eye + ray * depth } else { Vec3::zeros() };
        let view = -ray;
        surfaces.position.push(position);
        surfaces.view.push(view);
        surfaces.normal.push(if hit { facing(position, view) } else { Vec3::zeros() });
        surfaces.depth.push(depth);
        surfaces.material.push(if hit { 0 } else { BACKGROUND });
        surfaces.uv.push([0.0; 2]);
        surfaces.albedo.push(if hit { [1.0; 3] } else { [0.0; 3] });
    }
    GBuffer::new(size, size, viewpoint, surfaces).expect("arrays of one length")
}

/// The plane z = 0 of material 0, seen from far above: pixel (x, y) is the point (x + 0.5, -(y + 0.5), 0) in steps of `step`, and all
/// views are +z.
pub(crate) fn plane(width: usize, height: usize, step: f32) -> GBuffer {
    let pixels = width * height;
    let depth = 1000.0;
    let position =
        (0..pixels).map(|n| Vec3::new((n % width) as f32 + 0.5, -((n / width) as f32 + 0.5), 0.0) * step).collect();
    let surfaces = Surfaces {
        position,
        normal: vec![Vec3::z(); pixels],
        view: vec![Vec3::z(); pixels],
        depth: vec![depth; pixels],
        material: vec![0; pixels],
        uv: vec![[0.0; 2]; pixels],
        albedo: vec![[1.0; 3]; pixels],
    };
    let viewpoint = Viewpoint { eye: Vec3::z() * depth, axes: [Vec3::x(), -Vec3::y()], pixel_angle: step / depth };
    GBuffer::new(width, height, viewpoint, surfaces).expect("arrays of one length")
}

/// The normal, moved to a cosine of 0.01 with the view where it is below.
fn facing(normal: Vec3, view: Vec3) -> Vec3 {
    let cos = normal.dot(&view);
    if cos >= 0.01 { normal } else { (normal + view * (0.01 - cos)).normalize() }
}
