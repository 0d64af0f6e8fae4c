//! Gradient noise in three dimensions with its derivative.

use nalgebra::Vector3;

/// Smooth irregular values in space: K. Perlin, "Improving noise", 2002, with the gradients at lattice points chosen by a hash (M. Jarzynski
/// and M. Olano, "Hash functions for GPU rendering", 2020) instead of a table. Zero at lattice points, within -1..1; second
/// derivatives are continuous, thus curvatures of what it displaces.
#[derive(Clone, Copy, Debug)]
pub(crate) struct GradientNoise {
    seed: u32,
}

impl GradientNoise {
    pub(crate) fn new(seed: u32) -> Self {
        Self { seed }
    }

    /// The value at `p` and its gradient.
    pub(crate) fn at(&self, p: Vector3<f64>) -> (f64, Vector3<f64>) {
        let origin = p.map(f64::floor);
        let t = p - origin;
        let fade = t.map(|t| t * t * t * (t * (6.0 * t - 15.0) + 10.0));
        let slope = t.map(|t| 30.0 * t * t * (t - 1.0) * (t - 1.0));
        let (mut value, mut gradient) = (0.0, Vector3::zeros());
        for corner in 0..8 {
            let bits = [corner & 1, corner >> 1 & 1, corner >> 2 & 1];
            let offset = Vector3::from(bits.map(f64::from));
            let g = self.lattice(origin + offset);
            let linear = g.dot(&(t - offset));
            let weights: [f64; 3] = std::array::from_fn(|k| if bits[k] == 1 { fade[k] } else { 1.0 - fade[k] });
            let weight = weights[0] * weights[1] * weights[2];
            value += weight * linear;
            gradient += g * weight;
            for k in 0..3 {
                let sign = if bits[k] == 1 { 1.0 } else { -1.0 };
                gradient[k] += sign * slope[k] * weights[(k + 1) % 3] * weights[(k + 2) % 3] * linear;
            }
        }
        (value, gradient)
    }

    /// The gradient at a lattice point: one of the twelve from the centre of a cube to its edges.
    fn lattice(&self, point: Vector3<f64>) -> Vector3<f64> {
        let [mut x, mut y, mut z] = [point.x, point.y, point.z].map(|x| x as i32 as u32);
        z = z.wrapping_add(self.seed.wrapping_mul(0x9e37_79b9));
        [x, y, z] = [x, y, z].map(|x| x.wrapping_mul(1_664_525).wrapping_add(1_013_904_223));
        for round in 0..2 {
            x = x.wrapping_add(y.wrapping_mul(z));
            y = y.wrapping_add(z.wrapping_mul(x));
            z = z.wrapping_add(x.wrapping_mul(y));
            if round == 0 {
                [x, y, z] = [x, y, z].map(|x| x ^ (x >> 16));
            }
        }
        let edge = ((u64::from(x) * 12) >> 32) as usize;
        let signs = [if edge & 1 == 0 { 1.0 } else { -1.0 }, if edge & 2 == 0 { 1.0 } else { -1.0 }];
        let mut gradient = Vector3::zeros();
        let axis = edge / 4;
        (gradient[axis], gradient[(axis + 1) % 3]) = (signs[0], signs[1]);
        gradient
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn places() -> impl Iterator<Item = Vector3<f64>> {
        (0..2000).map(|k| Vector3::new(0.377, 0.613, 0.771) * k as f64 * 0.173 - Vector3::new(50.0, 7.0, 90.0))
    }

    #[test]
    fn the_gradient_is_that_of_the_values() {
        let noise = GradientNoise::new(5);
        let step = 1e-5;
        for p in places() {
            let (_, gradient) = noise.at(p);
            for axis in 0..3 {
                let mut d = Vector3::zeros();
                d[axis] = step;
                let difference = (noise.at(p + d).0 - noise.at(p - d).0) / (2.0 * step);
                assert!((difference - gradient[axis]).abs() < 1e-7, "{p}");
            }
        }
    }

    #[test]
    fn values_are_bounded_balanced_and_zero_on_the_lattice() {
        let noise = GradientNoise::new(0);
        let values: Vec<f64> = places().map(|p| noise.at(p).0).collect();
        assert!(values.iter().all(|value| value.abs() <= 1.0));
        let mean = values.iter().sum::<f64>() / values.len() as f64;
        let square = values.iter().map(|value| value * value).sum::<f64>() / values.len() as f64;
        assert!(mean.abs() < 0.02 && (0.03..0.15).contains(&square), "{mean} {square}");
        assert_eq!(noise.at(Vector3::new(3.0, -2.0, 11.0)).0, 0.0);
    }

    #[test]
    fn it_is_smooth_across_cells() {
        let noise = GradientNoise::new(9);
        for k in 0..100 {
            let p = Vector3::new(f64::from(k % 7), 0.1 * f64::from(k), 0.37 * f64::from(k));
            let d = Vector3::new(1e-9, 0.0, 0.0);
            let ((a, slope_a), (b, slope_b)) = (noise.at(p - d), noise.at(p + d));
            assert!((a - b).abs() < 1e-7 && (slope_a - slope_b).norm() < 1e-6);
        }
    }
}
