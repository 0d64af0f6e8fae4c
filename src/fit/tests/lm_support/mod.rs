//! Test problems for the solver, with exact derivatives, and a second solver.
//!
//! Each test program uses a part of it.
#![allow(dead_code, unreachable_pub)]

pub mod dual;
pub mod nist;
pub mod problems;

use brdfit_fit::lm::{Bounds, LeastSquares};
use dual::Dual;
use nalgebra::DMatrix;
use rmpfit::{MPConfig, MPFitter, MPMaxFev, MPPar, MPResult, MPSide};

/// Residuals as a function of dual numbers.
pub type Residuals = Box<dyn Fn(&[Dual], &mut [Dual])>;

/// A test problem.
pub struct Problem {
    pub name: String,
    pub rows: usize,
    pub start: Vec<f64>,
    pub residuals: Residuals,
}

impl Problem {
    pub fn new(
        name: impl Into<String>,
        rows: usize,
        start: &[f64],
        residuals: impl Fn(&[Dual], &mut [Dual]) + 'static,
    ) -> Self {
        Self { name: name.into(), rows, start: start.to_vec(), residuals: Box::new(residuals) }
    }

    /// The sum of squares at `x`.
    pub fn sum_of_squares(&self, x: &[f64]) -> f64 {
        let mut r = vec![0.0; self.rows];
        self.residuals(x, &mut r);
        r.iter().map(|r| r * r).sum()
    }
}

impl LeastSquares for Problem {
    fn parameters(&self) -> usize {
        self.start.len()
    }

    fn rows(&self) -> usize {
        self.rows
    }

    fn residuals(&self, x: &[f64], r: &mut [f64]) {
        let x: Vec<Dual> = x.iter().map(|&x| x.into()).collect();
        let mut out = vec![Dual::from(f64::NAN); self.rows];
        (self.residuals)(&x, &mut out);
        for (r, out) in r.iter_mut().zip(out) {
            *r = out.value;
        }
    }

    fn residuals_and_jacobian(&self, x: &[f64], r: &mut [f64], j: &mut DMatrix<f64>) {
        let mut x: Vec<Dual> = x.iter().map(|&x| x.into()).collect();
        let mut out = vec![Dual::from(f64::NAN); self.rows];
        for column in 0..x.len() {
            x[column].slope = 1.0;
            (self.residuals)(&x, &mut out);
            x[column].slope = 0.0;
            for (row, out) in out.iter().enumerate() {
                r[row] = out.value;
                j[(row, column)] = out.slope;
            }
        }
    }
}

struct Second<'a> {
    problem: &'a Problem,
    parameters: Vec<MPPar>,
    config: MPConfig,
}

impl MPFitter for Second<'_> {
    fn eval(&mut self, x: &[f64], deviates: &mut [f64]) -> MPResult<()> {
        self.problem.residuals(x, deviates);
        Ok(())
    }

    fn number_of_points(&self) -> usize {
        self.problem.rows
    }

    fn config(&self) -> &MPConfig {
        &self.config
    }

    fn parameters(&self) -> &[MPPar] {
        &self.parameters
    }
}

/// The sum of squares that rmpfit, with central differences, reaches from `start`.
pub fn second_solver(problem: &Problem, start: &[f64], bounds: &Bounds) -> f64 {
    let parameters = bounds
        .lower()
        .iter()
        .zip(bounds.upper())
        .map(|(&l, &u)| MPPar {
            limited_low: l.is_finite(),
            limited_up: u.is_finite(),
            limit_low: l,
            limit_up: u,
            side: MPSide::Both,
            ..MPPar::new()
        })
        .collect();
    let config = MPConfig {
        ftol: 1e-14,
        xtol: 1e-14,
        gtol: 1e-14,
        max_iter: 5000,
        max_fev: MPMaxFev::NoLimit,
        ..MPConfig::new()
    };
    let mut x = start.to_vec();
    let mut solver = Second { problem, parameters, config };
    match solver.mpfit(&mut x) {
        Ok(_) => problem.sum_of_squares(&x),
        Err(error) => panic!("rmpfit failed on {}: {error}", problem.name),
    }
}
