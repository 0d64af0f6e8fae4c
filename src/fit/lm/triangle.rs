//! Householder triangularisation: the R of a QR factorisation, where Q is not needed.
//!
//! For the small and narrow matrices here it takes a third of the time of nalgebra's general `QR`.

use nalgebra::{DMatrix, DVector};

/// Replaces `m` by the factor R of its QR factorisation (Golub and Van Loan, Matrix Computations, algorithm 5.2.1). The
/// entries below the diagonal are left without meaning, those on it may have either sign.
///
/// With a right-hand side as the last column, that column becomes Q^T times it.
pub(super) fn triangularise(m: &mut DMatrix<f64>) {
    let (rows, columns) = m.shape();
    let mut rest = m.as_mut_slice();
    for k in 0..columns.min(rows) {
        let (column, others) = rest.split_at_mut(rows);
        let axis = &mut column[k..];
        let norm = dot(axis, axis).sqrt();
        if norm > 0.0 {
            // The reflection I - v v^T / (norm |v_0|) takes the column to -+norm e_0, without cancellation in v_0.
            let image = -norm.copysign(axis[0]);
            axis[0] -= image;
            let scale = 1.0 / (norm * axis[0].abs());
            for other in others.chunks_exact_mut(rows) {
                let other = &mut other[k..];
                let factor = scale * dot(axis, other);
                for (o, a) in other.iter_mut().zip(axis.iter()) {
                    *o -= factor * a;
                }
            }
            axis[0] = image;
        }
        rest = others;
    }
}

/// Solves R z = c for the leading `c.len()` rows and columns of the upper triangle `r`. None if its diagonal has a zero
/// or the solution is not finite.
pub(super) fn solve(r: &DMatrix<f64>, c: &[f64]) -> Option<DVector<f64>> {
    let mut z = DVector::from_column_slice(c);
    for i in (0..c.len()).rev() {
        z[i] /= r[(i, i)];
        for h in 0..i {
            z[h] -= r[(h, i)] * z[i];
        }
    }
    z.iter().all(|z| z.is_finite()).then_some(z)
}

/// Solves R^T w = z for the leading `z.len()` rows and columns of the upper triangle `r`, which must have no zero on its
/// diagonal.
pub(super) fn solve_transposed(r: &DMatrix<f64>, z: &DVector<f64>) -> DVector<f64> {
    let mut w = z.clone();
    for i in 0..z.len() {
        for h in 0..i {
            w[i] -= r[(h, i)] * w[h];
        }
        w[i] /= r[(i, i)];
    }
    w
}

/// The dot product, in four interleaved sums: a fixed order that leaves room for vector instructions.
pub(super) fn dot(a: &[f64], b: &[f64]) -> f64 {
    let (a_body, a_tail) = a.as_chunks::<4>();
    let (b_body, b_tail) = b.as_chunks::<4>();
    let mut sums = [0.0; 4];
    for (a, b) in a_body.iter().zip(b_body) {
        for lane in 0..4 {
            sums[lane] += a[lane] * b[lane];
        }
    }
    let mut sum = (sums[0] + sums[1]) + (sums[2] + sums[3]);
    for (a, b) in a_tail.iter().zip(b_tail) {
        sum += a * b;
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn the_triangle_is_that_of_nalgebra_up_to_signs(
            rows in 1usize..12,
            columns in 1usize..6,
            entries in prop::collection::vec(-1.0f64..1.0, 72),
        ) {
            let m = DMatrix::from_column_slice(rows, columns, &entries[..rows * columns]);
            let expected = nalgebra::QR::new(m.clone()).unpack_r();
            let mut ours = m.clone();
            triangularise(&mut ours);
            for i in 0..rows.min(columns) {
                // A row is as accurate as the columns of the matrix are large, and as its pivot is.
                prop_assume!(expected[(i, i)].abs() > 1e-3);
                let sign = ours[(i, i)].signum() * expected[(i, i)].signum();
                for j in i..columns {
                    prop_assert!((sign * ours[(i, j)] - expected[(i, j)]).abs() < 1e-11);
                }
            }
        }
    }

    #[test]
    fn zero_columns_pass_through() {
        let mut m = DMatrix::from_row_slice(3, 2, &[0.0, 3.0, 0.0, 4.0, 0.0, 0.0]);
        triangularise(&mut m);
        assert_eq!(m[(0, 0)], 0.0);
        assert_eq!(m[(0, 1)], 3.0);
        assert_relative_eq!(m[(1, 1)].abs(), 4.0);
    }

    #[test]
    fn triangular_systems_are_solved() {
        let r = DMatrix::from_row_slice(2, 2, &[2.0, 1.0, f64::NAN, 4.0]);
        assert_eq!(solve(&r, &[5.0, 8.0]).unwrap().as_slice(), [1.5, 2.0]);
        let w = solve_transposed(&r, &DVector::from_vec(vec![2.0, 9.0]));
        assert_eq!(w.as_slice(), [1.0, 2.0]);
        assert_eq!(solve(&DMatrix::zeros(1, 1), &[1.0]), None);
    }
}
