//! A trial point and its buffers.

use crate::lm::problem::LeastSquares;
use crate::lm::triangle::dot;
use nalgebra::{DMatrix, DVector};

/// A trial point.
#[derive(Debug, Clone)]
pub(super) struct Trial {
    pub(super) x: DVector<f64>,
    pub(super) r: DVector<f64>,
    pub(super) jacobian: DMatrix<f64>,
    pub(super) gradient: DVector<f64>,
    /// Norms of the Jacobian's columns.
    pub(super) norms: DVector<f64>,
}

impl Trial {
    /// Room for a problem of that size.
    pub(super) fn new(rows: usize, parameters: usize) -> Self {
        Self {
            x: DVector::zeros(parameters),
            r: DVector::zeros(rows),
            jacobian: DMatrix::zeros(rows, parameters),
            gradient: DVector::zeros(parameters),
            norms: DVector::zeros(parameters),
        }
    }

    /// Computes the residuals at x, and the Jacobian if asked for. The cost, or none if it is not finite.
    pub(super) fn evaluate<P: LeastSquares>(&mut self, problem: &P, jacobian: bool) -> Option<f64> {
        let (x, r) = (self.x.as_slice(), self.r.as_mut_slice());
        if jacobian {
            problem.residuals_and_jacobian(x, r, &mut self.jacobian);
        } else {
            problem.residuals(x, r);
        }
        let cost = 0.5 * dot(r, r);
        cost.is_finite().then_some(cost)
    }

    /// Column norms and the gradient J^T r; the index of a column that is not finite.
    pub(super) fn differentiate(&mut self) -> Result<(), usize> {
        for (j, column) in self.jacobian.column_iter().enumerate() {
            let column = column.as_slice();
            self.norms[j] = dot(column, column).sqrt();
            self.gradient[j] = dot(column, self.r.as_slice());
            if !(self.norms[j].is_finite() && self.gradient[j].is_finite()) {
                return Err(j);
            }
        }
        Ok(())
    }
}
