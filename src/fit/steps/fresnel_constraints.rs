//! The cone of admissible Fresnel terms: `u = rho_s (f0, f1, 1)` is bound by conditions that are linear and homogeneous in `u`.

use crate::options::Constraint;
use nalgebra::Vector3;

/// The basis in which `rho_s F(theta_d) = u . basis(cos theta_d)`.
pub(crate) fn basis(cos_theta_d: f64) -> Vector3<f64> {
    let rest = 1.0 - cos_theta_d;
    let fifth = rest * rest * rest * rest * rest;
    Vector3::new(1.0 - fifth, -cos_theta_d, fifth)
}

/// One condition `normal . u >= 0`.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct HalfSpace {
    /// Inward normal.
    pub(crate) normal: Vector3<f64>,
    /// Its text in reports.
    pub(crate) name: String,
}

/// The conditions of a constraint: `F >= 0` at 0, 3, .., 90 degrees, which at 90 is `rho_s >= 0`; `physical` adds `F <= 1` at 0, 3,
/// .., 87 (at 90 it is void, and rounding would make it active).
pub(crate) fn conditions(constraint: Constraint) -> Vec<HalfSpace> {
    let at = |degrees: u32| basis(if degrees == 90 { 0.0 } else { libm::cos(f64::from(degrees).to_radians()) });
    let not_negative = (0..=30).map(|n| HalfSpace {
        normal: at(3 * n),
        name: if n == 30 { "rho_s >= 0".to_owned() } else { format!("fresnel >= 0 at {} degrees", 3 * n) },
    });
    let at_most_one = (0..30)
        .map(|n| HalfSpace { normal: Vector3::z() - at(3 * n), name: format!("fresnel <= 1 at {} degrees", 3 * n) });
    match constraint {
        Constraint::Free => Vec::new(),
        Constraint::NonNegative => not_negative.collect(),
        Constraint::Physical => not_negative.chain(at_most_one).collect(),
    }
}

/// The extreme rays (unit vectors) of the pointed cone that satisfies all conditions, found by cutting the cone of three of
/// them with the others one by one. Every admissible `u` is a sum of rays with coefficients that are not negative.
pub(crate) fn extreme_rays(conditions: &[HalfSpace]) -> Vec<Vector3<f64>> {
    // F >= 0 at 0, 45 and 90 degrees: three independent conditions of every constraint
    let [a, b, c] = [0, 15, 30].map(|n| conditions[n].normal);
    let orientation = a.dot(&b.cross(&c)).signum();
    let mut rays: Vec<Vector3<f64>> =
        [b.cross(&c), c.cross(&a), a.cross(&b)].iter().map(|ray| (ray * orientation).normalize()).collect();
    for condition in conditions {
        let sides: Vec<f64> = rays
            .iter()
            .map(|ray| condition.normal.dot(ray))
            .map(|side| if side.abs() < 1e-15 * condition.normal.norm() { 0.0 } else { side })
            .collect();
        let mut kept = Vec::with_capacity(rays.len() + 1);
        for n in 0..rays.len() {
            let next = (n + 1) % rays.len();
            if sides[n] >= 0.0 {
                kept.push(rays[n]);
            }
            if sides[n] * sides[next] < 0.0 {
                let cut = rays[n] * sides[next].abs() + rays[next] * sides[n].abs();
                kept.push(cut.normalize());
            }
        }
        rays = kept;
    }
    rays
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rays_span_the_cone() {
        for constraint in [Constraint::NonNegative, Constraint::Physical] {
            let conditions = conditions(constraint);
            let rays = extreme_rays(&conditions);
            assert!(rays.len() >= 3);
            for ray in &rays {
                let active = conditions.iter().filter(|c| c.normal.dot(ray).abs() < 1e-12).count();
                assert!(active >= 2, "an extreme ray lies on two faces");
                assert!(conditions.iter().all(|c| c.normal.dot(ray) > -1e-13));
            }
            // neighbours share a face, so that the hull of the rays is the whole cone and not a part of it
            for n in 0..rays.len() {
                let (a, b) = (rays[n], rays[(n + 1) % rays.len()]);
                let shared = |c: &HalfSpace| c.normal.dot(&a).abs() < 1e-12 && c.normal.dot(&b).abs() < 1e-12;
                assert!(conditions.iter().any(shared));
            }
        }
    }

    #[test]
    fn schlick_with_physical_f0_is_admissible() {
        let conditions = conditions(Constraint::Physical);
        for f0 in [0.0, 0.04, 0.9, 1.0] {
            let u = Vector3::new(f0, 0.0, 1.0) * 0.3;
            assert!(conditions.iter().all(|c| c.normal.dot(&u) >= -1e-16), "f0 {f0}");
        }
        let outside = Vector3::new(1.2, 0.0, 1.0);
        assert!(conditions.iter().any(|c| c.normal.dot(&outside) < 0.0));
    }
}
