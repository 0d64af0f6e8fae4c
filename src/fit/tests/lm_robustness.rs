//! What the solver does with bad input, values that are not finite and degenerate problems; determinism and options.

mod lm_support;

use argmin::core::Executor;
use brdfit_fit::lm::{Bounds, LevenbergMarquardt, LmError, Options, Termination, minimise};
use lm_support::{Problem, dual::Dual, problems::*};

fn solve(problem: &Problem, options: &Options) -> Result<brdfit_fit::lm::Solution, LmError> {
    minimise(problem, &problem.start, &Bounds::none(problem.start.len()), options)
}

#[test]
fn bad_input_is_refused() {
    let options = Options::default();
    let problem = rosenbrock();
    let start = |x: &[f64], n| minimise(&problem, x, &Bounds::none(n), &options).unwrap_err();
    assert!(matches!(start(&[1.0], 2), LmError::Length { what: "the start", found: 1, .. }));
    assert!(matches!(start(&[1.0, 2.0], 3), LmError::Length { what: "the box", found: 3, .. }));
    assert!(matches!(start(&[1.0, f64::NAN], 2), LmError::Start { index: 1, .. }));
    assert!(matches!(start(&[f64::INFINITY, 0.0], 2), LmError::Start { index: 0, .. }));
    let none = Problem::new("no rows", 0, &[1.0], |_, _| {});
    let empty = LmError::Empty { rows: 0, parameters: 1 };
    assert_eq!(solve(&none, &options).unwrap_err(), empty);
}

#[test]
fn a_start_without_a_finite_value_is_an_error() {
    let options = Options::default();
    for bad in [f64::NAN, f64::INFINITY, 1e200] {
        let problem = Problem::new("bad residual", 2, &[1.0], move |x, r| {
            r[0] = x[0];
            r[1] = x[0] * bad;
        });
        assert_eq!(solve(&problem, &options).unwrap_err(), LmError::Residuals);
    }
    let problem = Problem::new("bad Jacobian", 2, &[1.0, 0.0], |x, r| {
        r[0] = x[0] - 3.0;
        r[1] = x[1];
        if x[1].slope != 0.0 {
            r[1].slope = f64::INFINITY;
        }
    });
    assert_eq!(solve(&problem, &options).unwrap_err(), LmError::Jacobian { index: 1 });
}

#[test]
fn steps_into_the_undefined_are_shortened() {
    // The Gauss-Newton step from 4 leads to -3.6, where the root does not exist.
    let problem = Problem::new("root", 1, &[4.0], |x, r| r[0] = x[0].sqrt() - 0.1);
    let solution = solve(&problem, &Options::default()).unwrap();
    assert!((solution.parameters[0] - 0.01).abs() < 1e-14);
}

#[test]
fn an_undefined_jacobian_rejects_the_point_too() {
    // The residual exists at 0 and beyond, its derivative only above 1/4.
    let problem = Problem::new("gap", 1, &[2.0], |x, r| {
        r[0] = x[0];
        if x[0].value <= 0.25 {
            r[0].slope = f64::NAN;
        }
    });
    for jacobian_at_trials in [true, false] {
        let options = Options { jacobian_at_trials, ..Options::default() };
        let solution = solve(&problem, &options).unwrap();
        assert!(solution.parameters[0] > 0.25 && solution.parameters[0] < 0.26);
        assert_eq!(solution.termination, Termination::NonFinite);
        assert_eq!(solution.jacobian[(0, 0)], 1.0);
    }
}

#[test]
fn an_island_of_finite_values_is_reported() {
    let problem = Problem::new("island", 1, &[1.0], |x, r| {
        r[0] = if x[0].value == 1.0 { x[0] } else { Dual::from(f64::NAN) };
    });
    let solution = solve(&problem, &Options::default()).unwrap();
    assert_eq!(solution.termination, Termination::NonFinite);
    assert!(!solution.termination.converged());
    assert_eq!((solution.parameters[0], solution.cost), (1.0, 0.5));
}

#[test]
fn a_zero_residual_at_the_start_ends_at_once() {
    let problem = rosenbrock();
    let solution = minimise(&problem, &[1.0, 1.0], &Bounds::none(2), &Options::default()).unwrap();
    assert_eq!(solution.termination, Termination::ZeroResidual);
    assert_eq!(solution.iterations, 0);
    assert_eq!(solution.residual_evaluations, 1);
}

#[test]
fn a_cost_floor_ends_the_chase_for_digits() {
    let options = Options { cost_floor: 1e-20, ..Options::default() };
    let floored = solve(&biggs(), &options).unwrap();
    assert_eq!(floored.termination, Termination::ZeroResidual);
    assert!(floored.cost <= 1e-20);
}

#[test]
fn all_parameters_fixed_is_a_solution() {
    let bounds = Bounds::new(vec![0.3, 0.4], vec![0.3, 0.4]).unwrap();
    let solution = minimise(&rosenbrock(), &[7.0, -7.0], &bounds, &Options::default()).unwrap();
    assert_eq!(solution.parameters, [0.3, 0.4]);
    assert_eq!(solution.termination, Termination::Gtol);
    assert_eq!(solution.uncertainty().standard_errors, [None, None]);
}

#[test]
fn a_start_outside_is_projected() {
    let bounds = Bounds::new(vec![0.0, 0.0], vec![0.5, 0.5]).unwrap();
    let problem = rosenbrock();
    let from_outside = minimise(&problem, &[-9.0, 9.0], &bounds, &Options::default()).unwrap();
    let from_corner = minimise(&problem, &[0.0, 0.5], &bounds, &Options::default()).unwrap();
    assert_eq!(from_outside, from_corner);
    assert!((2.0 * from_outside.cost - 0.25).abs() < 1e-12);
}

#[test]
fn a_parameter_without_effect_stays_and_has_no_error() {
    let problem = Problem::new("no effect", 3, &[1.0, 7.0], |x, r| {
        for (i, r) in (1..).zip(r) {
            *r = x[0] * f64::from(i) - 1.0;
        }
    });
    let solution = solve(&problem, &Options::default()).unwrap();
    assert!((solution.parameters[0] - 6.0 / 14.0).abs() < 1e-14);
    assert_eq!(solution.parameters[1], 7.0);
    let uncertainty = solution.uncertainty();
    assert!(uncertainty.standard_errors[0].is_some());
    assert_eq!(uncertainty.standard_errors[1], None);
    assert_eq!(uncertainty.condition_number, None);
}

#[test]
fn fewer_rows_than_parameters_still_end_at_a_zero() {
    let problem = Problem::new("one row", 1, &[1.0, 2.0, 3.0], |x, r| {
        r[0] = x[0].square() + x[1] * x[2] - 1.0;
    });
    let solution = solve(&problem, &Options::default()).unwrap();
    assert!(solution.cost < 1e-28);
    assert_eq!(solution.uncertainty().variance, None);
}

#[test]
fn the_limit_of_iterations_is_kept_and_named() {
    let options = Options { iteration_limit: 3, ..Options::default() };
    let problem = wood();
    let solution = solve(&problem, &options).unwrap();
    assert_eq!(solution.termination, Termination::IterationLimit);
    assert_eq!(solution.iterations, 3);
    assert_eq!(solution.residual_evaluations, 4);
    assert!(2.0 * solution.cost <= problem.sum_of_squares(&problem.start));
}

#[test]
fn a_target_of_argmin_stops_the_solver() {
    let solver = LevenbergMarquardt::new(Bounds::none(2), Options::default());
    let result = Executor::new(rosenbrock(), solver)
        .configure(|state| state.param(vec![-1.2, 1.0].into()).target_cost(1.0))
        .ctrlc(false)
        .run()
        .unwrap();
    let solution = result.solver.into_solution(result.state);
    assert_eq!(solution.termination, Termination::Stopped);
    assert!(solution.cost <= 1.0 && solution.cost > 0.0);
}

#[test]
fn separate_evaluation_of_the_jacobian_gives_the_same_bits() {
    for problem in [wood(), osborne_two(), biggs(), brown_dennis()] {
        let together = solve(&problem, &Options::default()).unwrap();
        let options = Options { jacobian_at_trials: false, ..Options::default() };
        let separate = solve(&problem, &options).unwrap();
        assert_eq!(together.parameters, separate.parameters);
        assert_eq!(together.cost.to_bits(), separate.cost.to_bits());
        assert_eq!(together.iterations, separate.iterations);
        assert!(separate.jacobian_evaluations <= together.jacobian_evaluations);
        assert_eq!(together, solve(&problem, &Options::default()).unwrap());
    }
}
