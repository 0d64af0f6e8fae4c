//! Ray-triangle intersection.

use crate::geometry::vec3::Vec3;

/// A ray with what its intersections share. Watertight: a ray through a common edge or vertex of triangles meets one of them. S. Woop, C.
/// Benthin and I. Wald, "Watertight ray/triangle intersection", 2013.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Ray {
    pub(crate) origin: Vec3,
    /// Finite inverses of the components of the direction: tiny components count as 1e-20.
    pub(crate) inverse: Vec3,
    /// Axes such that z is where the direction is longest.
    axes: [usize; 3],
    /// Shear and scale that take the direction to (0, 0, 1).
    shear: [f32; 3],
}

/// A point of a triangle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Hit {
    /// Distance along the ray in lengths of its direction.
    pub(crate) t: f32,
    /// Weights of the three corners, sum 1.
    pub(crate) weights: [f32; 3],
}

impl Ray {
    /// From `origin` along `direction`, which is not zero.
    pub(crate) fn new(origin: Vec3, direction: Vec3) -> Self {
        let z = direction.iamax();
        let (x, y) = ((z + 1) % 3, (z + 2) % 3);
        let shear = [direction[x] / direction[z], direction[y] / direction[z], 1.0 / direction[z]];
        let inverse = direction.map(|d| 1.0 / if d.abs() < 1e-20 { 1e-20f32.copysign(d) } else { d });
        Self { origin, inverse, axes: [x, y, z], shear }
    }

    /// The point in front of the origin where the ray meets the triangle, from either side.
    pub(crate) fn meets(&self, corners: [Vec3; 3]) -> Option<Hit> {
        let [kx, ky, kz] = self.axes;
        let [sx, sy, sz] = self.shear;
        let [a, b, c] = corners.map(|corner| {
            let p = corner - self.origin;
            [p[kx] - sx * p[kz], p[ky] - sy * p[kz], sz * p[kz]]
        });
        let edge = |p: [f32; 3], q: [f32; 3]| {
            let value = p[0] * q[1] - p[1] * q[0];
            // the sign decides on which side of an edge the ray passes: where single precision has none, double precision does
            if value == 0.0 {
                (f64::from(p[0]) * f64::from(q[1]) - f64::from(p[1]) * f64::from(q[0])) as f32
            } else {
                value
            }
        };
        let (u, v, w) = (edge(b, c), edge(c, a), edge(a, b));
        if (u < 0.0 || v < 0.0 || w < 0.0) && (u > 0.0 || v > 0.0 || w > 0.0) {
            return None;
        }
        let sum = u + v + w;
        if sum == 0.0 {
            return None;
        }
        let weights = [u / sum, v / sum, w / sum];
        let t = weights[0] * a[2] + weights[1] * b[2] + weights[2] * c[2];
        (t > 0.0).then_some(Hit { t, weights })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_point_inside_and_one_outside() {
        let corners = [Vec3::new(1.0, 0.0, 0.0), Vec3::new(1.0, 4.0, 0.0), Vec3::new(1.0, 0.0, 2.0)];
        let ray = Ray::new(Vec3::new(-1.0, 1.0, 0.5), Vec3::new(0.5, 0.0, 0.0));
        let hit = ray.meets(corners).unwrap();
        assert_eq!(hit.t, 4.0);
        assert_eq!(hit.weights, [0.5, 0.25, 0.25]);
        // the other side of the triangle, behind the origin, beside it
        assert!(ray.meets([corners[0], corners[2], corners[1]]).is_some());
        assert!(Ray::new(Vec3::new(-1.0, 1.0, 0.5), -Vec3::x()).meets(corners).is_none());
        assert!(Ray::new(Vec3::new(-1.0, 2.1, 1.0), Vec3::x()).meets(corners).is_none());
    }

    #[test]
    fn no_ray_slips_through_a_fan() {
        // rays straight at the vertex and at the edges that eight triangles share
        let centre = Vec3::new(0.3, 0.7, 2.0);
        let rim: Vec<Vec3> = (0..8)
            .map(|k| {
                let angle = k as f32 * std::f32::consts::FRAC_PI_4;
                centre + Vec3::new(1.37 * angle.cos(), angle.sin(), 0.1 * (k % 3) as f32)
            })
            .collect();
        let origin = Vec3::new(0.1, 0.2, -5.0);
        for k in 0..8 {
            for s in 0..50 {
                let target = centre + (rim[k] - centre) * (s as f32 / 51.0);
                let ray = Ray::new(origin, target - origin);
                let hits = (0..8).filter(|&j| ray.meets([centre, rim[j], rim[(j + 1) % 8]]).is_some()).count();
                assert!(hits >= 1, "{k} {s}");
            }
        }
    }
}
