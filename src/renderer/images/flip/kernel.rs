//! Separable convolution with the kernels of FLIP; pixels beyond the border equal the nearest of the image.

use rayon::prelude::*;

/// One component of an image, row by row.
#[derive(Clone)]
pub(super) struct Plane {
    pub(super) width: usize,
    pub(super) values: Vec<f64>,
}

/// An odd number of weights; the one in the middle belongs to the pixel itself, the next to the pixel to the right or below.
pub(super) struct Kernel(Vec<f64>);

impl Kernel {
    /// exp(-x^2 / (2 deviation^2)) at whole numbers up to `radius`, scaled to the sum 1, and the sum before that.
    pub(super) fn gaussian(deviation: f64, radius: usize) -> (Self, f64) {
        let mut weights = sampled(radius, |x| libm::exp(-x * x / (2.0 * deviation * deviation)));
        let sum: f64 = weights.iter().sum();
        weights.iter_mut().for_each(|weight| *weight /= sum);
        (Self(weights), sum)
    }

    /// First derivative of a Gaussian, scaled so that the positive weights add up to 1 and the negative to -1.
    pub(super) fn slope(deviation: f64, radius: usize) -> Self {
        Self(balanced(sampled(radius, |x| x * libm::exp(-x * x / (2.0 * deviation * deviation)))))
    }

    /// Second derivative of a Gaussian, scaled in the same way.
    pub(super) fn curvature(deviation: f64, radius: usize) -> Self {
        let squared = |x: f64| x * x / (deviation * deviation);
        Self(balanced(sampled(radius, |x| (squared(x) - 1.0) * libm::exp(-0.5 * squared(x)))))
    }

    fn radius(&self) -> usize {
        self.0.len() / 2
    }
}

fn sampled(radius: usize, weight: impl Fn(f64) -> f64) -> Vec<f64> {
    (0..=2 * radius).map(|k| weight(k as f64 - radius as f64)).collect()
}

fn balanced(mut weights: Vec<f64>) -> Vec<f64> {
    let sum = |keep: fn(f64) -> bool| weights.iter().copied().filter(|&weight| keep(weight)).sum::<f64>().abs();
    let (positive, negative) = (sum(|weight| weight > 0.0), sum(|weight| weight < 0.0));
    weights.iter_mut().for_each(|weight| *weight /= if *weight > 0.0 { positive } else { negative });
    weights
}

impl Plane {
    fn height(&self) -> usize {
        self.values.len() / self.width
    }

    pub(super) fn along_rows(&self, kernel: &Kernel) -> Self {
        let (width, radius) = (self.width, kernel.radius());
        let mut values = vec![0.0; self.values.len()];
        values.par_chunks_exact_mut(width).zip(self.values.par_chunks_exact(width)).for_each_init(
            Vec::new,
            |padded, (to, from)| {
                padded.clear();
                padded.extend(std::iter::repeat_n(from[0], radius));
                padded.extend_from_slice(from);
                padded.extend(std::iter::repeat_n(from[width - 1], radius));
                for (k, &weight) in kernel.0.iter().enumerate() {
                    add(to, weight, &padded[k..k + width]);
                }
            },
        );
        Self { width, values }
    }

    pub(super) fn along_columns(&self, kernel: &Kernel) -> Self {
        let (width, radius, last) = (self.width, kernel.radius(), self.height() - 1);
        let mut values = vec![0.0; self.values.len()];
        values.par_chunks_exact_mut(width).enumerate().for_each(|(y, to)| {
            for (k, &weight) in kernel.0.iter().enumerate() {
                let row = (y + k).saturating_sub(radius).min(last);
                add(to, weight, &self.values[row * width..][..width]);
            }
        });
        Self { width, values }
    }
}

fn add(to: &mut [f64], weight: f64, from: &[f64]) {
    to.iter_mut().zip(from).for_each(|(to, from)| *to += weight * from);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_impulse_gives_the_kernel() {
        let kernel = Kernel(vec![1.0, 2.0, 4.0]);
        let mut values = vec![0.0; 15];
        values[7] = 1.0;
        let plane = Plane { width: 5, values };
        // the weight to the right is the one that looks to the right
        assert_eq!(plane.along_rows(&kernel).values[5..10], [0.0, 4.0, 2.0, 1.0, 0.0]);
        let column: Vec<f64> = plane.along_columns(&kernel).values.into_iter().skip(2).step_by(5).collect();
        assert_eq!(column, [4.0, 2.0, 1.0]);
    }

    #[test]
    fn borders_repeat() {
        let kernel = Kernel(vec![1.0, 0.0, 0.0, 0.0, 1.0]);
        let plane = Plane { width: 2, values: vec![1.0, 2.0, 3.0, 4.0] };
        assert_eq!(plane.along_rows(&kernel).values, [3.0, 3.0, 7.0, 7.0]);
        assert_eq!(plane.along_columns(&kernel).values, [4.0, 6.0, 4.0, 6.0]);
    }

    #[test]
    fn kernels_are_scaled() {
        let (gaussian, before) = Kernel::gaussian(2.0, 9);
        assert!((gaussian.0.iter().sum::<f64>() - 1.0).abs() < 1e-14);
        assert!((before / (2.0 * (2.0 * std::f64::consts::PI).sqrt()) - 1.0).abs() < 1e-4);
        for kernel in [Kernel::slope(2.0, 9), Kernel::curvature(2.0, 9)] {
            let total = |sign: f64| kernel.0.iter().map(|weight| (sign * weight).max(0.0)).sum::<f64>();
            assert!((total(1.0) - 1.0).abs() < 1e-14 && (total(-1.0) - 1.0).abs() < 1e-14);
        }
    }
}
