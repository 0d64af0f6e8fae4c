//! The box: optimality conditions, exact bounds, and problems whose bounded solution is known.

mod lm_support;

use brdfit_fit::lm::{Bound, Bounds, LeastSquares, Options, Solution, minimise};
use lm_support::{Problem, dual::Dual, problems::*};
use nalgebra::{DMatrix, DVector};
use proptest::prelude::*;

/// Checks the first-order conditions of Karush, Kuhn and Tucker with derivatives computed anew.
fn assert_optimal(problem: &Problem, bounds: &Bounds, solution: &Solution, tolerance: f64) {
    let (m, n) = (problem.rows, problem.start.len());
    let mut r = vec![0.0; m];
    let mut j = DMatrix::zeros(m, n);
    problem.residuals_and_jacobian(&solution.parameters, &mut r, &mut j);
    let r = DVector::from_vec(r);
    for k in 0..n {
        let x = solution.parameters[k];
        let (l, u) = (bounds.lower()[k], bounds.upper()[k]);
        assert!(l <= x && x <= u, "{}: {x} outside", problem.name);
        let cosine = j.column(k).dot(&r) / (j.column(k).norm() * r.norm()).max(1e-300);
        let name = &problem.name;
        match solution.active[k] {
            Some(Bound::Lower) => {
                assert_eq!(x.to_bits(), l.to_bits());
                assert!(l == u || cosine > -tolerance, "{name}: {k} {cosine:e}");
            }
            Some(Bound::Upper) => {
                assert_eq!(x.to_bits(), u.to_bits());
                assert!(cosine < tolerance, "{name}: {k} {cosine:e}");
            }
            None => assert!(cosine.abs() < tolerance, "{name}: {k} {cosine:e}"),
        }
    }
}

/// A linear problem A x - b.
fn linear(a: DMatrix<f64>, b: DVector<f64>) -> Problem {
    let start = vec![0.0; a.ncols()];
    Problem::new("linear", a.nrows(), &start, move |x, r| {
        for (i, r) in r.iter_mut().enumerate() {
            *r = Dual::from(-b[i]);
            for (k, &x) in x.iter().enumerate() {
                *r = *r + a[(i, k)] * x;
            }
        }
    })
}

/// The bounded minimum of |A x - b|^2 by trying every face of the box.
fn enumerate(a: &DMatrix<f64>, b: &DVector<f64>, bounds: &Bounds) -> f64 {
    let n = a.ncols();
    let mut best = f64::INFINITY;
    for code in 0..3usize.pow(n as u32) {
        let digit = |k: usize| code / 3usize.pow(k as u32) % 3;
        let mut x = DVector::from_fn(n, |k, _| match digit(k) {
            0 => bounds.lower()[k],
            1 => bounds.upper()[k],
            _ => 0.0,
        });
        let free: Vec<usize> = (0..n).filter(|&k| digit(k) == 2).collect();
        if !free.is_empty() {
            let columns = a.select_columns(&free);
            let rhs = columns.tr_mul(&(b - a * &x));
            let Some(solution) = columns.tr_mul(&columns).lu().solve(&rhs) else {
                continue;
            };
            for (i, &k) in free.iter().enumerate() {
                x[k] = solution[i];
            }
        }
        if (0..n).all(|k| (bounds.lower()[k]..=bounds.upper()[k]).contains(&x[k])) {
            best = best.min((a * &x - b).norm_squared());
        }
    }
    best
}

proptest! {
    #[test]
    fn bounded_linear_problems_are_solved_like_by_enumeration(
        n in 1usize..5,
        extra in 1usize..5,
        entries in prop::collection::vec(-1.0f64..1.0, 32),
        b in prop::collection::vec(-3.0f64..3.0, 8),
        edges in prop::collection::vec((-1.0f64..1.0, 0.0f64..1.0), 4),
        start in prop::collection::vec(-2.0f64..2.0, 4),
    ) {
        let m = n + extra;
        let a = DMatrix::from_column_slice(m, n, &entries[..m * n]);
        let b = DVector::from_column_slice(&b[..m]);
        let bounds = Bounds::new(
            edges[..n].iter().map(|e| e.0).collect(),
            edges[..n].iter().map(|e| e.0 + e.1).collect(),
        ).unwrap();
        let best = enumerate(&a, &b, &bounds);
        let problem = linear(a, b);
        let solution = minimise(&problem, &start[..n], &bounds, &Options::default()).unwrap();
        prop_assert!((2.0 * solution.cost - best).abs() <= 1e-10 * (1.0 + best));
        prop_assert!(solution.termination.converged());
        assert_optimal(&problem, &bounds, &solution, 1e-6);
    }

    #[test]
    fn random_boxes_end_at_optimal_points(
        which in 0usize..6,
        edges in prop::collection::vec((-1.5f64..1.5, 0.0f64..2.0), 6),
        start in prop::collection::vec(-1.5f64..3.5, 6),
    ) {
        let problem = match which {
            0 => rosenbrock(),
            1 => beale(),
            2 => wood(),
            3 => brown_dennis(),
            4 => jennrich_sampson(),
            _ => watson(6),
        };
        let n = problem.start.len();
        let bounds = Bounds::new(
            edges[..n].iter().map(|e| e.0).collect(),
            edges[..n].iter().map(|e| e.0 + e.1).collect(),
        ).unwrap();
        let options = Options { iteration_limit: 5000, ..Options::default() };
        let solution = minimise(&problem, &start[..n], &bounds, &options).unwrap();
        prop_assert!(solution.termination.converged());
        let mut projected = start[..n].to_vec();
        bounds.project(&mut projected);
        prop_assert!(2.0 * solution.cost <= problem.sum_of_squares(&projected) * (1.0 + 1e-13));
        if solution.cost > 1e-24 {
            assert_optimal(&problem, &bounds, &solution, 2e-5);
        }
    }
}

#[test]
fn a_bound_across_a_valley_does_not_stop_the_way_along_it() {
    // Rosenbrock with x_1 <= 0.6: on the bound, 100 (0.6 - x^2)^2 + (1 - x)^2 is least where 400 x^3 - 238 x - 2 = 0.
    let (mut low, mut high) = (0.5f64, 1.0f64);
    for _ in 0..200 {
        let x = 0.5 * (low + high);
        if 400.0 * x * x * x - 238.0 * x - 2.0 < 0.0 {
            low = x;
        } else {
            high = x;
        }
    }
    let bounds = Bounds::new(vec![-3.0, -3.0], vec![3.0, 0.6]).unwrap();
    let problem = rosenbrock();
    // From the standard start the local minimum is the other one, at negative x.
    let solution = minimise(&problem, &[1.2, 0.1], &bounds, &Options::default()).unwrap();
    assert_eq!(solution.active, [None, Some(Bound::Upper)]);
    assert!((solution.parameters[0] - low).abs() < 1e-9);
    assert!(solution.iterations < 30, "{}", solution.iterations);
    assert_optimal(&problem, &bounds, &solution, 1e-8);
}

#[test]
fn a_bound_that_was_hit_on_the_way_is_left_again() {
    // The helical valley's solution (1, 0, 0) touches the box from inside at x_1 = 0.
    let bounds = Bounds::new(vec![-2.0, -0.5, -0.5], vec![2.0, 1.5, 3.0]).unwrap();
    let problem = helical_valley();
    let solution = minimise(&problem, &[-1.0, -0.5, 3.0], &bounds, &Options::default()).unwrap();
    assert!(solution.cost < 1e-24, "{:e}", solution.cost);
    assert!(solution.active.iter().all(Option::is_none));
}

#[test]
fn a_huge_column_at_the_start_is_forgotten() {
    // At the start the first column is 1e9 long, at the solution 1e2: with scales that never shrink the trust region
    // holds its parameter still, and a hundred thousand iterations do not suffice.
    let bounds = Bounds::new(vec![0.0, -0.5], vec![2.0, 1.0]).unwrap();
    let problem = jennrich_sampson();
    let solution = minimise(&problem, &[2.0, 0.0], &bounds, &Options::default()).unwrap();
    assert!((2.0 * solution.cost / 124.362 - 1.0).abs() < 2e-6);
    assert_optimal(&problem, &bounds, &solution, 1e-6);
}

#[test]
fn equal_bounds_fix_a_parameter() {
    let free = minimise(&watson(5), &[0.0; 5], &Bounds::none(5), &Options::default()).unwrap();
    let bounds =
        Bounds::new([&[f64::NEG_INFINITY; 5][..], &[0.0]].concat(), [&[f64::INFINITY; 5][..], &[0.0]].concat())
            .unwrap();
    let fixed = minimise(&watson(6), &[0.0; 6], &bounds, &Options::default()).unwrap();
    assert_eq!(fixed.active[5], Some(Bound::Lower));
    assert!((fixed.cost / free.cost - 1.0).abs() < 1e-10);
}

#[test]
fn a_solution_at_a_corner_is_recognised() {
    // |x - 5|^2 in the unit box.
    let a = DMatrix::identity(3, 3);
    let problem = linear(a, DVector::from_element(3, 5.0));
    let bounds = Bounds::new(vec![0.0; 3], vec![1.0; 3]).unwrap();
    let solution = minimise(&problem, &[0.5; 3], &bounds, &Options::default()).unwrap();
    assert_eq!(solution.parameters, [1.0; 3]);
    assert_eq!(solution.active, [Some(Bound::Upper); 3]);
    assert_eq!(solution.termination.name(), "gtol");
    assert_eq!(solution.largest_cosine(), 0.0);
    assert_eq!(solution.uncertainty().condition_number, None);
}
