//! The result of a minimisation.

use crate::lm::bounds::Bound;
use crate::lm::termination::Termination;
use crate::lm::uncertainty::Uncertainty;
use nalgebra::{DMatrix, DVector};

/// A local minimum, or where the solver had to stop.
#[derive(Debug, Clone, PartialEq)]
pub struct Solution {
    /// The parameters. One that is at a bound equals it bit by bit.
    pub parameters: Vec<f64>,
    /// 1/2 sum r_i^2.
    pub cost: f64,
    /// The residuals r at the parameters.
    pub residuals: DVector<f64>,
    /// The Jacobian J = dr/dx at the parameters, rows x parameters.
    pub jacobian: DMatrix<f64>,
    /// The gradient J^T r of the cost.
    pub gradient: DVector<f64>,
    /// Trial points, accepted or not.
    pub iterations: u64,
    /// Evaluations of the residuals, with or without their Jacobian.
    pub residual_evaluations: u64,
    /// Evaluations of the Jacobian.
    pub jacobian_evaluations: u64,
    /// Reason for the termination of the solver.
    pub termination: Termination,
    /// The bound that each parameter sits at, if any; the lower one for a fixed parameter.
    pub active: Vec<Option<Bound>>,
}

impl Solution {
    /// Covariance, standard errors and conditioning of the linear model at the solution. Computed at every call.
    pub fn uncertainty(&self) -> Uncertainty {
        Uncertainty::new(&self.jacobian, self.cost, &self.active)
    }

    /// The measure of the gtol test: the largest |cosine| between the residual and the column of a parameter that no
    /// bound holds. 0 if there is none, or if the residual is zero.
    pub fn largest_cosine(&self) -> f64 {
        let size = self.residuals.norm();
        let mut largest = 0.0f64;
        for (j, bound) in self.active.iter().enumerate() {
            let gradient = self.gradient[j];
            let held = match bound {
                Some(Bound::Lower) => gradient > 0.0,
                Some(Bound::Upper) => gradient < 0.0,
                None => false,
            };
            let norm = self.jacobian.column(j).norm();
            if !held && norm > 0.0 && size > 0.0 {
                largest = largest.max(gradient.abs() / (norm * size));
            }
        }
        largest
    }
}
