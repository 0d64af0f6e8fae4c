//! The iteration: trial points, their acceptance, the trust region and the convergence tests.

use crate::lm::bounds::{Bound, Bounds};
use crate::lm::model::{LinearModel, Step};
use crate::lm::problem::{LeastSquares, LmError};
use crate::lm::solution::Solution;
use crate::lm::termination::{Options, Termination};
use crate::lm::trial::Trial;
use argmin::core::{Error, IterState, KV, Problem, Solver, State, TerminationReason};
use nalgebra::{DMatrix, DVector};

/// The state that argmin carries: parameters, gradient of the cost, Jacobian, no Hessian, residuals.
pub type LmState = IterState<DVector<f64>, DVector<f64>, DMatrix<f64>, (), DVector<f64>, f64>;

/// Least ratio of actual to predicted decrease at which a trial point is accepted (MINPACK's).
const ACCEPTANCE: f64 = 1e-4;

/// A change of the cost, relative to it, that is rounding rather than progress.
const ROUNDING: f64 = 1e-14;

/// Largest ratio between the free columns' quotients of scale and norm. Beyond it the scales have drifted, and are taken
/// anew when the solver would stop for a short step or at the latest after [`PATIENCE`] iterations: a start where one
/// column is huge (an exponential far out) would otherwise forbid steps in its parameter for ever. On 20000 random boxed
/// problems of the tests' set, 31 did not converge with 1e3, none with 10; 3 makes large-residual problems ten times slower.
const DRIFT: f64 = 10.0;

/// Iterations after which drifted scales are recomputed.
const PATIENCE: u64 = 50;

/// Box-bounded Levenberg-Marquardt as an argmin [`Solver`] for any [`LeastSquares`] problem.
///
/// One iteration of argmin is one trial point, accepted or not. The state's parameters, cost, residuals, Jacobian and
/// gradient always belong together and to the best point so far. The limit of iterations is the state's (`max_iters`),
/// which [`minimise`](super::minimise) sets from the options; the start is the state's `param`.
#[derive(Debug, Clone)]
pub struct LevenbergMarquardt {
    bounds: Bounds,
    options: Options,
    /// Norms of the Jacobian's columns at the state's point.
    norms: DVector<f64>,
    /// Largest norm seen of each column.
    scale: DVector<f64>,
    /// The iteration in which the scales were last recomputed.
    rescaled: u64,
    /// Radius of the trust region, in scaled parameters.
    radius: f64,
    /// Damping of the last step, the first guess of the next.
    damping: f64,
    /// The model around the state's point.
    model: Option<LinearModel>,
    /// The bounds that hold parameters at the state's point.
    held: Vec<Option<Bound>>,
    /// Buffers of the trial point; they change places with those of the state when it is accepted.
    trial: Trial,
    /// No trial point has been accepted yet.
    fresh: bool,
    /// The last trial point had values that are not finite.
    non_finite: bool,
    residual_evaluations: u64,
    jacobian_evaluations: u64,
    termination: Option<Termination>,
}

impl LevenbergMarquardt {
    /// A solver within `bounds`.
    pub fn new(bounds: Bounds, options: Options) -> Self {
        let n = bounds.parameters();
        Self {
            bounds,
            options,
            norms: DVector::zeros(n),
            scale: DVector::zeros(n),
            rescaled: 0,
            radius: 0.0,
            damping: 0.0,
            model: None,
            held: vec![None; n],
            trial: Trial::new(0, 0),
            fresh: true,
            non_finite: false,
            residual_evaluations: 0,
            jacobian_evaluations: 0,
            termination: None,
        }
    }

    /// Why the solver stopped; none while it runs, or if argmin stopped it.
    pub fn termination(&self) -> Option<Termination> {
        self.termination
    }

    /// The solution, from the state in which argmin's executor left it.
    ///
    /// # Panics
    ///
    /// If `state` is not that of a run of this solver.
    pub fn into_solution(self, mut state: LmState) -> Solution {
        let termination = self.termination.unwrap_or_else(|| match state.get_termination_reason() {
            Some(TerminationReason::MaxItersReached) => Termination::IterationLimit,
            _ => Termination::Stopped,
        });
        let whole = "the state of a finished run holds its point";
        let parameters = state.take_param().expect(whole);
        let active = parameters.iter().enumerate().map(|(j, &x)| self.bounds.active(j, x)).collect();
        Solution {
            parameters: parameters.data.into(),
            cost: state.get_cost(),
            residuals: state.take_residuals().expect(whole),
            jacobian: state.take_jacobian().expect(whole),
            gradient: state.take_gradient().expect(whole),
            iterations: state.get_iter(),
            residual_evaluations: self.residual_evaluations,
            jacobian_evaluations: self.jacobian_evaluations,
            termination,
            active,
        }
    }

    /// Makes the state's point the centre of a new model, and returns the reason to stop there, if there is one.
    fn centre(&mut self, state: &LmState) -> Option<Termination> {
        let (Some(x), Some(r), Some(jacobian), Some(gradient)) =
            (&state.param, &state.residuals, &state.jacobian, &state.grad)
        else {
            return Some(Termination::Stopped);
        };
        self.norms.copy_from(&self.trial.norms);
        for (scale, &norm) in self.scale.iter_mut().zip(self.norms.iter()) {
            *scale = scale.max(norm);
        }
        for (j, held) in self.held.iter_mut().enumerate() {
            *held = self.bounds.holding(j, x[j], gradient[j]);
        }
        if state.cost <= self.options.cost_floor {
            return Some(Termination::ZeroResidual);
        }
        let size = (2.0 * state.cost).sqrt();
        let mut cosine = 0.0f64;
        for j in (0..x.len()).filter(|&j| self.held[j].is_none()) {
            let norm = self.norms[j];
            if norm > 0.0 {
                cosine = cosine.max(gradient[j].abs() / (norm * size));
            }
        }
        if cosine <= self.options.gtol {
            return Some(Termination::Gtol);
        }
        self.model = Some(self.model_at(x, r, jacobian));
        None
    }

    /// The model with the current scales.
    fn model_at(&self, x: &DVector<f64>, r: &DVector<f64>, jacobian: &DMatrix<f64>) -> LinearModel {
        let scale = DVector::from_fn(x.len(), |j, _| self.scale_of(j));
        LinearModel::new(x, r, jacobian, &scale, &self.bounds, self.held.clone())
    }

    /// Recomputes the scales from the columns' norms at the state's point, and begins with a new trust region, if the
    /// scales of the free parameters have drifted. False, and nothing changed, if not.
    fn rescale(&mut self, state: &LmState) -> bool {
        let (mut least, mut largest) = (f64::INFINITY, 0.0f64);
        for j in (0..self.held.len()).filter(|&j| self.held[j].is_none() && self.norms[j] > 0.0) {
            let ratio = self.scale[j] / self.norms[j];
            least = least.min(ratio);
            largest = largest.max(ratio);
        }
        let (Some(x), Some(r), Some(jacobian)) = (&state.param, &state.residuals, &state.jacobian) else {
            return false;
        };
        if largest <= DRIFT * least {
            return false;
        }
        for (scale, &norm) in self.scale.iter_mut().zip(self.norms.iter()) {
            if norm > 0.0 {
                *scale = norm;
            }
        }
        self.model = Some(self.model_at(x, r, jacobian));
        self.damping = 0.0;
        self.fresh = true;
        self.rescaled = state.iter;
        self.radius = self.first_radius(x);
        true
    }

    /// The radius of the first trust region around `x`.
    fn first_radius(&self, x: &DVector<f64>) -> f64 {
        let length = self.length(x);
        self.options.radius_factor * if length > 0.0 { length } else { 1.0 }
    }

    /// Norm of the scaled free parameters.
    fn length(&self, x: &DVector<f64>) -> f64 {
        let free = (0..x.len()).filter(|&j| self.held[j].is_none());
        free.map(|j| (self.scale_of(j) * x[j]).powi(2)).sum::<f64>().sqrt()
    }

    fn scale_of(&self, j: usize) -> f64 {
        if self.scale[j] > 0.0 { self.scale[j] } else { 1.0 }
    }

    /// Writes the point at the end of `step` to the trial buffer. False if it is the point `x` itself.
    fn advance(&mut self, x: &DVector<f64>, step: &Step) -> bool {
        for j in 0..x.len() {
            self.trial.x[j] = match step.sides[j] {
                Some(Bound::Lower) => self.bounds.lower()[j],
                Some(Bound::Upper) => self.bounds.upper()[j],
                None => x[j] + step.z[j] / self.scale_of(j),
            };
        }
        self.bounds.project(self.trial.x.as_mut_slice());
        self.trial.x != *x
    }

    /// The cost at the trial point, with the Jacobian if `jacobian`; none if it is not finite.
    fn evaluate<P: LeastSquares>(&mut self, problem: &mut Problem<P>, jacobian: bool) -> Result<Option<f64>, Error> {
        self.residual_evaluations += 1;
        self.jacobian_evaluations += u64::from(jacobian);
        let count = if jacobian { "jacobian_count" } else { "residual_count" };
        problem.problem(count, |p| Ok(self.trial.evaluate(p, jacobian)))
    }

    /// The cost at the trial point and whether it is accepted, with the Jacobian then; none if something is not finite.
    fn judge<P: LeastSquares>(
        &mut self,
        problem: &mut Problem<P>,
        step: &Step,
        before: f64,
    ) -> Result<Option<(f64, bool)>, Error> {
        let eager = self.options.jacobian_at_trials;
        let Some(cost) = self.evaluate(problem, eager)? else { return Ok(None) };
        if !(before - cost >= ACCEPTANCE * step.decrease && cost < before) {
            return Ok(Some((cost, false)));
        }
        let with_jacobian = if eager { Some(cost) } else { self.evaluate(problem, true)? };
        Ok(with_jacobian.filter(|_| self.trial.differentiate().is_ok()).map(|cost| (cost, true)))
    }

    /// Makes the trial point the state's, and returns the reason to stop there, if there is one.
    fn accept(&mut self, state: &mut LmState, cost: f64) -> Option<Termination> {
        self.fresh = false;
        swap(&mut state.param, &mut self.trial.x);
        swap(&mut state.residuals, &mut self.trial.r);
        swap(&mut state.jacobian, &mut self.trial.jacobian);
        swap(&mut state.grad, &mut self.trial.gradient);
        state.prev_cost = state.cost;
        state.cost = cost;
        self.centre(state)
    }

    /// Whether the cost or the step says that nothing more is to be gained. A step that the trust region cut short may be small
    /// for that reason alone, so the whole step must be unimportant, too.
    fn end_of_progress(&self, step: &Step, before: f64, actual: f64, is_short: bool) -> Option<Termination> {
        let ftol = self.options.ftol;
        let settled = actual.abs() <= ftol * before
            && step.decrease <= ftol * before
            && (actual / step.decrease <= 2.0 || actual <= ROUNDING * before)
            && (!step.restricted || step.full_decrease <= ftol.sqrt() * before);
        if settled {
            return Some(Termination::Ftol);
        }
        is_short.then_some(Termination::Xtol)
    }

    /// Fits the trust region to how well the model predicted the trial: MINPACK's rules, but that a step cut short by a
    /// new bound says nothing about how far the model holds, and does not shrink the region.
    fn resize(&mut self, step: &Step, length: f64, gain: f64, actual: f64, cost_ratio: f64) {
        let blocked = step.sides.iter().zip(&self.held).any(|(now, before)| now.is_some() && before.is_none());
        if self.fresh && !blocked {
            self.radius = self.radius.min(length);
        }
        if gain <= 0.25 {
            // The minimum of the parabola with the slope at the start and the cost at both ends.
            let mut factor = if actual >= 0.0 { 0.5 } else { 0.5 * step.slope / (step.slope + actual) };
            if cost_ratio >= 100.0 || factor.is_nan() || factor < 0.1 {
                factor = 0.1;
            }
            self.radius = factor * self.radius.min(10.0 * length);
            self.damping = step.damping / factor;
        } else if !step.restricted || gain >= 0.75 {
            self.radius = if blocked { self.radius.max(2.0 * length) } else { 2.0 * length };
            self.damping = 0.5 * step.damping;
        } else {
            self.damping = step.damping;
        }
    }

    fn stop(&mut self, state: LmState, termination: Termination) -> LmState {
        self.termination = Some(termination);
        state.terminate_with(match termination {
            Termination::Stopped | Termination::NonFinite => {
                TerminationReason::SolverExit(termination.name().to_owned())
            }
            _ => TerminationReason::SolverConverged,
        })
    }

    fn check_lengths(&self, rows: usize, n: usize, start: usize) -> Result<(), LmError> {
        if rows == 0 || n == 0 {
            return Err(LmError::Empty { rows, parameters: n });
        }
        for (what, found) in [("the start", start), ("the box", self.bounds.parameters())] {
            if found != n {
                return Err(LmError::Length { what, expected: n, found });
            }
        }
        Ok(())
    }
}

impl<P: LeastSquares> Solver<P, LmState> for LevenbergMarquardt {
    fn name(&self) -> &str {
        "bounded Levenberg-Marquardt"
    }

    fn init(&mut self, problem: &mut Problem<P>, mut state: LmState) -> Result<(LmState, Option<KV>), Error> {
        let (rows, n) = problem.problem.as_ref().map_or((0, 0), |p| (p.rows(), p.parameters()));
        let mut x = state.take_param().unwrap_or_else(|| DVector::zeros(0));
        self.check_lengths(rows, n, x.len())?;
        self.bounds.project(x.as_mut_slice());
        if let Some((index, &value)) = x.iter().enumerate().find(|(_, x)| !x.is_finite()) {
            return Err(LmError::Start { index, value }.into());
        }
        self.trial = Trial::new(rows, n);
        self.trial.x.copy_from(&x);
        let cost = self.evaluate(problem, true)?.ok_or(LmError::Residuals)?;
        self.trial.differentiate().map_err(|index| LmError::Jacobian { index })?;
        state.param = Some(x);
        state.cost = cost;
        state.residuals = Some(self.trial.r.clone());
        state.jacobian = Some(self.trial.jacobian.clone());
        state.grad = Some(self.trial.gradient.clone());
        if let Some(termination) = self.centre(&state) {
            return Ok((self.stop(state, termination), None));
        }
        self.radius = self.first_radius(&self.trial.x);
        Ok((state, None))
    }

    fn next_iter(&mut self, problem: &mut Problem<P>, mut state: LmState) -> Result<(LmState, Option<KV>), Error> {
        let (Some(model), Some(x)) = (&self.model, &state.param) else {
            return Ok((self.stop(state, Termination::Stopped), None));
        };
        let step = model.step(self.radius, self.damping);
        let length = step.z.norm();
        let short = self.options.xtol * self.length(x);
        if !self.advance(x, &step) {
            let reason = if self.non_finite { Termination::NonFinite } else { Termination::Xtol };
            return Ok((self.stop(state, reason), None));
        }
        let before = state.cost;
        let judged = self.judge(problem, &step, before)?;
        self.non_finite = judged.is_none();
        let Some((cost, accepted)) = judged else {
            self.radius = 0.1 * self.radius.min(length);
            self.damping = 10.0 * step.damping;
            if self.radius <= short {
                state = self.stop(state, Termination::NonFinite);
            }
            return Ok((state, None));
        };
        let actual = before - cost;
        self.resize(&step, length, actual / step.decrease, actual, cost / before);
        let at_centre = if accepted { self.accept(&mut state, cost) } else { None };
        let mut reason =
            at_centre.or_else(|| self.end_of_progress(&step, before, actual, length.min(self.radius) <= short));
        let without_progress = matches!(reason, Some(Termination::Ftol | Termination::Xtol));
        let impatient = reason.is_none() && state.iter >= self.rescaled + PATIENCE;
        if (without_progress || impatient) && self.rescale(&state) {
            reason = None;
        }
        if let Some(reason) = reason {
            state = self.stop(state, reason);
        }
        Ok((state, None))
    }
}

/// Exchanges the state's value with that of the trial.
fn swap<T>(state: &mut Option<T>, trial: &mut T) {
    if let Some(state) = state {
        std::mem::swap(state, trial);
    }
}
