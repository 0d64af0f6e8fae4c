//! The interface of least-squares problems, and the errors of invalid ones.

use nalgebra::DMatrix;

/// A nonlinear least-squares problem: minimise 1/2 sum r_i(x)^2.
///
/// The solver owns all buffers and hands them out, so an implementation need not allocate. A point where the residual
/// does not exist is reported by writing a NaN or an infinity: the solver then takes a shorter step.
pub trait LeastSquares {
    /// Number of parameters, the length of x.
    fn parameters(&self) -> usize;

    /// Number of residuals, the length of r.
    fn rows(&self) -> usize;

    /// Writes the residuals at `x` to `r`, every one of them.
    fn residuals(&self, x: &[f64], r: &mut [f64]);

    /// Writes the residuals at `x` to `r` and their derivatives J = dr/dx to `j` (rows x parameters): every entry, as the
    /// buffers hold values of another point.
    fn residuals_and_jacobian(&self, x: &[f64], r: &mut [f64], j: &mut DMatrix<f64>);
}

impl<T: LeastSquares + ?Sized> LeastSquares for &T {
    fn parameters(&self) -> usize {
        (**self).parameters()
    }

    fn rows(&self) -> usize {
        (**self).rows()
    }

    fn residuals(&self, x: &[f64], r: &mut [f64]) {
        (**self).residuals(x, r);
    }

    fn residuals_and_jacobian(&self, x: &[f64], r: &mut [f64], j: &mut DMatrix<f64>) {
        (**self).residuals_and_jacobian(x, r, j);
    }
}

/// Errors of starting a minimisation.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum LmError {
    /// Empty problem.
    #[error("empty least-squares problem: {rows} rows and {parameters} parameters; both must be at least 1")]
    Empty {
        /// Rows of the problem.
        rows: usize,
        /// Parameters of the problem.
        parameters: usize,
    },
    /// The start or the bounds do not have one entry per parameter.
    #[error("{what} has {found} entries where the problem has {expected} parameters")]
    Length {
        /// The vector.
        what: &'static str,
        /// Parameters of the problem.
        expected: usize,
        /// Entries of the vector.
        found: usize,
    },
    /// A bound is NaN, an infinity of the wrong sign, or the lower one lies above the upper one.
    #[error("parameter {index} has empty bounds [{lower}, {upper}]")]
    Bounds {
        /// Index of the parameter.
        index: usize,
        /// Its lower bound.
        lower: f64,
        /// Its upper bound.
        upper: f64,
    },
    /// A parameter of the start is NaN, or infinite after projection.
    #[error("the start is not finite: parameter {index} is {value}")]
    Start {
        /// Index of the parameter.
        index: usize,
        /// Its value.
        value: f64,
    },
    /// The residuals at the start are not finite, or their sum of squares overflows.
    #[error("the residuals at the start are not finite")]
    Residuals,
    /// The Jacobian at the start is not finite, or a column's sum of squares overflows.
    #[error("the Jacobian at the start is not finite in the column of parameter {index}")]
    Jacobian {
        /// Index of the parameter.
        index: usize,
    },
    /// argmin's executor failed for a reason of its own.
    #[error("argmin: {0}")]
    Framework(String),
}
