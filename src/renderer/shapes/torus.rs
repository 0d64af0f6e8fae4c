//! The torus and the torus knot: tubes of constant radius around closed curves.

use std::f64::consts::TAU;

use nalgebra::Vector3;

use crate::shapes::mesh::Mesh;
use crate::shapes::patch::Patch;

/// Cells around a tube. Interpolated normals are exact around it, whatever their number.
const AROUND: usize = 128;
/// Cells along a ring, and along a knot for each turn.
const ALONG: usize = 512;
const ALONG_PER_TURN: usize = 256;

/// A ring in the x-y plane, its tube at `radius` from the z axis.
pub(crate) fn torus(radius: f64, tube: f64) -> Mesh {
    ring(ALONG).mesh(|u, v| {
        let (sin, cos) = libm::sincos(TAU * u);
        let outwards = Vector3::new(cos, sin, 0.0);
        around(outwards * radius, outwards, Vector3::z(), tube, v)
    })
}

/// A tube along the curve that winds p times about the z axis and q times about the ring of radius `radius`, half of it away from the ring.
/// The cross-sections follow the normal of the torus on which the curve lies: it stands on the tangent everywhere, never turns fast and
/// returns to itself.
pub(crate) fn torus_knot(p: u32, q: u32, radius: f64, tube: f64) -> Mesh {
    let (p, q) = (f64::from(p), f64::from(q));
    ring(ALONG_PER_TURN * (p + q) as usize).mesh(|u, v| {
        let (sin_p, cos_p) = libm::sincos(TAU * p * u);
        let (sin_q, cos_q) = libm::sincos(TAU * q * u);
        let outwards = Vector3::new(cos_p, sin_p, 0.0);
        let along_ring = Vector3::new(-sin_p, cos_p, 0.0);
        let normal = outwards * cos_q + Vector3::z() * sin_q;
        let minor = radius / 2.0;
        let centre = outwards * radius + normal * minor;
        let about = Vector3::z() * cos_q - outwards * sin_q;
        let tangent = (along_ring * (p * (radius + minor * cos_q)) + about * (q * minor)).normalize();
        around(centre, normal, normal.cross(&tangent), tube, v)
    })
}

/// The point at v around the tube's `centre`: from the direction `a` to `b`, two unit vectors that stand on the curve.
fn around(centre: Vector3<f64>, a: Vector3<f64>, b: Vector3<f64>, tube: f64, v: f64) -> (Vector3<f64>, Vector3<f64>) {
    let (sin, cos) = libm::sincos(TAU * v);
    let normal = a * cos + b * sin;
    (centre + normal * tube, normal)
}

fn ring(columns: usize) -> Patch {
    Patch { columns, rows: AROUND, closed_u: true, closed_v: true }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use super::*;
    use crate::shapes::patch::tests::closed_volume;

    #[test]
    fn the_torus_has_its_volume() {
        let volume = closed_volume(&torus(1.0, 0.4));
        let exact = 2.0 * PI * PI * 0.16;
        assert!((volume / exact - 1.0).abs() < 1e-3, "{volume} {exact}");
    }

    #[test]
    fn a_knot_has_the_volume_of_a_tube_of_its_length() {
        // Pappus: cross-section times the length of the curve, here by its chords
        for (p, q) in [(2, 3), (1, 2)] {
            let point = |k: usize| {
                let t = TAU * k as f64 / 100_000.0;
                let ring = 1.0 + 0.5 * (t * f64::from(q)).cos();
                let angle = t * f64::from(p);
                Vector3::new(ring * angle.cos(), ring * angle.sin(), 0.5 * (t * f64::from(q)).sin())
            };
            let length: f64 = (0..100_000).map(|k| (point(k + 1) - point(k)).norm()).sum();
            let volume = closed_volume(&torus_knot(p, q, 1.0, 0.1));
            let exact = PI * 0.01 * length;
            assert!((volume / exact - 1.0).abs() < 2e-3, "{p} {q}: {volume} {exact}");
        }
    }
}
