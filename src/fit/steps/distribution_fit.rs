//! Step 1: diffuse level, peak height and distribution from the theta_h slice (thesis V.4, eq. V.6).
//!
//! `m_h(theta_h) ~ [rho_d + Fr D(theta_h) G1(theta_h)^2 / cos^2 theta_h] / pi`, in the unknowns ln rho_d, ln(Fr D(0)) of each
//! channel, ln alpha and p. With the peak height `Fr D(0)` instead of Fr the unknowns are far less correlated, and the
//! normalisation K drops out of the shape.

use crate::lm;
use crate::lm::bounds::{Bound, Bounds};
use crate::lm::problem::{LeastSquares, LmError};
use crate::lm::solution::Solution;
use crate::options::{ALPHA_RANGE, Constraint, FitOptions, Loss, P_RANGE};
use crate::steps::g1_table::G1Table;
use crate::steps::slice_rows::{Row, ring};
use brdfit_brdf::{Sgd, ShiftedGamma, SmithG1};
use brdfit_measured::Dimensions;
use nalgebra::DMatrix;
use rayon::prelude::*;
use std::f64::consts::PI;
use wide::f64x4;

/// Bounds of rho_d and of the peak height `Fr D(0)`.
const DIFFUSE_RANGE: [f64; 2] = [1e-6, 10.0];
const PEAK_RANGE: [f64; 2] = [1e-6, 1e7];
/// The least that a start may be.
const START_FLOOR: f64 = 1e-5;
/// A start whose search on the table ends at most this much above the best one is finished with the exact masking too.
const CONTENDER: f64 = 1.2;
/// The search takes every row up to this bin, where a lobe may change from row to row, and every third one beyond, with three times
/// its weight.
const DENSE_BINS: usize = 18;
const THINNING: usize = 3;
/// Ends of searches that differ by less than this in every unknown are the same minimum.
const REPEATED: f64 = 0.02;

/// What step 1 found for the channels that share one distribution.
#[derive(Clone, Debug)]
pub(crate) struct Step1 {
    /// Diffuse albedo per channel.
    pub(crate) rho_d: Vec<f64>,
    /// `Fr D(0)` per channel, 1/sr; below zero for a dip.
    pub(crate) peak: Vec<f64>,
    /// The distribution.
    pub(crate) distribution: ShiftedGamma,
    /// The solver's result in the unknowns ln rho_d, ln peak per channel, ln alpha, p.
    pub(crate) solution: Solution,
    /// Number of the winning start; with a free Fresnel term the starts of a dip follow those of a lobe.
    pub(crate) start: usize,
    /// Iterations of the winning start, search and finish together.
    pub(crate) iterations: u64,
}

impl Step1 {
    /// Fits the given channels with one distribution.
    pub(crate) fn fit(rows: &[Row], channels: &[usize], options: &FitOptions) -> Result<Self, LmError> {
        let bounds = bounds(channels.len())?;
        let lm_options =
            lm::Options { ftol: 1e-12, xtol: 1e-12, iteration_limit: options.max_iterations, ..lm::Options::default() };
        let search_options = lm::Options { ftol: 1e-6, xtol: 1e-5, gtol: 1e-7, ..lm_options.clone() };
        let signs =
            if options.constraint == Constraint::Free && channels.len() == 1 { &[1.0, -1.0][..] } else { &[1.0] };
        let exact: Vec<Problem> =
            signs.iter().map(|&sign| Problem::new(rows, channels, options, sign, Masking::Exact)).collect();
        let table = G1Table::of(options.sample_position);
        let thinned: Vec<Problem> = exact.iter().map(|problem| problem.thinned(table)).collect();
        let starts: Vec<(usize, [f64; 2])> =
            (0..signs.len()).flat_map(|which| options.starts.iter().map(move |&start| (which, start))).collect();
        let searched: Vec<Solution> = starts
            .par_iter()
            .map(|&(which, start)| lm::minimise(&thinned[which], &exact[which].start(start), &bounds, &search_options))
            .collect::<Result<_, _>>()?;
        let best = searched.iter().map(|solution| solution.cost).fold(f64::INFINITY, f64::min);
        let mut winner: Option<(Solution, usize, u64)> = None;
        let mut finished: Vec<(usize, &[f64])> = Vec::new();
        for (index, (found, &(which, _))) in searched.iter().zip(&starts).enumerate() {
            let same = |other: &[f64]| other.iter().zip(&found.parameters).all(|(a, b)| (a - b).abs() < REPEATED);
            if found.cost > CONTENDER * best || finished.iter().any(|&(other, at)| other == which && same(at)) {
                continue;
            }
            finished.push((which, &found.parameters));
            let solution = lm::minimise(&exact[which], &found.parameters, &bounds, &lm_options)?;
            if winner.as_ref().is_none_or(|(other, ..)| solution.cost < other.cost) {
                let iterations = found.iterations + solution.iterations;
                winner = Some((solution, index, iterations));
            }
        }
        let (solution, start, iterations) = winner.expect("the best start is always a contender");
        let sign = signs[starts[start].0];
        let n = channels.len();
        let value = |index: usize, range: [f64; 2]| match solution.active[index] {
            Some(Bound::Lower) => range[0],
            Some(Bound::Upper) => range[1],
            None => libm::exp(solution.parameters[index]),
        };
        let alpha = value(2 * n, ALPHA_RANGE);
        let distribution = ShiftedGamma::new(alpha, solution.parameters[2 * n + 1])
            .expect("the box lies inside of the model's domain");
        Ok(Self {
            rho_d: (0..n).map(|c| value(2 * c, DIFFUSE_RANGE)).collect(),
            peak: (0..n).map(|c| sign * value(2 * c + 1, PEAK_RANGE)).collect(),
            distribution,
            solution,
            start,
            iterations,
        })
    }

    /// The cost of given parameters in one channel.
    pub(crate) fn cost_of(rows: &[Row], channel: usize, sgd: &Sgd, options: &FitOptions) -> f64 {
        let problem = Problem::new(rows, &[channel], options, 1.0, Masking::Exact);
        let fr = sgd.parameters().rho_s * sgd.parameters().fresnel().value(1.0);
        let squares = problem.rows.iter().map(|row| {
            let ratio = sgd.smith().g1(row.theta) / row.cos;
            let y = (sgd.parameters().rho_d + fr * sgd.distribution().d_at(row.theta) * ratio * ratio) / PI;
            let residual = row.weight * (row.transformed[channel] - problem.loss.transform(y, row.cos).0);
            residual * residual
        });
        0.5 * squares.sum::<f64>()
    }

    /// `Fr`, the mean of `rho_s F(0)` over the peak, of the n-th channel of the fit.
    pub(crate) fn fr(&self, n: usize) -> f64 {
        self.peak[n] / self.distribution.d_at(0.0)
    }

    /// Whether the slice has no specular lobe at all: its height ended at the lower bound, and is taken as zero.
    pub(crate) fn is_flat(&self, n: usize) -> bool {
        self.solution.active[2 * n + 1] == Some(Bound::Lower)
    }

    /// The fitted slice at theta_h for the n-th channel of the fit, 1/sr.
    pub(crate) fn curve(&self, n: usize, smith: &SmithG1, theta_h: f64) -> f64 {
        if self.is_flat(n) { self.rho_d[n] / PI } else { self.curve_with_lobe(n, smith, theta_h) }
    }

    /// The same with the lobe even where it is negligible.
    pub(crate) fn curve_with_lobe(&self, n: usize, smith: &SmithG1, theta_h: f64) -> f64 {
        let ratio = smith.g1(theta_h) / libm::cos(theta_h);
        (self.rho_d[n] + self.fr(n) * self.distribution.d_at(theta_h) * ratio * ratio) / PI
    }
}

fn bounds(channels: usize) -> Result<Bounds, LmError> {
    let side = |end: usize| {
        let mut list = Vec::with_capacity(2 * channels + 2);
        for _ in 0..channels {
            list.extend([libm::log(DIFFUSE_RANGE[end]), libm::log(PEAK_RANGE[end])]);
        }
        list.extend([libm::log(ALPHA_RANGE[end]), P_RANGE[end]]);
        list
    };
    Bounds::new(side(0), side(1))
}

/// Names of the unknowns, for reports, with the n-th channel's index.
pub(crate) fn unknown_name(index: usize, channels: usize) -> &'static str {
    match index.checked_sub(2 * channels) {
        Some(0) => "alpha",
        Some(_) => "p",
        None if index.is_multiple_of(2) => "rho_d",
        None => "peak",
    }
}

/// Where G1 comes from.
#[derive(Clone, Copy)]
enum Masking {
    Table(&'static G1Table),
    Exact,
}

/// The least-squares problem of step 1 for channels that share alpha and p; unknowns ln rho_d, ln peak per channel, ln alpha, p.
#[derive(Clone)]
struct Problem {
    rows: Vec<FixedRow>,
    blocks: Vec<Block>,
    channels: Vec<usize>,
    loss: Loss,
    /// +1 for a lobe, -1 for a dip of the slice around theta_h = 0, which only a free Fresnel term can follow.
    sign: f64,
    masking: Masking,
}

/// A row with what does not change during the fit.
#[derive(Clone)]
struct FixedRow {
    bin: usize,
    theta: f64,
    cos: f64,
    weight: f64,
    measured: [f64; 3],
    /// `T(m)` per channel.
    transformed: [f64; 3],
}

/// Four rows; the last block repeats its last row.
#[derive(Clone)]
struct Block {
    bins: [usize; LANES],
    thetas: [f64; LANES],
    tan_square: f64x4,
    cos: f64x4,
    /// `1 / cos^6`: of D's `1/cos^4` and of the masking's `1/cos^2`.
    secant_sixth: f64x4,
    weight: f64x4,
    transformed: [f64x4; 3],
}

const LANES: usize = 4;

impl Block {
    fn new(rows: &[FixedRow]) -> Self {
        let lanes = |value: &dyn Fn(&FixedRow) -> f64| {
            f64x4::from(std::array::from_fn(|lane| value(&rows[lane.min(rows.len() - 1)])))
        };
        Self {
            bins: std::array::from_fn(|lane| rows[lane.min(rows.len() - 1)].bin),
            thetas: lanes(&|row| row.theta).to_array(),
            tan_square: lanes(&|row| libm::pow(libm::tan(row.theta), 2.0)),
            cos: lanes(&|row| row.cos),
            secant_sixth: lanes(&|row| libm::pow(row.cos, -6.0)),
            weight: lanes(&|row| row.weight),
            transformed: [0, 1, 2].map(|c: usize| lanes(&|row| row.transformed[c])),
        }
    }
}

impl Loss {
    /// `(T(f), T'(f))` of step 1.
    fn transform(self, f: f64, cos: f64) -> (f64, f64) {
        match self {
            Self::Log1pCos => (libm::log1p(f * cos), cos / (1.0 + f * cos)),
            Self::SqrtCos => {
                let root = (f * cos).sqrt();
                (root, 0.5 * cos / root)
            }
            Self::L2 => (f, 1.0),
        }
    }

    /// [`Self::transform`] of four rows; NaN where the logarithm does not exist.
    fn transform_four(self, f: f64x4, cos: f64x4) -> (f64x4, f64x4) {
        let product = f * cos;
        match self {
            Self::Log1pCos => {
                let above = product.simd_gt(f64x4::splat(-1.0));
                (above.select(product.ln_1p(), f64x4::splat(f64::NAN)), cos / (product + 1.0))
            }
            Self::SqrtCos => {
                let root = product.sqrt();
                (root, cos * 0.5 / root)
            }
            Self::L2 => (f, f64x4::splat(1.0)),
        }
    }

    /// Exponent of the ring's solid angle in the weight of step 1.
    fn weight_exponent(self) -> f64 {
        match self {
            Self::Log1pCos => 0.375,
            Self::SqrtCos | Self::L2 => 0.5,
        }
    }
}

impl Problem {
    fn new(rows: &[Row], channels: &[usize], options: &FitOptions, sign: f64, masking: Masking) -> Self {
        let loss = options.loss;
        let rows = rows
            .iter()
            .map(|row| {
                let cos = libm::cos(row.theta);
                FixedRow {
                    bin: row.bin,
                    theta: row.theta,
                    cos,
                    weight: libm::pow(ring(Dimensions::HALF_TURN, row.bin), loss.weight_exponent()),
                    measured: row.measured,
                    transformed: row.measured.map(|m| loss.transform(m, cos).0),
                }
            })
            .collect::<Vec<_>>();
        let blocks = rows.chunks(LANES).map(Block::new).collect();
        Self { rows, blocks, channels: channels.to_vec(), loss, sign, masking }
    }

    /// The problem of the search: masking from the table, and of the rows beyond [`DENSE_BINS`] every third one, whose square counts
    /// three times.
    fn thinned(&self, table: &'static G1Table) -> Self {
        let kept = self.rows.iter().filter(|row| row.bin <= DENSE_BINS || row.bin.is_multiple_of(THINNING));
        let rows: Vec<FixedRow> = kept
            .map(|row| {
                let factor = if row.bin > DENSE_BINS { (THINNING as f64).sqrt() } else { 1.0 };
                FixedRow { weight: row.weight * factor, ..row.clone() }
            })
            .collect();
        let blocks = rows.chunks(LANES).map(Block::new).collect();
        Self { rows, blocks, masking: Masking::Table(table), channels: self.channels.clone(), ..*self }
    }

    /// The unknowns at a start (alpha, p): the diffuse level from the 10 % quantile of the rows, the peak from the largest; for a
    /// dip the 90 % quantile and the smallest.
    fn start(&self, [alpha, p]: [f64; 2]) -> Vec<f64> {
        let mut unknowns = Vec::with_capacity(self.parameters());
        for &channel in &self.channels {
            let mut values: Vec<f64> = self.rows.iter().map(|row| row.measured[channel]).collect();
            values.sort_by(f64::total_cmp);
            let (share, extreme) = if self.sign > 0.0 { (0.1, values[values.len() - 1]) } else { (0.9, values[0]) };
            let rho_d = (PI * quantile(&values, share)).clamp(START_FLOOR, DIFFUSE_RANGE[1]);
            // the shape rises to at most 3.65 inside of the box: a dip this deep leaves the model above zero
            let most = if self.sign > 0.0 { f64::INFINITY } else { 0.25 * rho_d };
            let peak = (self.sign * (PI * extreme - rho_d)).max(START_FLOOR).min(most);
            unknowns.extend([libm::log(rho_d), libm::log(peak)]);
        }
        unknowns.extend([libm::log(alpha), p]);
        unknowns
    }

    /// Per block the shape `D(theta_h)/D(0) G1^2 / cos^2` and the derivatives of its logarithm by ln alpha and p.
    fn shapes(&self, ln_alpha: f64, p: f64) -> impl Iterator<Item = (&Block, f64x4, [f64x4; 2])> {
        let alpha = libm::exp(ln_alpha);
        let stencil = match self.masking {
            Masking::Table(table) => Some((table, table.stencil(ln_alpha, p))),
            Masking::Exact => None,
        };
        let smith = ShiftedGamma::new(alpha, p).map(|distribution| SmithG1::new(&distribution));
        self.blocks.iter().map(move |block| {
            let (ln_g1, g1_slopes) = match (&stencil, &smith) {
                (Some((table, stencil)), _) => table.ln_g1(stencil, block.bins),
                (None, Some(smith)) => {
                    let lanes = block.thetas.map(|theta| smith.g1_with_slopes(theta));
                    let ln_g1 = f64x4::from(lanes.map(|(g1, _)| g1)).ln();
                    let by_ln_alpha = f64x4::from(lanes.map(|(g1, [by_alpha, _])| alpha * by_alpha / g1));
                    (ln_g1, [by_ln_alpha, f64x4::from(lanes.map(|(g1, [_, by_p])| by_p / g1))])
                }
                (None, None) => (f64x4::splat(f64::NAN), [f64x4::splat(f64::NAN); 2]),
            };
            // D/D(0) cos^4 = e^(-b) (alpha / (alpha + b))^p, b = tan^2 / alpha
            let b = block.tan_square * (1.0 / alpha);
            let ln_ratio = -(b * (1.0 / alpha)).ln_1p();
            let shape = (ln_ratio * p - b + ln_g1 * 2.0).exp() * block.secant_sixth;
            let by_ln_alpha = b + b * (2.0 * p) / (b + alpha) + g1_slopes[0] * 2.0;
            (block, shape, [by_ln_alpha, ln_ratio + g1_slopes[1] * 2.0])
        })
    }

    fn evaluate(&self, x: &[f64], r: &mut [f64], mut jacobian: Option<&mut DMatrix<f64>>) {
        let n = self.channels.len();
        let levels: Vec<[f64; 2]> = (0..n).map(|c| [libm::exp(x[2 * c]), libm::exp(x[2 * c + 1])]).collect();
        if let Some(j) = jacobian.as_deref_mut() {
            j.fill(0.0);
        }
        for (index, (block, shape, slopes)) in self.shapes(x[2 * n], x[2 * n + 1]).enumerate() {
            let lanes = LANES.min(self.rows.len() - LANES * index);
            for c in 0..n {
                let [rho_d, peak] = levels[c];
                let lobe = shape * (self.sign * peak);
                let (transformed, slope) = self.loss.transform_four((lobe + rho_d) * (1.0 / PI), block.cos);
                let residual = (block.weight * (block.transformed[self.channels[c]] - transformed)).to_array();
                for lane in 0..lanes {
                    r[(LANES * index + lane) * n + c] = residual[lane];
                }
                if let Some(j) = jacobian.as_deref_mut() {
                    let outer = -block.weight * slope * (1.0 / PI);
                    let by_lobe = outer * lobe;
                    let columns = [2 * c, 2 * c + 1, 2 * n, 2 * n + 1];
                    let values = [outer * rho_d, by_lobe, by_lobe * slopes[0], by_lobe * slopes[1]];
                    for (column, values) in columns.into_iter().zip(values.map(f64x4::to_array)) {
                        for lane in 0..lanes {
                            j[((LANES * index + lane) * n + c, column)] = values[lane];
                        }
                    }
                }
            }
        }
    }
}

impl LeastSquares for Problem {
    fn parameters(&self) -> usize {
        2 * self.channels.len() + 2
    }

    fn rows(&self) -> usize {
        self.rows.len() * self.channels.len()
    }

    fn residuals(&self, x: &[f64], r: &mut [f64]) {
        self.evaluate(x, r, None);
    }

    fn residuals_and_jacobian(&self, x: &[f64], r: &mut [f64], j: &mut DMatrix<f64>) {
        self.evaluate(x, r, Some(j));
    }
}

/// Quantile of sorted values, linear between order statistics.
fn quantile(sorted: &[f64], share: f64) -> f64 {
    let position = share * (sorted.len() - 1) as f64;
    let low = position.floor() as usize;
    let high = (low + 1).min(sorted.len() - 1);
    sorted[low] + (position - low as f64) * (sorted[high] - sorted[low])
}
