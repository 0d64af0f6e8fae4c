//! The sphere and the displaced sphere.

use std::f64::consts::{PI, TAU};

use nalgebra::Vector3;

use crate::shapes::gradient_noise::GradientNoise;
use crate::shapes::mesh::Mesh;
use crate::shapes::patch::Patch;

/// Cells of the sphere along u and v: 0.7 degrees. Interpolated normals are exact on a sphere, whatever its quads.
const SPHERE_ROWS: usize = 256;
/// Cells from pole to pole of a displaced sphere per unit of the finest frequency, and the limits of their number.
const ROWS_PER_FREQUENCY: f64 = 64.0;
const DISPLACED_ROWS: (f64, f64) = (256.0, 768.0);

/// A sphere around the origin, its poles at -z (v = 0) and +z.
pub(crate) fn sphere(radius: f64) -> Mesh {
    patch(SPHERE_ROWS).mesh(|u, v| {
        let direction = direction(u, v);
        (direction * radius, direction)
    })
}

/// A sphere whose radius in direction d is `radius (1 + amplitude n(d))`, n the sum of octaves of noise in -1..1.
#[derive(Clone, Copy, Debug)]
pub(crate) struct DisplacedSphere {
    pub(crate) radius: f64,
    pub(crate) amplitude: f64,
    pub(crate) frequency: f64,
    pub(crate) octaves: u32,
    pub(crate) seed: u32,
}

impl DisplacedSphere {
    pub(crate) fn mesh(&self) -> Mesh {
        let finest = self.frequency * f64::from(1u32 << (self.octaves - 1));
        let rows = (ROWS_PER_FREQUENCY * finest).clamp(DISPLACED_ROWS.0, DISPLACED_ROWS.1);
        patch(rows as usize).mesh(|u, v| self.surface(direction(u, v)))
    }

    /// Position and unit normal in the direction `d`. The normal of r(d) d is along `r d - grad r`, the gradient that along the sphere.
    pub(crate) fn surface(&self, d: Vector3<f64>) -> (Vector3<f64>, Vector3<f64>) {
        let (mut value, mut gradient) = (0.0, Vector3::zeros());
        let (mut gain, mut frequency, mut total) = (1.0, self.frequency, 0.0);
        for octave in 0..self.octaves {
            let noise = GradientNoise::new(self.seed.wrapping_mul(8).wrapping_add(octave));
            let (n, slope) = noise.at(d * frequency);
            value += gain * n;
            gradient += slope * (gain * frequency);
            total += gain;
            (gain, frequency) = (gain / 2.0, frequency * 2.0);
        }
        let amplitude = self.amplitude / total;
        let r = 1.0 + amplitude * value;
        let along = (gradient - d * d.dot(&gradient)) * amplitude;
        (d * (r * self.radius), (d * r - along).normalize())
    }
}

fn patch(rows: usize) -> Patch {
    Patch { columns: 2 * rows, rows, closed_u: true, closed_v: false }
}

/// The direction of azimuth 2 pi u, v from pole to pole; the poles are exactly on the axis.
fn direction(u: f64, v: f64) -> Vector3<f64> {
    let (sin_phi, cos_phi) = libm::sincos(TAU * u);
    if v == 0.0 || v == 1.0 {
        return Vector3::new(0.0, 0.0, 2.0 * v - 1.0);
    }
    let (sin_theta, cos_theta) = libm::sincos(PI * v);
    Vector3::new(sin_theta * cos_phi, sin_theta * sin_phi, -cos_theta)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shapes::patch::tests::closed_volume;

    #[test]
    fn the_sphere_is_closed_and_has_its_volume() {
        let volume = closed_volume(&sphere(2.0));
        let exact = 4.0 / 3.0 * PI * 8.0;
        assert!((volume / exact - 1.0).abs() < 2e-4, "{volume} {exact}");
    }

    #[test]
    fn the_displaced_sphere_is_closed_and_its_normals_are_normal() {
        let shape = DisplacedSphere { radius: 1.5, amplitude: 0.2, frequency: 1.3, octaves: 2, seed: 3 };
        let volume = closed_volume(&shape.mesh());
        assert!((10.0..20.0).contains(&volume), "{volume}");
        // central differences of the surface itself
        let step = 1e-5;
        for k in 0..200 {
            let (u, v) = (k as f64 / 200.0, 0.03 + 0.94 * ((k * 37) % 200) as f64 / 200.0);
            let (_, normal) = shape.surface(direction(u, v));
            for (du, dv) in [(step, 0.0), (0.0, step)] {
                let at = |sign: f64| shape.surface(direction(u + sign * du, v + sign * dv)).0;
                let tangent = (at(1.0) - at(-1.0)).normalize();
                assert!(tangent.dot(&normal).abs() < 1e-6, "{u} {v}");
            }
        }
    }

    #[test]
    fn without_amplitude_it_is_a_sphere_and_seeds_differ() {
        let shape = DisplacedSphere { radius: 1.0, amplitude: 0.0, frequency: 4.0, octaves: 1, seed: 0 };
        let mesh = shape.mesh();
        assert!(mesh.positions.iter().zip(&mesh.normals).all(|(p, n)| (p - n).norm() < 1e-6));
        let bumps = |seed| DisplacedSphere { amplitude: 0.1, seed, ..shape }.surface(direction(0.1, 0.3)).0.x;
        assert_ne!(bumps(1), bumps(2));
    }
}
