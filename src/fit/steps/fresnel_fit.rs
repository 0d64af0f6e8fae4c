//! Step 2: specular scale and Fresnel term from the theta_d slice (thesis V.4).
//!
//! `m_d(theta_d) ~ rho_d / pi + q(theta_d) rho_s F(theta_d)`, `q = A G1(theta_d)^2 / (c cos^2 theta_d)` with the model's `c`
//! ([`NormalDistribution::DIVISOR`]), linear in `u = rho_s (f0, f1, 1)`. The residual is weighted, the constraint on F is a cone in u: a convex problem in three unknowns.

use crate::lm;
use crate::lm::bounds::Bounds;
use crate::lm::problem::{LeastSquares, LmError};
use crate::lm::termination::Termination;
use crate::options::{Anchor, FitOptions, Loss, Step2Solver};
use crate::steps::distribution_fit::DistributionFit;
use crate::steps::fresnel_constraints::{HalfSpace, basis, conditions, extreme_rays};
use crate::steps::nnls::nnls;
use crate::steps::slice_rows::Row;
use brdfit_brdf::{Microfacet, MicrofacetParameters, NormalDistribution};
use nalgebra::{DMatrix, DVector, Matrix3, Vector3};
use std::f64::consts::PI;

/// Below this specular scale there is no specular part.
const NO_SPECULAR: f64 = 1e-12;

/// Result of step 2 for one channel.
#[derive(Clone, Debug)]
pub(crate) struct FresnelFit {
    /// `(rho_s, f0, f1)`; zeros where there is no specular part.
    pub(crate) rho_s: f64,
    pub(crate) f0: f64,
    pub(crate) f1: f64,
    /// Peak height A, 1/sr.
    pub(crate) anchor: f64,
    /// Whether the measured peak cell lies below half of the fitted lobe.
    pub(crate) peak_missed: bool,
    /// Half the sum of squared residuals, before a negligible specular part is dropped.
    pub(crate) cost: f64,
    /// Rows used.
    pub(crate) rows: usize,
    /// Iterations (0 for the exact solution).
    pub(crate) iterations: u64,
    /// Reason for termination.
    pub(crate) termination: Termination,
    /// Conditions that are active at the solution.
    pub(crate) active: Vec<String>,
    /// Of the column-scaled problem in u.
    pub(crate) condition_number: Option<f64>,
    /// Standard errors of rho_s, f0, f1.
    pub(crate) standard_errors: [Option<f64>; 3],
    diffuse: f64,
}

/// The rows of the theta_d slice and the options of step 2.
#[derive(Clone, Copy)]
pub(crate) struct FresnelTask<'a> {
    pub(crate) rows: &'a [Row],
    /// The sample angle theta_h of the whole slice.
    pub(crate) theta_h: f64,
    pub(crate) options: &'a FitOptions,
}

/// A channel after step 1.
#[derive(Clone, Copy)]
pub(crate) struct FittedLobe<'a, D> {
    pub(crate) step1: &'a DistributionFit<D>,
    /// R, G, B: 0, 1, 2.
    pub(crate) channel: usize,
    /// Its number among the channels of its step 1.
    pub(crate) n: usize,
    /// The first row of step 1.
    pub(crate) peak_row: &'a Row,
}

impl<D> FittedLobe<'_, D> {
    /// Height of the lobe implied by the measured peak cell: the ratio of its excess over the diffuse level to the fitted one.
    fn peak_ratio<const N: usize>(&self) -> f64
    where
        D: NormalDistribution<N>,
    {
        let rho_d = self.step1.rho_d[self.n];
        let lobe = PI * self.step1.curve_with_lobe(self.n, self.peak_row.theta) - rho_d;
        (PI * self.peak_row.measured[self.channel] - rho_d) / lobe
    }
}

/// The weighted linear problem `|design u - target|`.
struct Linear {
    design: DMatrix<f64>,
    target: DVector<f64>,
}

impl FresnelTask<'_> {
    /// Fits a channel.
    pub(crate) fn fit<D: NormalDistribution<N>, const N: usize>(
        &self,
        lobe: &FittedLobe<'_, D>,
    ) -> Result<FresnelFit, LmError> {
        let ratio = lobe.peak_ratio();
        let anchor = self.anchor(&lobe.step1.distribution, ratio);
        let diffuse = lobe.step1.rho_d[lobe.n] / PI;
        let transfer = |theta| transfer(&lobe.step1.distribution, anchor, theta);
        let linear = Linear::new(self.rows, lobe.channel, diffuse, transfer, self.options.loss);
        let conditions = conditions(self.options.constraint);
        let (u, iterations, termination) = self.solve(&linear, &conditions)?;
        let cost = linear.cost(&u);
        let dropped = if conditions.is_empty() { u.z.abs() <= NO_SPECULAR } else { u.z <= NO_SPECULAR };
        let [rho_s, f0, f1] = if dropped { [0.0; 3] } else { [u.z, u.x / u.z, u.y / u.z] };
        let active: Vec<&HalfSpace> = if dropped { Vec::new() } else { active_at(&conditions, &u) };
        Ok(FresnelFit {
            rho_s,
            f0,
            f1,
            anchor,
            peak_missed: ratio < 0.5 && !lobe.step1.is_flat(lobe.n),
            cost,
            rows: self.rows.len(),
            iterations,
            termination,
            condition_number: lm::Uncertainty::new(&linear.design, cost, &[None; 3]).condition_number,
            standard_errors: if dropped { [None; 3] } else { linear.standard_errors(&u, cost, &active) },
            active: match dropped {
                true => vec!["rho_s = 0".to_owned()],
                false => active.iter().map(|condition| condition.name.clone()).collect(),
            },
            diffuse,
        })
    }

    /// The peak height A: the distribution at the theta_h of the slice, scaled by the ratio of the peak cell.
    fn anchor<D: NormalDistribution<N>, const N: usize>(&self, distribution: &D, ratio: f64) -> f64 {
        let d0 = distribution.d_at(self.theta_h);
        match self.options.anchor {
            Anchor::Peak if ratio > 0.0 => d0 * ratio.max(0.5),
            Anchor::Peak | Anchor::Distribution => d0,
        }
    }

    /// The solution, its iterations, and why the solver stopped.
    fn solve(&self, linear: &Linear, conditions: &[HalfSpace]) -> Result<(Vector3<f64>, u64, Termination), LmError> {
        match (self.options.step2_solver, conditions.is_empty()) {
            (Step2Solver::Convex, _) => Ok((linear.solve_convex(conditions), 0, Termination::Gtol)),
            (Step2Solver::LevenbergMarquardt, true) => {
                linear.solve_by_lm(&DMatrix::identity(3, 3), false, self.options)
            }
            (Step2Solver::LevenbergMarquardt, false) => {
                let rays = extreme_rays(conditions);
                let generators = DMatrix::from_fn(3, rays.len(), |i, j| rays[j][i]);
                linear.solve_by_lm(&generators, true, self.options)
            }
        }
    }

    /// The cost of given parameters in one channel, with the peak height D(theta_h) of their own distribution.
    pub(crate) fn cost_of<D: NormalDistribution<N>, const N: usize>(
        &self,
        channel: usize,
        model: &Microfacet<D, N>,
    ) -> f64 {
        let MicrofacetParameters { rho_d, rho_s, f0, f1, .. } = *model.parameters();
        let d0 = model.distribution().d_at(self.theta_h);
        let transfer = |theta| transfer(model.distribution(), d0, theta);
        let linear = Linear::new(self.rows, channel, rho_d / PI, transfer, self.options.loss);
        linear.cost(&(Vector3::new(f0, f1, 1.0) * rho_s))
    }
}

impl FresnelFit {
    /// The fitted slice at theta_d, 1/sr.
    pub(crate) fn curve<D: NormalDistribution<N>, const N: usize>(&self, distribution: &D, theta_d: f64) -> f64 {
        let cos = libm::cos(theta_d);
        let specular = Vector3::new(self.f0, self.f1, 1.0).dot(&basis(cos)) * self.rho_s;
        self.diffuse + transfer(distribution, self.anchor, theta_d) * specular
    }
}

/// `q(theta_d) = A G1^2 / (c cos^2)`.
fn transfer<D: NormalDistribution<N>, const N: usize>(distribution: &D, anchor: f64, theta_d: f64) -> f64 {
    let ratio = distribution.g1(theta_d) / libm::cos(theta_d);
    anchor * ratio * ratio / D::DIVISOR
}

/// The conditions that hold with equality at `u`, up to rounding.
fn active_at<'a>(conditions: &'a [HalfSpace], u: &Vector3<f64>) -> Vec<&'a HalfSpace> {
    conditions.iter().filter(|c| c.normal.dot(u).abs() <= 1e-10 * c.normal.norm() * u.norm()).collect()
}

impl Linear {
    fn new(rows: &[Row], channel: usize, diffuse: f64, transfer: impl Fn(f64) -> f64, loss: Loss) -> Self {
        let mut design = DMatrix::zeros(rows.len(), 3);
        let mut target = DVector::zeros(rows.len());
        for (index, row) in rows.iter().enumerate() {
            let (measured, cos) = (row.measured[channel], libm::cos(row.theta));
            let q = transfer(row.theta);
            let weight = match loss {
                // d cbrt(m cos) up to a factor
                Loss::Log1pCos | Loss::SqrtCos => {
                    let root = libm::cbrt((measured * cos).max(1e-6));
                    cos / (root * root)
                }
                Loss::L2 => 1.0,
            };
            design.set_row(index, &(basis(cos) * (q * weight)).transpose());
            target[index] = weight * (measured - diffuse);
        }
        Self { design, target }
    }

    fn cost(&self, u: &Vector3<f64>) -> f64 {
        0.5 * (&self.design * u - &self.target).norm_squared()
    }

    /// The exact minimiser over the cone. With `design = Q R` and `y = Q^T target` it is the projection of `y` on the cone
    /// `{t = R u : E t >= 0}`, `E = N R^-1` (N: the normals), which by Moreau's decomposition is `y + E^T lambda` with
    /// `lambda >= 0` minimising `|E^T lambda + y|`: one non-negative least squares in three rows.
    fn solve_convex(&self, conditions: &[HalfSpace]) -> Vector3<f64> {
        // scaled columns keep R well away from underflow
        let scale = Vector3::from_fn(|j, _| match self.design.column(j).norm() {
            0.0 => 1.0,
            norm => 1.0 / norm,
        });
        let scaled = DMatrix::from_fn(self.design.nrows(), 3, |i, j| self.design[(i, j)] * scale[j]);
        let qr = scaled.qr();
        let r: Matrix3<f64> = qr.r().fixed_view::<3, 3>(0, 0).into();
        let y: Vector3<f64> = (qr.q().transpose() * &self.target).fixed_rows::<3>(0).into();
        let Some(inverse) = r.try_inverse() else { return Vector3::zeros() };
        let t = if conditions.is_empty() {
            y
        } else {
            let mut columns = DMatrix::zeros(3, conditions.len());
            for (j, condition) in conditions.iter().enumerate() {
                let row = inverse.transpose() * condition.normal.component_mul(&scale);
                columns.set_column(j, &row.normalize());
            }
            let target = DVector::from_column_slice((-y).as_slice());
            let lambda = nnls(&columns, &target);
            let shift = &columns * lambda;
            y + Vector3::new(shift[0], shift[1], shift[2])
        };
        (inverse * t).component_mul(&scale)
    }

    /// By Levenberg-Marquardt in the coefficients of `generators`, not negative if `bounded`.
    fn solve_by_lm(
        &self,
        generators: &DMatrix<f64>,
        bounded: bool,
        options: &FitOptions,
    ) -> Result<(Vector3<f64>, u64, Termination), LmError> {
        let design = &self.design * generators;
        let unknowns = design.ncols();
        // a common scale, so that the start's trust region has the size of the solution
        let scale = self.target.norm() / design.norm().max(f64::MIN_POSITIVE);
        let problem = LinearProblem { design: design * scale, target: &self.target };
        let lower = if bounded { 0.0 } else { f64::NEG_INFINITY };
        let bounds = Bounds::new(vec![lower; unknowns], vec![f64::INFINITY; unknowns])?;
        let lm_options = lm::Options { iteration_limit: options.max_iterations, ..lm::Options::default() };
        let solution = lm::minimise(&problem, &vec![1.0; unknowns], &bounds, &lm_options)?;
        let u = generators * DVector::from_vec(solution.parameters) * scale;
        Ok((Vector3::new(u[0], u[1], u[2]), solution.iterations, solution.termination))
    }

    /// Standard errors of (rho_s, f0, f1): `sigma^2 (W^T W)^-1` on the face of the cone where `u` lies, then the delta method.
    fn standard_errors(&self, u: &Vector3<f64>, cost: f64, active: &[&HalfSpace]) -> [Option<f64>; 3] {
        let mut normals: Vec<Vector3<f64>> = Vec::new();
        for condition in active {
            let rest = normals.iter().fold(condition.normal, |rest, n| rest - n * n.dot(&rest));
            if rest.norm() > 1e-6 * condition.normal.norm() {
                normals.push(rest.normalize());
            }
        }
        let mut tangents: Vec<Vector3<f64>> = Vec::new();
        for axis in [Vector3::z(), Vector3::x(), Vector3::y()] {
            let rest = normals.iter().chain(&tangents).fold(axis, |rest, n| rest - n * n.dot(&rest));
            if rest.norm() > 1e-6 && tangents.len() + normals.len() < 3 {
                tangents.push(rest.normalize());
            }
        }
        let free = tangents.len();
        if free == 0 || self.design.nrows() <= 3 {
            return [None; 3];
        }
        let variance = 2.0 * cost / (self.design.nrows() - 3) as f64;
        let tangent = DMatrix::from_fn(3, free, |i, j| tangents[j][i]);
        let reduced = &self.design * &tangent;
        let Some(inverse) = (reduced.transpose() * &reduced).try_inverse() else { return [None; 3] };
        let covariance = &tangent * inverse * tangent.transpose() * variance;
        let slopes = [
            Vector3::new(0.0, 0.0, 1.0),
            Vector3::new(1.0 / u.z, 0.0, -u.x / (u.z * u.z)),
            Vector3::new(0.0, 1.0 / u.z, -u.y / (u.z * u.z)),
        ];
        slopes.map(|slope| {
            let variance = (&covariance * slope).dot(&DVector::from_column_slice(slope.as_slice()));
            variance.is_finite().then(|| variance.max(0.0).sqrt())
        })
    }
}

struct LinearProblem<'a> {
    design: DMatrix<f64>,
    target: &'a DVector<f64>,
}

impl LeastSquares for LinearProblem<'_> {
    fn parameters(&self) -> usize {
        self.design.ncols()
    }

    fn rows(&self) -> usize {
        self.design.nrows()
    }

    fn residuals(&self, x: &[f64], r: &mut [f64]) {
        for (i, value) in r.iter_mut().enumerate() {
            *value = x.iter().enumerate().map(|(j, x)| self.design[(i, j)] * x).sum::<f64>() - self.target[i];
        }
    }

    fn residuals_and_jacobian(&self, x: &[f64], r: &mut [f64], j: &mut DMatrix<f64>) {
        self.residuals(x, r);
        j.copy_from(&self.design);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::options::Constraint;
    use proptest::prelude::*;

    fn linear(values: &[f64]) -> Linear {
        let n = values.len();
        let cosines: Vec<f64> = (0..n).map(|i| libm::cos((i as f64 / n as f64 * 75.0).to_radians())).collect();
        Linear {
            design: DMatrix::from_fn(n, 3, |i, j| basis(cosines[i])[j] / cosines[i]),
            target: DVector::from_fn(n, |i, _| values[i] / cosines[i]),
        }
    }

    proptest! {
        #[test]
        fn the_exact_solution_and_levenberg_marquardt_end_at_the_same_cost(values in prop::collection::vec(-0.2..1.5_f64, 40)) {
            let linear = linear(&values);
            for constraint in [Constraint::Free, Constraint::NonNegative, Constraint::Physical] {
                let conditions = conditions(constraint);
                let exact = linear.solve_convex(&conditions);
                for condition in &conditions {
                    prop_assert!(condition.normal.dot(&exact) >= -1e-9 * exact.norm(), "{}", condition.name);
                }
                let options = FitOptions::default();
                let (by_lm, ..) = if conditions.is_empty() {
                    linear.solve_by_lm(&DMatrix::identity(3, 3), false, &options).unwrap()
                } else {
                    let rays = extreme_rays(&conditions);
                    let generators = DMatrix::from_fn(3, rays.len(), |i, j| rays[j][i]);
                    linear.solve_by_lm(&generators, true, &options).unwrap()
                };
                let (a, b) = (linear.cost(&exact), linear.cost(&by_lm));
                prop_assert!((a - b).abs() <= 1e-8 * a, "{constraint:?}: {a} {b}");
            }
        }
    }

    #[test]
    fn a_schlick_curve_comes_back() {
        let truth = Vector3::new(0.3 * 0.5, 0.3 * 0.1, 0.3);
        let values: Vec<f64> =
            (0..50).map(|i| truth.dot(&basis(libm::cos((f64::from(i) / 50.0 * 75.0).to_radians())))).collect();
        for constraint in [Constraint::Free, Constraint::Physical] {
            let u = linear(&values).solve_convex(&conditions(constraint));
            assert!((u - truth).norm() < 1e-10, "{u}");
        }
    }
}
