//! Step 1: diffuse level, peak height and distribution from the theta_h slice (thesis V.4, eq. V.6).
//!
//! `m_h(theta_h) ~ [rho_d + Fr D(theta_h) G1(theta_h)^2 / cos^2 theta_h] / pi`, in the unknowns ln rho_d, ln(Fr D(0)) of each
//! channel, ln alpha and p. With the peak height `Fr D(0)` instead of Fr the unknowns are far less correlated, and the
//! normalisation K drops out of the shape.

use crate::g1_table::G1Table;
use crate::lm::{self, Bound, Bounds, LeastSquares, LmError, Solution};
use crate::options::{ALPHA_RANGE, Constraint, FitOptions, Loss, P_RANGE};
use crate::rows::{Row, ring};
use brdfit_brdf::{Sgd, ShiftedGamma, SmithG1};
use brdfit_merl::Dimensions;
use nalgebra::DMatrix;
use rayon::prelude::*;
use std::f64::consts::PI;

/// Bounds of rho_d and of the peak height `Fr D(0)`.
const DIFFUSE_RANGE: [f64; 2] = [1e-6, 10.0];
const PEAK_RANGE: [f64; 2] = [1e-6, 1e7];
/// The least that a start may be.
const START_FLOOR: f64 = 1e-5;
/// A start whose search on the table ends at most this much above the best one is finished with the exact masking too.
const CONTENDER: f64 = 1.02;

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
        let lm_options = lm::Options { iteration_limit: options.max_iterations, ..lm::Options::default() };
        let search_options = lm::Options { ftol: 1e-7, xtol: 1e-7, gtol: 1e-7, ..lm_options.clone() };
        let problem = |sign, masking| Problem::new(rows, channels, options, sign, masking);
        let table = Masking::Table(G1Table::of(options.sample_position));
        let signs =
            if options.constraint == Constraint::Free && channels.len() == 1 { &[1.0, -1.0][..] } else { &[1.0] };
        let starts: Vec<(f64, [f64; 2])> =
            signs.iter().flat_map(|&sign| options.starts.iter().map(move |&start| (sign, start))).collect();
        let searched: Vec<Solution> = starts
            .par_iter()
            .map(|&(sign, start)| {
                let search = problem(sign, table);
                lm::minimise(&search, &search.start(start), &bounds, &search_options)
            })
            .collect::<Result<_, _>>()?;
        let best = searched.iter().map(|solution| solution.cost).fold(f64::INFINITY, f64::min);
        let mut winner: Option<(Solution, usize, u64)> = None;
        let mut finished: Vec<(f64, &[f64])> = Vec::new();
        for (index, (found, &(sign, _))) in searched.iter().zip(&starts).enumerate() {
            let same = |other: &[f64]| other.iter().zip(&found.parameters).all(|(a, b)| (a - b).abs() < 1e-4);
            if found.cost > CONTENDER * best || finished.iter().any(|&(other, at)| other == sign && same(at)) {
                continue;
            }
            finished.push((sign, &found.parameters));
            let solution = lm::minimise(&problem(sign, Masking::Exact), &found.parameters, &bounds, &lm_options)?;
            if winner.as_ref().is_none_or(|(other, ..)| solution.cost < other.cost) {
                let iterations = found.iterations + solution.iterations;
                winner = Some((solution, index, iterations));
            }
        }
        let (solution, start, iterations) = winner.expect("the best start is always a contender");
        let sign = starts[start].0;
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
    channels: Vec<usize>,
    loss: Loss,
    /// +1 for a lobe, -1 for a dip of the slice around theta_h = 0, which only a free Fresnel term can follow.
    sign: f64,
    masking: Masking,
}

/// What does not change during the fit.
#[derive(Clone)]
struct FixedRow {
    bin: usize,
    theta: f64,
    tan_square: f64,
    cos: f64,
    /// `1 / cos^6`: of D's `1/cos^4` and of the masking's `1/cos^2`.
    secant_sixth: f64,
    weight: f64,
    measured: [f64; 3],
    /// `T(m)` per channel.
    transformed: [f64; 3],
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
                let (cos, tan) = (libm::cos(row.theta), libm::tan(row.theta));
                let square = cos * cos;
                FixedRow {
                    bin: row.bin,
                    theta: row.theta,
                    tan_square: tan * tan,
                    cos,
                    secant_sixth: 1.0 / (square * square * square),
                    weight: libm::pow(ring(Dimensions::HALF_TURN, row.bin), loss.weight_exponent()),
                    measured: row.measured,
                    transformed: row.measured.map(|m| loss.transform(m, cos).0),
                }
            })
            .collect();
        Self { rows, channels: channels.to_vec(), loss, sign, masking }
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

    /// Per row the shape `D(theta_h)/D(0) G1^2 / cos^2` and the derivatives of its logarithm by ln alpha and p.
    fn shapes(&self, ln_alpha: f64, p: f64) -> impl Iterator<Item = (&FixedRow, f64, [f64; 2])> {
        let alpha = libm::exp(ln_alpha);
        let stencil = match self.masking {
            Masking::Table(table) => Some((table, table.stencil(ln_alpha, p))),
            Masking::Exact => None,
        };
        let smith = ShiftedGamma::new(alpha, p).map(|distribution| SmithG1::new(&distribution));
        self.rows.iter().map(move |row| {
            let (ln_g1, g1_slopes) = match (&stencil, &smith) {
                (Some((table, stencil)), _) => table.ln_g1(stencil, row.bin),
                (None, Some(smith)) => {
                    let (g1, [by_alpha, by_p]) = smith.g1_with_slopes(row.theta);
                    (libm::log(g1), [alpha * by_alpha / g1, by_p / g1])
                }
                (None, None) => (f64::NAN, [f64::NAN; 2]),
            };
            // D/D(0) cos^4 = e^(-b) (alpha / (alpha + b))^p, b = tan^2 / alpha
            let b = row.tan_square / alpha;
            let ln_ratio = -libm::log1p(b / alpha);
            let shape = libm::exp(p * ln_ratio - b + 2.0 * ln_g1) * row.secant_sixth;
            let by_ln_alpha = b + 2.0 * p * b / (alpha + b) + 2.0 * g1_slopes[0];
            (row, shape, [by_ln_alpha, ln_ratio + 2.0 * g1_slopes[1]])
        })
    }

    fn evaluate(&self, x: &[f64], r: &mut [f64], mut jacobian: Option<&mut DMatrix<f64>>) {
        let n = self.channels.len();
        let levels: Vec<[f64; 2]> = (0..n).map(|c| [libm::exp(x[2 * c]), libm::exp(x[2 * c + 1])]).collect();
        if let Some(j) = jacobian.as_deref_mut() {
            j.fill(0.0);
        }
        let mut index = 0;
        for (row, shape, slopes) in self.shapes(x[2 * n], x[2 * n + 1]) {
            for c in 0..n {
                let [rho_d, peak] = levels[c];
                let lobe = self.sign * peak * shape;
                let (transformed, slope) = self.loss.transform((rho_d + lobe) / PI, row.cos);
                r[index] = row.weight * (row.transformed[self.channels[c]] - transformed);
                if let Some(j) = jacobian.as_deref_mut() {
                    let outer = -row.weight * slope / PI;
                    j[(index, 2 * c)] = outer * rho_d;
                    j[(index, 2 * c + 1)] = outer * lobe;
                    j[(index, 2 * n)] = outer * lobe * slopes[0];
                    j[(index, 2 * n + 1)] = outer * lobe * slopes[1];
                }
                index += 1;
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
