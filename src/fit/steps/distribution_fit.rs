//! Step 1: diffuse level, peak height and distribution from the theta_h slice (thesis V.4, eq. V.6).
//!
//! `m_h(theta_h) ~ [rho_d + (pi / c) Fr D(theta_h) G1(theta_h)^2 / cos^2 theta_h] / pi` with the model's `c`
//! ([`NormalDistribution::DIVISOR`]), in the unknowns ln rho_d and ln P of each channel, `P = (pi / c) Fr D(0)`, and the
//! transformed shape parameters. With the peak height P instead of Fr the unknowns are far less correlated, and the
//! normalisation drops out of the shape.

use crate::lm;
use crate::lm::bounds::{Bound, Bounds};
use crate::lm::problem::LmError;
use crate::lm::solution::Solution;
use crate::options::{Constraint, FitOptions};
use crate::steps::distribution_problem::{DIFFUSE_RANGE, DistributionProblem, Layout, PEAK_RANGE};
use crate::steps::masking_table::MaskingTable;
use crate::steps::slice_rows::Row;
use brdfit_brdf::{Microfacet, NormalDistribution, Transform};
use brdfit_measured::SamplePosition;
use rayon::prelude::*;
use std::f64::consts::PI;

/// A start whose search ends at most this much above the best one is finished with the exact masking too.
const CONTENDER: f64 = 1.2;
/// Ends of searches that differ by less than this in every unknown are the same minimum.
const REPEATED: f64 = 0.02;

/// Result of step 1 for the channels that share one distribution.
#[derive(Clone, Debug)]
pub(crate) struct DistributionFit<D> {
    /// Diffuse albedo per channel.
    pub(crate) rho_d: Vec<f64>,
    /// `P` per channel, 1/sr; below zero for a dip.
    pub(crate) peak: Vec<f64>,
    /// The distribution.
    pub(crate) distribution: D,
    /// The solver's result in the unknowns.
    pub(crate) solution: Solution,
    /// Number of the winning start; with a free Fresnel term the starts of a dip follow those of a lobe.
    pub(crate) start: usize,
    /// Iterations of the winning start, search and finish together.
    pub(crate) iterations: u64,
}

/// The rows of the theta_h slice and the options of step 1.
#[derive(Clone, Copy)]
pub(crate) struct DistributionTask<'a> {
    pub(crate) rows: &'a [Row],
    /// Position of the samples of the slice.
    pub(crate) position: SamplePosition,
    pub(crate) options: &'a FitOptions,
}

/// A start after the search.
struct Searched {
    /// Which of the problems: a lobe or a dip.
    problem: usize,
    solution: Solution,
}

impl DistributionTask<'_> {
    /// Fits the given channels with one distribution.
    pub(crate) fn fit<D: NormalDistribution<N>, const N: usize>(
        &self,
        channels: &[usize],
    ) -> Result<DistributionFit<D>, LmError> {
        let bounds = bounds::<D, N>(channels.len())?;
        let dips = self.options.constraint == Constraint::Free && channels.len() == 1;
        let signs = if dips { &[1.0, -1.0][..] } else { &[1.0] };
        let exact: Vec<DistributionProblem<D, N>> =
            signs.iter().map(|&sign| DistributionProblem::new(self.rows, channels, self.options, sign)).collect();
        let searched = self.search(&exact, &bounds)?;
        let (solution, start, iterations) = self.finish(&exact, &bounds, &searched)?;
        let sign = signs[searched[start].problem];
        Ok(DistributionFit::new(solution, Layout { channels: channels.len() }, sign, start, iterations))
    }

    /// Runs all starts with loose tolerances on fewer rows.
    fn search<D: NormalDistribution<N>, const N: usize>(
        &self,
        exact: &[DistributionProblem<D, N>],
        bounds: &Bounds,
    ) -> Result<Vec<Searched>, LmError> {
        let options = lm::Options { ftol: 1e-6, xtol: 1e-5, gtol: 1e-7, ..self.solver_options() };
        let table = MaskingTable::of::<D>(self.position);
        let thinned: Vec<_> = exact.iter().map(|problem| problem.thinned(table)).collect();
        let starts: Vec<(usize, &[f64])> = (0..exact.len())
            .flat_map(|problem| self.options.starts.iter().map(move |start| (problem, start.as_slice())))
            .collect();
        let search = |&(problem, start): &(usize, &[f64])| {
            let solution = lm::minimise(&thinned[problem], &exact[problem].start(start), bounds, &options)?;
            Ok(Searched { problem, solution })
        };
        starts.par_iter().map(search).collect()
    }

    /// Finishes the best ends of the search: the winner, its number and its iterations.
    fn finish<D: NormalDistribution<N>, const N: usize>(
        &self,
        exact: &[DistributionProblem<D, N>],
        bounds: &Bounds,
        searched: &[Searched],
    ) -> Result<(Solution, usize, u64), LmError> {
        let best = searched.iter().map(|found| found.solution.cost).fold(f64::INFINITY, f64::min);
        let mut winner: Option<(Solution, usize, u64)> = None;
        let mut finished: Vec<(usize, &[f64])> = Vec::new();
        for (index, Searched { problem, solution: found }) in searched.iter().enumerate() {
            let same = |other: &[f64]| other.iter().zip(&found.parameters).all(|(a, b)| (a - b).abs() < REPEATED);
            if found.cost > CONTENDER * best || finished.iter().any(|&(other, at)| other == *problem && same(at)) {
                continue;
            }
            finished.push((*problem, &found.parameters));
            let solution = lm::minimise(&exact[*problem], &found.parameters, bounds, &self.solver_options())?;
            if winner.as_ref().is_none_or(|(other, ..)| solution.cost < other.cost) {
                let iterations = found.iterations + solution.iterations;
                winner = Some((solution, index, iterations));
            }
        }
        Ok(winner.expect("the best start is always a contender"))
    }

    fn solver_options(&self) -> lm::Options {
        lm::Options { iteration_limit: self.options.max_iterations, ..lm::Options::default() }
    }

    /// The cost of given parameters in one channel.
    pub(crate) fn cost_of<D: NormalDistribution<N>, const N: usize>(
        &self,
        channel: usize,
        model: &Microfacet<D, N>,
    ) -> f64 {
        let problem = DistributionProblem::<D, N>::new(self.rows, &[channel], self.options, 1.0);
        let fr = PI / D::DIVISOR * model.parameters().rho_s * model.parameters().fresnel().value(1.0);
        let squares = problem.rows.iter().map(|row| {
            let ratio = model.distribution().g1(row.theta) / row.cos;
            let y = (model.parameters().rho_d + fr * model.distribution().d_at(row.theta) * ratio * ratio) / PI;
            let residual = row.weight * (row.transformed[channel] - problem.loss.transform(y, row.cos).0);
            residual * residual
        });
        0.5 * squares.sum::<f64>()
    }
}

impl<D> DistributionFit<D> {
    fn new<const N: usize>(solution: Solution, layout: Layout, sign: f64, start: usize, iterations: u64) -> Self
    where
        D: NormalDistribution<N>,
    {
        // a parameter at a bound is the bound, not what rounding makes of it
        let value = |index: usize, transform: Transform, range: [f64; 2]| match solution.active[index] {
            Some(Bound::Lower) => range[0],
            Some(Bound::Upper) => range[1],
            None => transform.parameter(solution.parameters[index]),
        };
        let shape = std::array::from_fn(|k| value(layout.shape(k), D::SHAPE[k].transform, D::SHAPE[k].range));
        let level = |index: usize, range: [f64; 2]| value(index, Transform::Logarithm, range);
        Self {
            rho_d: (0..layout.channels).map(|n| level(layout.diffuse(n), DIFFUSE_RANGE)).collect(),
            peak: (0..layout.channels).map(|n| sign * level(layout.peak(n), PEAK_RANGE)).collect(),
            distribution: D::from_shape(shape).expect("the box lies inside of the model's domain"),
            solution,
            start,
            iterations,
        }
    }

    /// Where its unknowns lie.
    pub(crate) fn layout(&self) -> Layout {
        Layout { channels: self.rho_d.len() }
    }

    /// Whether the slice has no specular lobe at all: its height ended at the lower bound, and is taken as zero.
    pub(crate) fn is_flat(&self, n: usize) -> bool {
        self.solution.active[self.layout().peak(n)] == Some(Bound::Lower)
    }

    /// `Fr`, the mean of `rho_s F(0)` over the peak, of the n-th channel of the fit.
    pub(crate) fn fr<const N: usize>(&self, n: usize) -> f64
    where
        D: NormalDistribution<N>,
    {
        self.peak[n] / self.distribution.d_at(0.0) * (D::DIVISOR / PI)
    }

    /// The fitted slice at theta_h for the n-th channel of the fit, 1/sr.
    pub(crate) fn curve<const N: usize>(&self, n: usize, theta_h: f64) -> f64
    where
        D: NormalDistribution<N>,
    {
        if self.is_flat(n) { self.rho_d[n] / PI } else { self.curve_with_lobe(n, theta_h) }
    }

    /// The same with the lobe even where it is negligible.
    pub(crate) fn curve_with_lobe<const N: usize>(&self, n: usize, theta_h: f64) -> f64
    where
        D: NormalDistribution<N>,
    {
        let ratio = self.distribution.g1(theta_h) / libm::cos(theta_h);
        let scale = self.peak[n] / self.distribution.d_at(0.0);
        (self.rho_d[n] + scale * self.distribution.d_at(theta_h) * ratio * ratio) / PI
    }
}

fn bounds<D: NormalDistribution<N>, const N: usize>(channels: usize) -> Result<Bounds, LmError> {
    let side = |end: usize| {
        let mut list = Vec::with_capacity(2 * channels + N);
        for _ in 0..channels {
            list.extend([libm::log(DIFFUSE_RANGE[end]), libm::log(PEAK_RANGE[end])]);
        }
        list.extend(D::SHAPE.map(|parameter| parameter.transform.unknown(parameter.range[end])));
        list
    };
    Bounds::new(side(0), side(1))
}
