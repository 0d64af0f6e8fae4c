//! Non-negative least squares.

use nalgebra::{DMatrix, DVector};

/// The `x >= 0` that minimises `|A x - b|`, by the active-set method of Lawson & Hanson (Solving Least Squares Problems, 1974,
/// chapter 23). Finite; the passive columns are solved by SVD, so nearly parallel columns do no harm.
///
/// Exactly zero where a bound is active. Meant for few rows (step 2 has three) and up to some hundred columns.
pub(crate) fn nnls(a: &DMatrix<f64>, b: &DVector<f64>) -> DVector<f64> {
    let columns = a.ncols();
    let scale = a.column_iter().map(|column| column.norm()).fold(0.0, f64::max) * b.norm();
    let tolerance = 1e-14 * scale;
    let mut x = DVector::zeros(columns);
    let mut passive: Vec<usize> = Vec::new();
    for _ in 0..10 * columns + 10 {
        let gradient = a.transpose() * (b - a * &x);
        let entering = (0..columns)
            .filter(|j| !passive.contains(j) && gradient[*j] > tolerance)
            .max_by(|&i, &j| gradient[i].total_cmp(&gradient[j]).then(j.cmp(&i)));
        let Some(entering) = entering else { break };
        passive.push(entering);
        let mut fresh = true;
        loop {
            let trial = solve(a, b, &passive);
            if fresh && trial[passive.len() - 1] <= 0.0 {
                // rounding alone made the column attractive
                passive.pop();
                return x;
            }
            fresh = false;
            if trial.iter().all(|&value| value > 0.0) {
                for (&j, &value) in passive.iter().zip(trial.iter()) {
                    x[j] = value;
                }
                break;
            }
            // as far towards the trial as non-negativity allows; what reaches zero leaves
            let step = passive
                .iter()
                .zip(trial.iter())
                .filter(|&(_, &value)| value <= 0.0)
                .map(|(&j, &value)| x[j] / (x[j] - value))
                .fold(1.0, f64::min);
            for (&j, &value) in passive.iter().zip(trial.iter()) {
                x[j] += step * (value - x[j]);
                if value <= 0.0 && x[j] <= 1e-15 * value.abs() {
                    x[j] = 0.0;
                }
            }
            passive.retain(|&j| x[j] > 0.0);
            if passive.is_empty() {
                break;
            }
        }
    }
    x
}

fn solve(a: &DMatrix<f64>, b: &DVector<f64>, passive: &[usize]) -> DVector<f64> {
    let selected = a.select_columns(passive);
    let svd = selected.svd(true, true);
    let cut = 1e-14 * svd.singular_values.max();
    svd.solve(b, cut).expect("both factors were computed")
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        /// The Karush-Kuhn-Tucker conditions characterise the solution.
        #[test]
        fn satisfies_the_optimality_conditions(
            entries in prop::collection::vec(-1.0..1.0_f64, 3 * 20), b in prop::collection::vec(-1.0..1.0_f64, 3)
        ) {
            let a = DMatrix::from_vec(3, 20, entries);
            let b = DVector::from_vec(b);
            let x = nnls(&a, &b);
            let gradient = a.transpose() * (&b - &a * &x);
            for j in 0..20 {
                prop_assert!(x[j] >= 0.0);
                prop_assert!(gradient[j] <= 1e-10);
                prop_assert!(x[j] * gradient[j].abs() <= 1e-9);
            }
        }
    }

    #[test]
    fn a_textbook_case() {
        // minimise |x0 - 1|^2 + |x1 + 1|^2: x = (1, 0)
        let x = nnls(&DMatrix::identity(2, 2), &DVector::from_vec(vec![1.0, -1.0]));
        assert_eq!(x.as_slice(), [1.0, 0.0]);
    }
}
