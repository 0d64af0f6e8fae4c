//! Covariance, standard errors and conditioning at a solution.

use crate::lm::bounds::Bound;
use crate::lm::triangle::triangularise;
use nalgebra::{DMatrix, DVector};

/// Weight in a null direction above which a parameter counts as undetermined: half of the digits of f64.
const NULL_WEIGHT: f64 = 1.5e-8;

/// How well the data determine the parameters, in the linear approximation at a solution.
#[derive(Debug, Clone, PartialEq)]
pub struct Uncertainty {
    /// sigma^2 = 2 cost / (rows - parameters); none without a degree of freedom.
    pub variance: Option<f64>,
    /// sigma^2 (J^T J)^-1 over the parameters that are at no bound, parameters x parameters. Rows and columns of parameters
    /// at a bound or undetermined are zero, and so is all of it without a variance.
    pub covariance: DMatrix<f64>,
    /// Square roots of the covariance's diagonal; none for a parameter that is at a bound or that the data do not
    /// determine, and for all without a variance.
    pub standard_errors: Vec<Option<f64>>,
    /// Condition number in the 2-norm of the Jacobian's columns that belong to parameters at no bound, each divided by its
    /// norm. None if there is no such column or they are linearly dependent to working precision.
    pub condition_number: Option<f64>,
}

impl Uncertainty {
    /// From the Jacobian and the cost at a solution, and the bound that each parameter is at.
    ///
    /// The scaled free columns are factorised by QR and the triangle by one-sided Jacobi rotations (Demmel and Veselić
    /// 1992), so small singular values keep their relative accuracy. A singular value below epsilon x rows of the
    /// largest counts as zero; its direction makes undetermined the parameters that take part in it.
    pub fn new(jacobian: &DMatrix<f64>, cost: f64, active: &[Option<Bound>]) -> Self {
        let (rows, n) = jacobian.shape();
        let variance = (rows > n).then(|| 2.0 * cost / (rows - n) as f64);
        let mut result =
            Self { variance, covariance: DMatrix::zeros(n, n), standard_errors: vec![None; n], condition_number: None };
        let at_no_bound = (0..n).filter(|&j| active[j].is_none());
        let (free, without_effect): (Vec<usize>, Vec<usize>) =
            at_no_bound.partition(|&j| jacobian.column(j).norm() > 0.0);
        let k = free.len();
        if k == 0 {
            return result;
        }
        let norms: Vec<f64> = free.iter().map(|&j| jacobian.column(j).norm()).collect();
        let mut scaled = DMatrix::zeros(rows.max(k), k);
        for (c, &j) in free.iter().enumerate() {
            for i in 0..rows {
                scaled[(i, c)] = jacobian[(i, j)] / norms[c];
            }
        }
        triangularise(&mut scaled);
        let triangle = DMatrix::from_fn(k, k, |i, j| if i <= j { scaled[(i, j)] } else { 0.0 });
        let (singular, v) = one_sided_jacobi(triangle);
        let largest = singular.max();
        let negligible = f64::EPSILON * rows.max(k) as f64 * largest;
        let kept: Vec<usize> = (0..k).filter(|&i| singular[i] > negligible).collect();
        if kept.len() == k && without_effect.is_empty() {
            result.condition_number = Some(largest / singular.min());
        }
        let Some(variance) = variance else {
            return result;
        };
        let determined = |c: usize| (0..k).all(|i| singular[i] > negligible || v[(c, i)].abs() <= NULL_WEIGHT);
        for c in (0..k).filter(|&c| determined(c)) {
            for d in (0..k).filter(|&d| determined(d)) {
                let sum: f64 = kept.iter().map(|&i| v[(c, i)] / singular[i] * (v[(d, i)] / singular[i])).sum();
                result.covariance[(free[c], free[d])] = variance * sum / norms[c] / norms[d];
            }
            result.standard_errors[free[c]] = Some(result.covariance[(free[c], free[c])].sqrt());
        }
        result
    }
}

/// Singular values and right singular vectors (as columns) of a square matrix, in no particular order: rotates pairs of
/// columns until all are orthogonal.
fn one_sided_jacobi(mut u: DMatrix<f64>) -> (DVector<f64>, DMatrix<f64>) {
    const SWEEPS: usize = 60;
    let n = u.ncols();
    let mut v = DMatrix::identity(n, n);
    for _ in 0..SWEEPS {
        let mut rotated = false;
        for p in 0..n {
            for q in p + 1..n {
                let (pp, qq) = (u.column(p).norm_squared(), u.column(q).norm_squared());
                let pq = u.column(p).dot(&u.column(q));
                if pq.abs() <= f64::EPSILON * (pp * qq).sqrt() {
                    continue;
                }
                rotated = true;
                let zeta = (qq - pp) / (2.0 * pq);
                let tangent = 1f64.copysign(zeta) / (zeta.abs() + (1.0 + zeta * zeta).sqrt());
                let cosine = 1.0 / (1.0 + tangent * tangent).sqrt();
                for m in [&mut u, &mut v] {
                    for i in 0..n {
                        let (a, b) = (m[(i, p)], m[(i, q)]);
                        m[(i, p)] = cosine * (a - tangent * b);
                        m[(i, q)] = cosine * (b + tangent * a);
                    }
                }
            }
        }
        if !rotated {
            break;
        }
    }
    let singular = DVector::from_iterator(n, u.column_iter().map(|c| c.norm()));
    (singular, v)
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    /// The Jacobian of r = c_0 + c_1 t - y and the cost of given deviations.
    fn line(t: &[f64]) -> DMatrix<f64> {
        DMatrix::from_fn(t.len(), 2, |i, j| if j == 0 { 1.0 } else { t[i] })
    }

    #[test]
    fn a_line_has_the_textbook_covariance() {
        let t = [0.3, 1.0, 2.5, 4.0, 7.0, 7.5];
        let cost = 0.7;
        let u = Uncertainty::new(&line(&t), cost, &[None, None]);
        let m = t.len() as f64;
        let mean = t.iter().sum::<f64>() / m;
        let sxx = t.iter().map(|t| (t - mean).powi(2)).sum::<f64>();
        let s2 = 2.0 * cost / (m - 2.0);
        assert_relative_eq!(u.variance.unwrap(), s2, max_relative = 1e-14);
        assert_relative_eq!(u.covariance[(1, 1)], s2 / sxx, max_relative = 1e-13);
        assert_relative_eq!(u.covariance[(0, 1)], -mean * s2 / sxx, max_relative = 1e-13);
        let intercept = s2 * (1.0 / m + mean * mean / sxx);
        assert_relative_eq!(u.covariance[(0, 0)], intercept, max_relative = 1e-13);
        assert_relative_eq!(u.standard_errors[0].unwrap(), intercept.sqrt(), max_relative = 1e-13);
        // Two unit columns with cosine c have the singular values sqrt(1 +- c).
        let c = t.iter().sum::<f64>() / (m * t.iter().map(|t| t * t).sum::<f64>()).sqrt();
        let condition = ((1.0 + c) / (1.0 - c)).sqrt();
        assert_relative_eq!(u.condition_number.unwrap(), condition, max_relative = 1e-12);
    }

    #[test]
    fn a_bound_takes_its_parameter_out() {
        let t = [1.0, 2.0, 4.0];
        let u = Uncertainty::new(&line(&t), 0.5, &[Some(Bound::Upper), None]);
        assert_eq!(u.standard_errors[0], None);
        let expected = 1.0 / (1.0 + 4.0 + 16.0);
        assert_relative_eq!(u.covariance[(1, 1)], expected, max_relative = 1e-14);
        assert_relative_eq!(u.condition_number.unwrap(), 1.0, max_relative = 1e-14);
        assert_eq!(u.covariance[(0, 0)], 0.0);
    }

    #[test]
    fn dependent_columns_leave_the_others_determined() {
        // Columns 0 and 2 are parallel, column 3 has no effect, column 1 stands alone.
        let j = DMatrix::from_row_slice(
            6,
            4,
            &[
                1.0, 1.0, -3.0, 0.0, 2.0, 0.0, -6.0, 0.0, 3.0, 1.0, -9.0, 0.0, 4.0, -2.0, -12.0, 0.0, 5.0, 0.5, -15.0,
                0.0, 6.0, 0.1, -18.0, 0.0,
            ],
        );
        let u = Uncertainty::new(&j, 1.0, &[None; 4]);
        assert_eq!(u.condition_number, None);
        assert_eq!(u.standard_errors[0], None);
        assert_eq!(u.standard_errors[2], None);
        assert_eq!(u.standard_errors[3], None);
        // The error of column 1 with column 0 projected out.
        let (a, b) = (j.column(0), j.column(1));
        let rest = b.norm_squared() - a.dot(&b).powi(2) / a.norm_squared();
        assert_relative_eq!(u.standard_errors[1].unwrap(), rest.recip().sqrt(), max_relative = 1e-12);
    }

    #[test]
    fn as_many_rows_as_parameters_leave_no_variance() {
        let u = Uncertainty::new(&DMatrix::identity(2, 2), 1.0, &[None, None]);
        assert_eq!(u.variance, None);
        assert_eq!(u.standard_errors, [None, None]);
        assert_relative_eq!(u.condition_number.unwrap(), 1.0);
        let wide = Uncertainty::new(&DMatrix::from_element(1, 2, 1.0), 1.0, &[None, None]);
        assert_eq!(wide.condition_number, None);
    }

    #[test]
    fn singular_values_of_a_graded_triangle_are_relatively_accurate() {
        // Kahan's form [1, -c; 0, s]: singular values from trace and determinant.
        let small = 1e-9;
        let (s, _) = one_sided_jacobi(DMatrix::from_row_slice(2, 2, &[1.0, 1.0, 0.0, small]));
        assert_relative_eq!(s.max() * s.min(), small, max_relative = 1e-14);
        assert_relative_eq!(s.norm_squared(), 2.0 + small * small, max_relative = 1e-14);
    }
}
