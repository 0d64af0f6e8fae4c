//! Surfaces in closed form that tests of passes render.

use crate::Vec3;
use crate::geometry::gbuffer::{BACKGROUND, GBuffer};

/// The unit sphere around the origin of material 0, seen along -x from `distance`, filling most of a square image.
pub(crate) fn sphere(size: usize, distance: f32) -> GBuffer {
    let tan_half = 1.1 / (distance * distance - 1.0).sqrt();
    let eye = Vec3::new(distance, 0.0, 0.0);
    let axes = [Vec3::y(), -Vec3::z()];
    let pixel_angle = 2.0 * tan_half / size as f32;
    let mut gbuffer = GBuffer { width: size, height: size, pixel_angle, eye, axes, ..GBuffer::default() };
    for pixel in 0..size * size {
        let place = |n: usize| ((n as f32 + 0.5) / size as f32 * 2.0 - 1.0) * tan_half;
        let ray = Vec3::new(-1.0, place(pixel % size), -place(pixel / size)).normalize();
        let along = -eye.dot(&ray);
        let inside = along * along - (distance * distance - 1.0);
        let hit = inside > 0.0;
        let depth = if hit { along - inside.sqrt() } else { f32::INFINITY };
        let position = if hit { eye + ray * depth } else { Vec3::zeros() };
        let view = -ray;
        gbuffer.position.push(position);
        gbuffer.view.push(view);
        gbuffer.normal.push(if hit { facing(position, view) } else { Vec3::zeros() });
        gbuffer.depth.push(depth);
        gbuffer.material.push(if hit { 0 } else { BACKGROUND });
        gbuffer.uv.push([0.0; 2]);
        gbuffer.albedo.push(if hit { [1.0; 3] } else { [0.0; 3] });
    }
    gbuffer
}

/// The normal, moved to a cosine of 0.01 with the view where it is below.
fn facing(normal: Vec3, view: Vec3) -> Vec3 {
    let cos = normal.dot(&view);
    if cos >= 0.01 { normal } else { (normal + view * (0.01 - cos)).normalize() }
}
