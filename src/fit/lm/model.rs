//! The linear model of the residuals around a point, and the step that minimises it over the box and a trust region.
//!
//! With D the column scales and z = D (x' - x) the scaled step, the model of the cost at x' is
//! 1/2 |r + J D^-1 z|^2. A QR factorisation J D^-1 = Q A reduces it to 1/2 |A z + b|^2 + constant, A upper triangular
//! and b the first entries of Q^T r: all further work is on matrices as small as the number of parameters.

use crate::lm::bounds::{Bound, Bounds};
use crate::lm::triangle::{dot, solve, solve_transposed, triangularise};
use nalgebra::{DMatrix, DVector};

/// The damping of a "Gauss-Newton" step, as a fraction of the largest column norm of A, squared. It bounds the step where
/// A has no full rank, and moves a solution with condition number c by a relative 1e-28 c^2.
const LEAST_DAMPING: f64 = 1e-28;

/// A multiplier that is zero but for rounding, relative to the terms it is the sum of.
const MULTIPLIER_ROUNDING: f64 = 1e-14;

/// Most damped problems solved for one step.
const DAMPING_LIMIT: usize = 30;

/// The model around one point, in scaled coordinates.
#[derive(Debug, Clone)]
pub(super) struct LinearModel {
    /// A, upper triangular.
    a: DMatrix<f64>,
    /// b, the part of the residual that the columns can reach.
    b: DVector<f64>,
    /// Least and largest admissible z.
    lower: DVector<f64>,
    upper: DVector<f64>,
    /// The bounds that hold parameters at z = 0.
    held: Vec<Option<Bound>>,
    /// Norms of the columns of A.
    norms: DVector<f64>,
    /// Norm of the gradient A^T b.
    gradient_norm: f64,
}

/// A step, with what the model says about it.
#[derive(Debug, Clone)]
pub(super) struct Step {
    /// The scaled step z.
    pub(super) z: DVector<f64>,
    /// The bound at which each parameter ends, if any.
    pub(super) sides: Vec<Option<Bound>>,
    /// The damping that gave it.
    pub(super) damping: f64,
    /// Whether the trust region, rather than the model and the box alone, determined it.
    pub(super) restricted: bool,
    /// Predicted decrease of the cost.
    pub(super) decrease: f64,
    /// The same for the step without a trust region.
    pub(super) full_decrease: f64,
    /// Derivative of the cost along the step, at its beginning.
    pub(super) slope: f64,
}

impl LinearModel {
    /// The model around `x` with residuals `r`, their Jacobian `jacobian` and the column scales `scale`. `held` are the
    /// bounds that hold parameters there.
    pub(super) fn new(
        x: &DVector<f64>,
        r: &DVector<f64>,
        jacobian: &DMatrix<f64>,
        scale: &DVector<f64>,
        bounds: &Bounds,
        held: Vec<Option<Bound>>,
    ) -> Self {
        let n = x.len();
        let m = r.len();
        // With the residual as one more column, the factor R holds Q^T r in its last one.
        let mut stacked = DMatrix::zeros(m.max(n + 1), n + 1);
        for j in 0..n {
            let inverse = 1.0 / scale[j];
            for (to, from) in stacked.column_mut(j).iter_mut().zip(&jacobian.column(j)) {
                *to = from * inverse;
            }
        }
        stacked.view_mut((0, n), (m, 1)).copy_from(r);
        triangularise(&mut stacked);
        let a = DMatrix::from_fn(n, n, |i, j| if i <= j { stacked[(i, j)] } else { 0.0 });
        let b = DVector::from_fn(n, |i, _| stacked[(i, n)]);
        let norms = DVector::from_fn(n, |j, _| norm(a.column(j).as_slice()));
        let gradient = DVector::from_fn(n, |j, _| dot(a.column(j).as_slice(), b.as_slice()));
        let gradient_norm = norm(gradient.as_slice());
        let range = |bound: &[f64]| DVector::from_fn(n, |j, _| scale[j] * (bound[j] - x[j]));
        Self { a, b, lower: range(bounds.lower()), upper: range(bounds.upper()), held, norms, gradient_norm }
    }

    /// The minimiser of the model over the box and the trust region |z| <= `radius`, whose length may exceed the
    /// radius by a tenth (Moré 1978, section 5: that precision is enough). `guess` is a first guess of the damping.
    pub(super) fn step(&self, radius: f64, guess: f64) -> Step {
        let least = LEAST_DAMPING * self.norms.amax().powi(2);
        let mut z = DVector::zeros(self.b.len());
        let mut sides = self.held.clone();
        let sensitivity = self.minimise(least, &mut z, &mut sides);
        let full_decrease = self.decrease(&z).0;
        let mut damping = least;
        let mut length = norm(z.as_slice());
        let restricted = length > 1.1 * radius;
        if restricted {
            // The length falls as the damping grows, and |z| <= |gradient| / damping.
            let mut low = least;
            let mut high = self.gradient_norm / radius;
            let mut next = if guess > low { guess } else { newton(least, length, radius, sensitivity) };
            for _ in 0..DAMPING_LIMIT {
                if !(next > low && next < high) {
                    next = (low * high).sqrt().max(1e-3 * high);
                }
                damping = next;
                let sensitivity = self.minimise(damping, &mut z, &mut sides);
                length = norm(z.as_slice());
                if (length - radius).abs() <= 0.1 * radius {
                    break;
                }
                if length > radius {
                    low = damping;
                } else {
                    high = damping;
                }
                next = newton(damping, length, radius, sensitivity);
            }
        }
        let (decrease, slope) = self.decrease(&z);
        Step { z, sides, damping, restricted, decrease, full_decrease, slope }
    }

    /// The decrease of the model from 0 to `z`, written without the cancellation of |b|^2 - |A z + b|^2, and the
    /// slope b^T A z.
    fn decrease(&self, z: &DVector<f64>) -> (f64, f64) {
        let image = self.image(z);
        let slope = dot(self.b.as_slice(), image.as_slice());
        let square = dot(image.as_slice(), image.as_slice());
        (-(slope + 0.5 * square), slope)
    }

    /// A z.
    fn image(&self, z: &DVector<f64>) -> DVector<f64> {
        let mut image = DVector::zeros(z.len());
        for (j, &z) in z.iter().enumerate() {
            for i in 0..=j {
                image[i] += self.a[(i, j)] * z;
            }
        }
        image
    }

    /// Moves `z` to the minimiser of |A z + b|^2 + `damping` |z|^2 over the box. `z` must be in the box and `sides`
    /// name the bounds to begin with, each one attained by `z`.
    ///
    /// An active-set method, as for bounded linear least squares: go towards the minimiser on the face; a bound
    /// in the way joins the face; at the minimiser the bound with the worst wrong-signed multiplier leaves it. The problem
    /// is strictly convex, so no face comes twice but for rounding, which `stuck` takes care of.
    ///
    /// Returns z_F^T (A_F^T A_F + damping)^-1 z_F over the free parameters F, that is -1/2 d|z|^2/d damping.
    fn minimise(&self, damping: f64, z: &mut DVector<f64>, sides: &mut [Option<Bound>]) -> f64 {
        let n = z.len();
        let mut released = None;
        let mut stuck = vec![false; n];
        let mut sensitivity = 0.0;
        for _ in 0..10 * (n + 1) {
            let free: Vec<usize> = (0..n).filter(|&j| sides[j].is_none()).collect();
            sensitivity = 0.0;
            if !free.is_empty() {
                let Some((target, s)) = self.face_minimiser(damping, z, &free) else {
                    break;
                };
                sensitivity = s;
                if let Some((k, side, fraction)) = self.first_bound(z, &free, &target) {
                    for (&j, &t) in free.iter().zip(target.iter()) {
                        z[j] += fraction * (t - z[j]);
                        z[j] = z[j].clamp(self.lower[j], self.upper[j]);
                    }
                    let j = free[k];
                    z[j] = match side {
                        Bound::Lower => self.lower[j],
                        Bound::Upper => self.upper[j],
                    };
                    sides[j] = Some(side);
                    stuck[j] |= released == Some(j) && fraction == 0.0;
                    continue;
                }
                for (&j, &t) in free.iter().zip(target.iter()) {
                    z[j] = t;
                }
            }
            released = self.wrong_multiplier(damping, z, sides, &stuck);
            match released {
                Some(j) => sides[j] = None,
                None => break,
            }
        }
        sensitivity
    }

    /// The minimiser over the parameters `free`, the others at their values in `z`, and the sensitivity that
    /// [`minimise`](Self::minimise) returns. None if the numbers leave the range of f64.
    fn face_minimiser(&self, damping: f64, z: &DVector<f64>, free: &[usize]) -> Option<(DVector<f64>, f64)> {
        let n = z.len();
        let k = free.len();
        let mut stacked = DMatrix::zeros(n + k, k + 1);
        let ridge = damping.sqrt();
        for (column, &j) in free.iter().enumerate() {
            for i in 0..=j {
                stacked[(i, column)] = self.a[(i, j)];
            }
            stacked[(n + column, column)] = ridge;
        }
        for i in 0..n {
            stacked[(i, k)] = -self.b[i];
        }
        for f in (0..n).filter(|f| !free.contains(f)) {
            for i in 0..=f {
                stacked[(i, k)] -= self.a[(i, f)] * z[f];
            }
        }
        triangularise(&mut stacked);
        let target = solve(&stacked, &stacked.column(k).as_slice()[..k])?;
        let weighted = solve_transposed(&stacked, &target);
        let sensitivity = dot(weighted.as_slice(), weighted.as_slice());
        Some((target, sensitivity))
    }

    /// The first bound on the way from `z` to `target`: its index in `free`, its side, and the fraction of the way.
    fn first_bound(&self, z: &DVector<f64>, free: &[usize], target: &DVector<f64>) -> Option<(usize, Bound, f64)> {
        let mut first: Option<(usize, Bound, f64)> = None;
        for (k, &j) in free.iter().enumerate() {
            let t = target[k];
            let (limit, side) = if t < self.lower[j] {
                (self.lower[j], Bound::Lower)
            } else if t > self.upper[j] {
                (self.upper[j], Bound::Upper)
            } else {
                continue;
            };
            let fraction = (limit - z[j]) / (t - z[j]);
            if first.is_none_or(|(_, _, least)| fraction < least) {
                first = Some((k, side, fraction));
            }
        }
        first
    }

    /// The bound whose multiplier at `z` most clearly says that the cost falls into the box.
    fn wrong_multiplier(
        &self,
        damping: f64,
        z: &DVector<f64>,
        sides: &[Option<Bound>],
        stuck: &[bool],
    ) -> Option<usize> {
        if sides.iter().all(Option::is_none) {
            return None;
        }
        let residual = self.image(z) + &self.b;
        let size = norm(residual.as_slice());
        let mut worst = MULTIPLIER_ROUNDING;
        let mut index = None;
        for (j, side) in sides.iter().enumerate() {
            let Some(side) = side else { continue };
            if stuck[j] || self.lower[j] == self.upper[j] {
                continue;
            }
            let gradient = dot(self.a.column(j).as_slice(), residual.as_slice()) + damping * z[j];
            let inward = match side {
                Bound::Lower => -gradient,
                Bound::Upper => gradient,
            };
            let violation = inward / (self.norms[j] * size + damping * z[j].abs());
            if violation > worst {
                worst = violation;
                index = Some(j);
            }
        }
        index
    }
}

/// The Euclidean norm.
fn norm(a: &[f64]) -> f64 {
    dot(a, a).sqrt()
}

/// Newton's iteration for the damping at which the step is as long as the radius, on 1/radius - 1/length, which is nearly
/// linear (Hebden 1973; Moré 1978, equation 5.4). NaN where no free parameter moves.
fn newton(damping: f64, length: f64, radius: f64, sensitivity: f64) -> f64 {
    damping + (length - radius) / radius * (length * length / sensitivity)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn model(rows: usize, n: usize, entries: &[f64], r: &[f64], range: &[(f64, f64)]) -> LinearModel {
        let x = DVector::zeros(n);
        let r = DVector::from_column_slice(&r[..rows]);
        let j = DMatrix::from_column_slice(rows, n, &entries[..rows * n]);
        let scale = DVector::from_element(n, 1.0);
        let bounds =
            Bounds::new(range[..n].iter().map(|b| b.0).collect(), range[..n].iter().map(|b| b.1).collect()).unwrap();
        let gradient = j.tr_mul(&r);
        let held = (0..n).map(|i| bounds.holding(i, 0.0, gradient[i])).collect();
        LinearModel::new(&x, &r, &j, &scale, &bounds, held)
    }

    /// The minimum of |A z + b|^2 + damping |z|^2 by trying every face of the box, with normal equations.
    fn enumerate(m: &LinearModel, damping: f64) -> f64 {
        let n = m.b.len();
        let value = |z: &DVector<f64>| (&m.a * z + &m.b).norm_squared() + damping * z.norm_squared();
        let mut best = f64::INFINITY;
        for code in 0..3usize.pow(n as u32) {
            let digit = |j: usize| code / 3usize.pow(j as u32) % 3;
            let free: Vec<usize> = (0..n).filter(|&j| digit(j) == 2).collect();
            let mut z = DVector::from_iterator(
                n,
                (0..n).map(|j| match digit(j) {
                    0 => m.lower[j],
                    1 => m.upper[j],
                    _ => 0.0,
                }),
            );
            let columns = m.a.select_columns(&free);
            let mut normal = columns.tr_mul(&columns);
            for i in 0..free.len() {
                normal[(i, i)] += damping;
            }
            let rhs = -columns.tr_mul(&(&m.a * &z + &m.b));
            if !free.is_empty() {
                let Some(solution) = normal.lu().solve(&rhs) else {
                    continue;
                };
                for (k, &j) in free.iter().enumerate() {
                    z[j] = solution[k];
                }
            }
            if (0..n).all(|j| (m.lower[j]..=m.upper[j]).contains(&z[j])) {
                best = best.min(value(&z));
            }
        }
        best
    }

    proptest! {
        #[test]
        fn the_damped_minimiser_is_the_best_of_all_faces(
            n in 1usize..5,
            extra in 0usize..4,
            entries in prop::collection::vec(-1.0f64..1.0, 32),
            r in prop::collection::vec(-2.0f64..2.0, 8),
            range in prop::collection::vec((-1.0f64..=0.0, 0.0f64..=1.0), 4),
            power in -3i32..2,
        ) {
            let damping = 10f64.powi(power);
            let m = model(n + extra, n, &entries, &r, &range);
            let mut z = DVector::zeros(n);
            let mut sides = m.held.clone();
            m.minimise(damping, &mut z, &mut sides);
            let ours = (&m.a * &z + &m.b).norm_squared() + damping * z.norm_squared();
            let best = enumerate(&m, damping);
            prop_assert!((ours - best).abs() <= 1e-11 * (1.0 + best), "{ours} {best}");
            for j in 0..n {
                match sides[j] {
                    Some(Bound::Lower) => prop_assert_eq!(z[j], m.lower[j]),
                    Some(Bound::Upper) => prop_assert_eq!(z[j], m.upper[j]),
                    None => prop_assert!(m.lower[j] <= z[j] && z[j] <= m.upper[j]),
                }
            }
        }

        #[test]
        fn the_step_fits_the_trust_region(
            n in 1usize..5,
            entries in prop::collection::vec(-1.0f64..1.0, 32),
            r in prop::collection::vec(-2.0f64..2.0, 8),
            range in prop::collection::vec((-1.0f64..=0.0, 0.0f64..=1.0), 4),
            power in -5i32..2,
        ) {
            let radius = 10f64.powi(power);
            let m = model(8, n, &entries, &r, &range);
            let step = m.step(radius, 0.0);
            prop_assert!(step.z.norm() <= 1.1000001 * radius);
            prop_assert!(!step.restricted || step.z.norm() >= 0.8999999 * radius);
            prop_assert!(step.decrease >= 0.0 && step.decrease <= step.full_decrease * (1.0 + 1e-12));
            let before = m.b.norm_squared();
            let after = (&m.a * &step.z + &m.b).norm_squared();
            prop_assert!((0.5 * (before - after) - step.decrease).abs() <= 1e-13 * before);
        }
    }

    #[test]
    fn a_singular_model_gives_a_finite_step() {
        // Two equal columns: the minimiser is a line, the step its shortest point.
        let entries = [1.0, 2.0, 3.0, 1.0, 2.0, 3.0];
        let wide = [(-1e9, 1e9); 2];
        let step = model(3, 2, &entries, &[-2.0, -4.0, -6.0], &wide).step(1e3, 0.0);
        assert!((step.z.sum() - 2.0).abs() < 1e-12 && (step.z[0] - step.z[1]).abs() < 1e-2, "{}", step.z);
    }

    #[test]
    fn fewer_rows_than_parameters_are_no_obstacle() {
        let step = model(1, 3, &[1.0, 1.0, 1.0], &[-3.0], &[(-9.0, 9.0); 3]).step(1e3, 0.0);
        assert!((step.z.sum() - 3.0).abs() < 1e-12);
        assert!((step.decrease - 4.5).abs() < 1e-12);
    }
}
