//! The closed form of G1 fitted to Smith's integral (thesis V.3.3).

use crate::document::G1Fit;
use crate::lm;
use crate::lm::bounds::Bounds;
use crate::lm::problem::{LeastSquares, LmError};
use brdfit_brdf::{G1ClosedForm, Masking};
use nalgebra::DMatrix;
use std::f64::consts::{FRAC_PI_2, PI};
use wide::f64x4;

/// Bounds of ln lambda, theta0 and ln k.
const LOWER: [f64; 3] = [-16.0, -FRAC_PI_2, -3.0];
const UPPER: [f64; 3] = [16.0, 1.5, 7.0];
/// Starts as (lambda, theta0, k): from gentle to abrupt.
const STARTS: [[f64; 3]; 6] =
    [[1.0, 0.5, 3.0], [0.1, 0.0, 8.0], [10.0, 0.8, 15.0], [5.0, -0.5, 30.0], [0.01, -0.2, 20.0], [1e-6, 0.0, 2.0]];
/// The search runs on some fifty samples, dense towards the horizon and weighted by what they stand for: all starts for a few
/// iterations, the best of them on; the very best is finished on all samples.
const SEARCH_SAMPLES: usize = 48;
const ITERATIONS: [u64; 3] = [20, 60, 20];
const CONTENDERS: usize = 3;
/// Root mean square error that is good enough to stop searching: what is written has three digits more than any use of it.
const NEGLIGIBLE: f64 = 2e-5;
/// Relative change of the cost and of the unknowns at which a run stops (docs/theory.md, section 3.3).
const TOLERANCE: f64 = 1e-6;

/// Fits the closed form to a distribution's G1 on 1, 1.1, .., 89.9 degrees, unweighted.
///
/// Over the published 300 channels the root mean square error stays below 4e-4 and the largest below 1e-2
/// (docs/accuracy.md). The optimum is often a flat valley: compare curves, not parameters.
///
/// # Errors
/// Where the curve is not finite.
pub fn fit_g1(masking: &impl Masking) -> Result<G1Fit, LmError> {
    let all: Vec<Sample> = (10..900)
        .map(|n| {
            let theta = f64::from(n) * PI / 1800.0;
            Sample { theta, g1: masking.g1(theta), weight: 1.0 }
        })
        .collect();
    let bounds = Bounds::new(LOWER.to_vec(), UPPER.to_vec())?;
    let search = |problem: &Problem, start: &[f64], iteration_limit| {
        let cost_floor = 0.5 * NEGLIGIBLE * NEGLIGIBLE * problem.total_weight;
        let options =
            lm::Options { ftol: TOLERANCE, xtol: TOLERANCE, iteration_limit, cost_floor, ..lm::Options::default() };
        lm::minimise(problem, start, &bounds, &options)
    };
    let coarse = Problem::new(&towards_the_horizon(&all));
    let mut found = STARTS
        .iter()
        .map(|[lambda, theta0, k]| search(&coarse, &[libm::log(*lambda), *theta0, libm::log(*k)], ITERATIONS[0]))
        .collect::<Result<Vec<_>, _>>()?;
    found.sort_by(|a, b| a.cost.total_cmp(&b.cost));
    found.truncate(CONTENDERS);
    for solution in &mut found {
        *solution = search(&coarse, &solution.parameters, ITERATIONS[1])?;
    }
    let start = found.into_iter().min_by(|a, b| a.cost.total_cmp(&b.cost)).expect("there is a start").parameters;
    let solution = search(&Problem::new(&all), &start, ITERATIONS[2])?;
    let [ln_lambda, theta0, ln_k] = solution.parameters[..] else { unreachable!("three unknowns") };
    let form = G1ClosedForm { lambda: libm::exp(ln_lambda), theta0, k: libm::exp(ln_k) };
    let errors = || all.iter().map(|sample| form.g1(sample.theta) - sample.g1);
    Ok(G1Fit {
        lambda: form.lambda,
        theta0: form.theta0,
        k: form.k,
        log10_c: form.log10_c(),
        max_error: errors().map(f64::abs).fold(0.0, f64::max),
        rms_error: (errors().map(|error| error * error).sum::<f64>() / all.len() as f64).sqrt(),
    })
}

/// Samples at quadratically growing distances from the last one, each with the number of samples that it stands for.
fn towards_the_horizon(all: &[Sample]) -> Vec<Sample> {
    let last = all.len() - 1;
    let place = |k: usize| last - last * k * k / (SEARCH_SAMPLES * SEARCH_SAMPLES);
    (0..SEARCH_SAMPLES)
        .filter(|&k| place(k + 1) < place(k))
        .map(|k| Sample { weight: (place(k) - place(k + 1)) as f64, ..all[place(k)] })
        .collect()
}

/// One angle, its G1, and its weight in the sum of squares.
#[derive(Clone, Copy)]
struct Sample {
    theta: f64,
    g1: f64,
    weight: f64,
}

/// Samples, four at a time. Unknowns ln lambda, theta0, ln k.
struct Problem {
    samples: usize,
    thetas: Vec<f64x4>,
    targets: Vec<f64x4>,
    /// Roots of the weights.
    roots: Vec<f64x4>,
    total_weight: f64,
}

impl Problem {
    fn new(samples: &[Sample]) -> Self {
        let lanes = |value: fn(&Sample) -> f64| {
            let four = |chunk: &[Sample]| f64x4::from(std::array::from_fn(|n| value(&chunk[n.min(chunk.len() - 1)])));
            samples.chunks(4).map(four).collect()
        };
        Self {
            samples: samples.len(),
            thetas: lanes(|sample| sample.theta),
            targets: lanes(|sample| sample.g1),
            roots: lanes(|sample| sample.weight.sqrt()),
            total_weight: samples.iter().map(|sample| sample.weight).sum(),
        }
    }

    fn evaluate(&self, x: &[f64], r: &mut [f64], mut jacobian: Option<&mut DMatrix<f64>>) {
        let (lambda, theta0, k) = (libm::exp(x[0]), x[1], libm::exp(x[2]));
        let inverse_span = 1.0 / (FRAC_PI_2 - theta0);
        let growth = libm::log1p(1.0 / lambda);
        // lambda d growth / d lambda
        let growth_slope = -1.0 / (1.0 + lambda);
        let zero = f64x4::splat(0.0);
        for (block, ((&theta, &target), &root)) in self.thetas.iter().zip(&self.targets).zip(&self.roots).enumerate() {
            let t = (theta - theta0) * inverse_span;
            let masked = t.simd_gt(zero);
            let t = t.max(f64x4::splat(1e-300));
            let ln_t = t.ln();
            let power = (ln_t * k).exp();
            let rise = (power * growth).exp_m1();
            let value = (masked.select(1.0 - rise * lambda, f64x4::splat(1.0)) - target) * root;
            let first = 4 * block;
            let lanes = 4.min(self.samples - first);
            r[first..first + lanes].copy_from_slice(&value.to_array()[..lanes]);
            if let Some(j) = jacobian.as_deref_mut() {
                let steep = (rise + 1.0) * power * -lambda;
                let columns = [
                    steep * growth_slope - rise * lambda,
                    steep * (growth * k) / t * (theta - FRAC_PI_2) * (inverse_span * inverse_span),
                    steep * ln_t * (growth * k),
                ];
                for (column, values) in columns.into_iter().enumerate() {
                    let values = masked.select(values * root, zero).to_array();
                    for (lane, value) in values[..lanes].iter().enumerate() {
                        j[(first + lane, column)] = *value;
                    }
                }
            }
        }
    }
}

impl LeastSquares for Problem {
    fn parameters(&self) -> usize {
        3
    }

    fn rows(&self) -> usize {
        self.samples
    }

    fn residuals(&self, x: &[f64], r: &mut [f64]) {
        self.evaluate(x, r, None);
    }

    fn residuals_and_jacobian(&self, x: &[f64], r: &mut [f64], j: &mut DMatrix<f64>) {
        self.evaluate(x, r, Some(j));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use brdfit_brdf::{NormalDistribution, ShiftedGamma};

    #[test]
    fn is_close_to_the_integral_over_the_box_of_the_fit() {
        for alpha in [1e-6, 1e-4, 1e-2, 0.2, 1.0] {
            for p in [0.0, 0.5, 1.2] {
                let curve = ShiftedGamma::new(alpha, p).unwrap().masking();
                let fit = fit_g1(&curve).unwrap();
                assert!(fit.rms_error < 1e-3 && fit.max_error < 2e-2, "alpha {alpha} p {p}: {fit:?}");
                // the published parametrisation is the same curve, where its c fits in a double
                if fit.log10_c.abs() > 300.0 {
                    continue;
                }
                let printed =
                    G1ClosedForm::from_published(fit.lambda, libm::exp(fit.log10_c * std::f64::consts::LN_10), fit.k);
                assert!((printed.g1(1.5) - curve.g1(1.5)).abs() < 2e-2);
            }
        }
    }

    #[test]
    fn slopes_agree_with_central_differences() {
        let samples: Vec<Sample> =
            (1..15).map(|n| Sample { theta: 0.1 * f64::from(n), g1: 0.9, weight: f64::from(n) }).collect();
        let problem = Problem::new(&samples);
        let x = [-0.7, 0.25, 1.9];
        let rows = samples.len();
        let (mut r, mut j) = (vec![0.0; rows], DMatrix::zeros(rows, 3));
        problem.residuals_and_jacobian(&x, &mut r, &mut j);
        for column in 0..3 {
            let at = |h: f64| {
                let mut moved = x;
                moved[column] += h;
                let mut r = vec![0.0; rows];
                problem.residuals(&moved, &mut r);
                r
            };
            for (row, (a, b)) in at(1e-6).iter().zip(at(-1e-6)).enumerate() {
                assert!((j[(row, column)] - (a - b) / 2e-6).abs() < 1e-8);
            }
        }
    }
}
