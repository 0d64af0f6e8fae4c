//! Bounded Levenberg-Marquardt: the nonlinear least-squares solver behind both steps of the fit.
//!
//! [`minimise`] finds a local minimum of the cost 1/2 sum r_i(x)^2 over a box lower <= x <= upper. The method is the
//! trust-region form of Levenberg-Marquardt of Moré, "The Levenberg-Marquardt algorithm: implementation and theory"
//! (1978), with two changes for the box:
//!
//! - Every step is the *exact* minimiser of the damped linear model over the box (and not an unconstrained step that is
//!   clipped afterwards), found by an active-set method on the triangular factor of the Jacobian. Where a bound is hit,
//!   the other parameters move to their best values on that face in the same step, so the solver does not crawl
//!   along a bound that crosses a valley, and a parameter at a bound equals it bit by bit.
//! - The convergence tests look at the free parameters only: those that are not held by a bound with the gradient
//!   pointing outward.
//!
//! Columns are scaled by the largest norm seen, but scales that have drifted far from each other's norms are taken anew
//! when progress ends or takes long; the damped systems are solved by QR factorisation of the stacked matrix,
//! never by normal equations, so that accuracy goes with the condition number of the Jacobian and not with its square.
//! All sums run in a fixed order: same input, same bytes.
//!
//! The solver is an argmin [`Solver`](argmin::core::Solver), [`LevenbergMarquardt`]; [`minimise`] runs it with argmin's
//! executor, without observers. Anything that argmin offers (observers, time limits) is available by using the
//! type directly:
//!
//! ```
//! use argmin::core::Executor;
//! use brdfit_fit::lm::{Bounds, LeastSquares, LevenbergMarquardt, Options};
//! use nalgebra::DMatrix;
//!
//! /// r = (10 (x_1 - x_0^2), 1 - x_0), Rosenbrock's valley.
//! struct Valley;
//!
//! impl LeastSquares for Valley {
//!     fn parameters(&self) -> usize {
//!         2
//!     }
//!     fn rows(&self) -> usize {
//!         2
//!     }
//!     fn residuals(&self, x: &[f64], r: &mut [f64]) {
//!         r[0] = 10.0 * (x[1] - x[0] * x[0]);
//!         r[1] = 1.0 - x[0];
//!     }
//!     fn residuals_and_jacobian(&self, x: &[f64], r: &mut [f64], j: &mut DMatrix<f64>) {
//!         self.residuals(x, r);
//!         j[(0, 0)] = -20.0 * x[0];
//!         j[(0, 1)] = 10.0;
//!         j[(1, 0)] = -1.0;
//!         j[(1, 1)] = 0.0;
//!     }
//! }
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! let bounds = Bounds::new(vec![-2.0, -2.0], vec![0.5, 2.0])?;
//! let solver = LevenbergMarquardt::new(bounds, Options::default());
//! let result = Executor::new(Valley, solver)
//!     .configure(|state| state.param(vec![-1.2, 1.0].into()).max_iters(100))
//!     .ctrlc(false)
//!     .run()?;
//! let solution = result.solver.into_solution(result.state);
//! assert_eq!(solution.parameters[0], 0.5);
//! assert!((solution.parameters[1] - 0.25).abs() < 1e-12);
//! # Ok(())
//! # }
//! ```

pub(crate) mod bounds;
pub(crate) mod model;
pub(crate) mod problem;
pub(crate) mod solution;
pub(crate) mod solver;
pub(crate) mod termination;
pub(crate) mod trial;
pub(crate) mod triangle;
pub(crate) mod uncertainty;

pub use bounds::{Bound, Bounds};
pub use problem::{LeastSquares, LmError};
pub use solution::Solution;
pub use solver::{LevenbergMarquardt, LmState};
pub use termination::{Options, Termination};
pub use uncertainty::Uncertainty;

use argmin::core::Executor;

/// Minimises 1/2 sum r_i^2 of `problem` over the box `bounds`, from `start` (projected on the box first).
///
/// The result is a local minimum, or the best point at the iteration limit: look at
/// [`termination`](Solution::termination). The cost never exceeds that of the projected start.
///
/// # Errors
///
/// [`LmError`] if the problem has no rows or parameters, lengths differ, or the start, its residuals or its Jacobian
/// are not finite. A value that is not finite at a later point only rejects the step that led there.
pub fn minimise<P: LeastSquares>(
    problem: &P,
    start: &[f64],
    bounds: &Bounds,
    options: &Options,
) -> Result<Solution, LmError> {
    let solver = LevenbergMarquardt::new(bounds.clone(), options.clone());
    let result = Executor::new(problem, solver)
        .configure(|state| state.param(start.to_vec().into()).max_iters(options.iteration_limit))
        .ctrlc(false)
        .timer(false)
        .run()
        .map_err(|error| match error.downcast::<LmError>() {
            Ok(error) => error,
            Err(other) => LmError::Framework(other.to_string()),
        })?;
    Ok(result.solver.into_solution(result.state))
}
