//! The solver on the test set of Moré, Garbow and Hillstrom, against the published minima and a second solver.

mod lm_support;

use brdfit_fit::lm::{Bounds, Options, Solution, minimise};
use lm_support::{Problem, problems::*, second_solver};

fn solve(problem: &Problem) -> Solution {
    let n = problem.start.len();
    let options = Options::default();
    let solution = minimise(problem, &problem.start, &Bounds::none(n), &options).unwrap();
    assert!(solution.termination.converged(), "{}", problem.name);
    let again = 0.5 * problem.sum_of_squares(&solution.parameters);
    assert!((solution.cost - again).abs() <= 1e-14 * again);
    solution
}

/// Problems with a positive minimum, and the published sums of squares (six digits, hence the tolerance). For
/// Freudenstein-Roth it is the local minimum that Gauss-Newton methods reach from the standard start.
fn positive() -> Vec<(Problem, f64)> {
    vec![
        (freudenstein_roth(), 48.9842),
        (jennrich_sampson(), 124.362),
        (bard(), 8.21487e-3),
        (brown_dennis(), 85822.2),
        (osborne_two(), 4.01377e-2),
        (watson(6), 2.28767e-3),
        (watson(9), 1.39976e-6),
        (watson(12), 4.72238e-10),
        (chebyquad(8), 3.51687e-3),
        (chebyquad(10), 6.50395e-3),
        (linear_full_rank(10, 5), 5.0),
        (linear_full_rank(50, 5), 45.0),
        (linear_rank_one(10, 5), 10.0 * 9.0 / (2.0 * 21.0)),
        (linear_rank_one(50, 5), 50.0 * 49.0 / (2.0 * 101.0)),
        (linear_rank_one_zeros(10, 5), (100.0 + 30.0 - 6.0) / (2.0 * 17.0)),
        (linear_rank_one_zeros(50, 5), (2500.0 + 150.0 - 6.0) / (2.0 * 97.0)),
    ]
}

/// Problems whose minimum is zero.
fn zero() -> Vec<Problem> {
    let mut problems = vec![
        rosenbrock(),
        powell_badly_scaled(),
        brown_badly_scaled(),
        beale(),
        helical_valley(),
        gulf(),
        box_three(),
        powell_singular(),
        wood(),
        biggs(),
        brown_almost_linear(10),
        brown_almost_linear(30),
    ];
    problems.extend([1, 2, 3, 4, 5, 6, 7, 9].map(chebyquad));
    problems
}

#[test]
fn published_minima_are_reached() {
    for (problem, published) in positive() {
        let found = 2.0 * solve(&problem).cost;
        let error = (found / published - 1.0).abs();
        assert!(error < 2e-6, "{}: {found:e} for {published:e}", problem.name);
    }
}

#[test]
fn zeros_are_found_to_the_last_digits() {
    for problem in zero() {
        let found = 2.0 * solve(&problem).cost;
        assert!(found < 1e-26, "{}: {found:e}", problem.name);
    }
}

#[test]
fn known_solutions_are_found() {
    for (problem, expected) in [
        (rosenbrock(), vec![1.0, 1.0]),
        (brown_badly_scaled(), vec![1e6, 2e-6]),
        (beale(), vec![3.0, 0.5]),
        (helical_valley(), vec![1.0, 0.0, 0.0]),
        (gulf(), vec![50.0, 25.0, 1.5]),
        (wood(), vec![1.0; 4]),
        (linear_full_rank(10, 5), vec![-1.0; 5]),
    ] {
        let solution = solve(&problem);
        for (found, expected) in solution.parameters.iter().zip(&expected) {
            let error = (found - expected).abs() / expected.abs().max(1.0);
            assert!(error < 1e-10, "{}: {found} for {expected}", problem.name);
        }
    }
}

#[test]
fn minima_are_stationary() {
    // Cost is flat to second order: a cosine of 1e-6 leaves a relative 1e-12 of it.
    for (problem, _) in positive() {
        let cosine = solve(&problem).largest_cosine();
        assert!(cosine < 3e-6, "{}: {cosine:e}", problem.name);
    }
}

#[test]
fn the_second_solver_finds_nothing_better() {
    for (problem, _) in positive() {
        let n = problem.start.len();
        let ours = 2.0 * solve(&problem).cost;
        let theirs = second_solver(&problem, &problem.start, &Bounds::none(n));
        assert!(ours <= theirs * (1.0 + 1e-10), "{}: {ours:e} against {theirs:e}", problem.name);
    }
    for problem in [rosenbrock(), beale(), wood(), box_three(), powell_singular()] {
        let n = problem.start.len();
        let theirs = second_solver(&problem, &problem.start, &Bounds::none(n));
        let ours = 2.0 * solve(&problem).cost;
        assert!(ours <= theirs + 1e-26, "{}: {ours:e} against {theirs:e}", problem.name);
    }
}

#[test]
fn the_second_solver_agrees_within_bounds() {
    // Boxes that cut off the free minimum.
    for (problem, lower, upper) in [
        (rosenbrock(), vec![-2.0, -2.0], vec![0.5, 2.0]),
        (beale(), vec![0.0, -1.0], vec![2.0, 0.4]),
        (bard(), vec![0.1, 0.5, 0.0], vec![2.0, 2.0, 2.0]),
        (helical_valley(), vec![-2.0, -2.0, -1.0], vec![0.8, 2.0, 1.0]),
        (wood(), vec![-4.0; 4], vec![0.9, 4.0, 4.0, 0.7]),
        (brown_dennis(), vec![-10.0, 0.0, -5.0, -5.0], vec![25.0, 10.0, 5.0, 5.0]),
        (watson(6), vec![0.0; 6], vec![0.8; 6]),
        (osborne_two(), vec![0.5; 11], vec![1.4, 0.6, 0.6, 1.0, 1.0, 4.0, 5.0, 6.0, 2.5, 5.0, 6.0]),
    ] {
        let bounds = Bounds::new(lower, upper).unwrap();
        let mut start = problem.start.clone();
        bounds.project(&mut start);
        let theirs = second_solver(&problem, &start, &bounds);
        let solution = minimise(&problem, &start, &bounds, &Options::default()).unwrap();
        let ours = 2.0 * solution.cost;
        assert!(solution.termination.converged(), "{}", problem.name);
        assert!(ours <= theirs * (1.0 + 1e-9), "{}: {ours:e} against {theirs:e}", problem.name);
        assert!(solution.active.iter().any(Option::is_some), "{}", problem.name);
    }
}
