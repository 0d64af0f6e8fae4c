//! The solver on certified problems of nonlinear regression: parameters, sums of squares and standard deviations.

mod lm_support;

use approx::assert_relative_eq;
use brdfit_fit::lm::{Bounds, Options, minimise};
use lm_support::nist;

#[test]
fn certified_results_are_reached_from_both_starts() {
    // MGH17 needs 750 iterations from its first start, where two of five parameters have no effect at all.
    let options = Options { iteration_limit: 2000, ..Options::default() };
    for c in nist::all() {
        for start in &c.starts {
            let bounds = Bounds::none(start.len());
            let solution = minimise(&c.problem, start, &bounds, &options).unwrap();
            assert!(solution.termination.converged(), "{}", c.problem.name);
            // Eleven digits are certified.
            assert_relative_eq!(2.0 * solution.cost, c.sum_of_squares, max_relative = 1e-10);
            let uncertainty = solution.uncertainty();
            for (j, &expected) in c.parameters.iter().enumerate() {
                assert_relative_eq!(solution.parameters[j], expected, max_relative = 2e-6);
                let error = uncertainty.standard_errors[j].unwrap();
                assert_relative_eq!(error, c.standard_deviations[j], max_relative = 5e-6);
            }
        }
    }
}

#[test]
fn loose_bounds_change_nothing() {
    for c in nist::all() {
        let around = |factor: f64| c.parameters.iter().map(|p| p - factor * p.abs()).collect();
        let bounds = Bounds::new(around(3.0), around(-3.0)).unwrap();
        let solution = minimise(&c.problem, &c.starts[1], &bounds, &Options::default()).unwrap();
        assert_relative_eq!(2.0 * solution.cost, c.sum_of_squares, max_relative = 1e-10);
        assert!(solution.active.iter().all(Option::is_none));
    }
}
