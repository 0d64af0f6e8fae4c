//! The least-squares problem of step 1: rows of the theta_h slice of channels that share one distribution.

use crate::lm::problem::LeastSquares;
use crate::options::{FitOptions, Loss};
use crate::steps::masking_table::MaskingTable;
use crate::steps::slice_rows::{Row, ring};
use brdfit_brdf::NormalDistribution;
use nalgebra::DMatrix;
use std::f64::consts::PI;
use std::marker::PhantomData;
use wide::f64x4;

/// Bounds of rho_d and of the peak height `P = pi Fr D(0) / c`.
pub(crate) const DIFFUSE_RANGE: [f64; 2] = [1e-6, 10.0];
pub(crate) const PEAK_RANGE: [f64; 2] = [1e-6, 1e7];
/// The least that a start may be.
const START_FLOOR: f64 = 1e-5;
/// The search takes every row up to this bin, where a lobe may change from row to row, and every third one beyond, with three times
/// its weight.
const DENSE_BINS: usize = 18;
const THINNING: usize = 3;

/// The kinds of unknowns of step 1; `n` counts the channels of the problem.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Unknown {
    /// ln rho_d of the n-th channel.
    Diffuse(usize),
    /// ln P of the n-th channel.
    Peak(usize),
    /// A shape parameter, transformed.
    Shape(usize),
}

/// Order of the unknowns of a problem: ln rho_d and ln P of each channel, then the shape.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Layout {
    /// Channels that share the distribution.
    pub(crate) channels: usize,
}

impl Layout {
    pub(crate) fn diffuse(self, n: usize) -> usize {
        2 * n
    }

    pub(crate) fn peak(self, n: usize) -> usize {
        2 * n + 1
    }

    pub(crate) fn shape(self, k: usize) -> usize {
        2 * self.channels + k
    }

    /// What lies at a place.
    pub(crate) fn unknown(self, index: usize) -> Unknown {
        match index.checked_sub(2 * self.channels) {
            Some(k) => Unknown::Shape(k),
            None if index.is_multiple_of(2) => Unknown::Diffuse(index / 2),
            None => Unknown::Peak(index / 2),
        }
    }
}

/// The problem for channels that share one shape.
pub(crate) struct DistributionProblem<D, const N: usize> {
    pub(crate) rows: Vec<FixedRow>,
    blocks: Vec<Block>,
    /// R, G, B: 0, 1, 2.
    channels: Vec<usize>,
    pub(crate) loss: Loss,
    /// +1 for a lobe, -1 for a dip of the slice around theta_h = 0, which only a free Fresnel term can follow.
    sign: f64,
    /// Source of G1 in a search; `None`: from the distribution itself.
    table: Option<&'static MaskingTable<N>>,
    distribution: PhantomData<fn() -> D>,
}

/// A row with what does not change during the fit.
#[derive(Clone)]
pub(crate) struct FixedRow {
    bin: usize,
    pub(crate) theta: f64,
    pub(crate) cos: f64,
    pub(crate) weight: f64,
    measured: [f64; 3],
    /// `T(m)` per channel.
    pub(crate) transformed: [f64; 3],
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
    pub(crate) fn transform(self, f: f64, cos: f64) -> (f64, f64) {
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

impl<D: NormalDistribution<N>, const N: usize> DistributionProblem<D, N> {
    pub(crate) fn new(rows: &[Row], channels: &[usize], options: &FitOptions, sign: f64) -> Self {
        let loss = options.loss;
        let rows = rows
            .iter()
            .map(|row| {
                let cos = libm::cos(row.theta);
                FixedRow {
                    bin: row.bin,
                    theta: row.theta,
                    cos,
                    weight: libm::pow(ring(row.bin), loss.weight_exponent()),
                    measured: row.measured,
                    transformed: row.measured.map(|m| loss.transform(m, cos).0),
                }
            })
            .collect();
        Self::of_rows(rows, channels.to_vec(), loss, sign, None)
    }

    fn of_rows(
        rows: Vec<FixedRow>,
        channels: Vec<usize>,
        loss: Loss,
        sign: f64,
        table: Option<&'static MaskingTable<N>>,
    ) -> Self {
        let blocks = rows.chunks(LANES).map(Block::new).collect();
        Self { rows, blocks, channels, loss, sign, table, distribution: PhantomData }
    }

    /// The problem of the search: masking from the table, and of the rows beyond [`DENSE_BINS`] every third one, whose square counts
    /// three times.
    pub(crate) fn thinned(&self, table: Option<&'static MaskingTable<N>>) -> Self {
        let kept = self.rows.iter().filter(|row| row.bin <= DENSE_BINS || row.bin.is_multiple_of(THINNING));
        let rows = kept.map(|row| {
            let factor = if row.bin > DENSE_BINS { (THINNING as f64).sqrt() } else { 1.0 };
            FixedRow { weight: row.weight * factor, ..row.clone() }
        });
        Self::of_rows(rows.collect(), self.channels.clone(), self.loss, self.sign, table)
    }

    fn layout(&self) -> Layout {
        Layout { channels: self.channels.len() }
    }

    /// The unknowns at a start: the diffuse level from the 10 % quantile of the rows, the peak from the largest; for a dip the
    /// 90 % quantile and the smallest.
    pub(crate) fn start(&self, shape: &[f64]) -> Vec<f64> {
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
        unknowns.extend(shape.iter().zip(D::SHAPE).map(|(value, parameter)| parameter.transform.unknown(*value)));
        unknowns
    }

    /// Per block `D(theta_h)/D(0) G1^2 / cos^2` and the derivatives of its logarithm with respect to the unknowns of the shape.
    fn lobes(&self, unknowns: [f64; N]) -> impl Iterator<Item = (&Block, f64x4, [f64x4; N])> {
        let shape: [f64; N] = std::array::from_fn(|n| D::SHAPE[n].transform.parameter(unknowns[n]));
        let steps: [f64; N] = std::array::from_fn(|n| D::SHAPE[n].transform.slope(shape[n]));
        let stencil = self.table.map(|table| (table, table.stencil(&unknowns)));
        let distribution = D::from_shape(shape).ok();
        self.blocks.iter().map(move |block| {
            let (ln_g1, g1_slopes) = match (&stencil, &distribution) {
                (Some((table, stencil)), _) => table.ln_g1(stencil, block.bins),
                (None, Some(distribution)) => {
                    let lanes = block.thetas.map(|theta| distribution.g1_with_slopes(theta));
                    let ln_g1 = f64x4::from(lanes.map(|(g1, _)| g1)).ln();
                    let slope = |n: usize| f64x4::from(lanes.map(|(g1, slopes)| steps[n] * slopes[n] / g1));
                    (ln_g1, std::array::from_fn(slope))
                }
                (None, None) => (f64x4::splat(f64::NAN), [f64x4::splat(f64::NAN); N]),
            };
            let (ln_shape, slopes) = D::ln_shape(&shape, block.tan_square);
            let lobe = (ln_shape + ln_g1 * 2.0).exp() * block.secant_sixth;
            (block, lobe, std::array::from_fn(|n| slopes[n] + g1_slopes[n] * 2.0))
        })
    }

    fn evaluate(&self, x: &[f64], r: &mut [f64], mut jacobian: Option<&mut DMatrix<f64>>) {
        let (n, layout) = (self.channels.len(), self.layout());
        let levels: Vec<[f64; 2]> =
            (0..n).map(|c| [libm::exp(x[layout.diffuse(c)]), libm::exp(x[layout.peak(c)])]).collect();
        if let Some(j) = jacobian.as_deref_mut() {
            j.fill(0.0);
        }
        let shape = std::array::from_fn(|k| x[layout.shape(k)]);
        for (index, (block, lobe, slopes)) in self.lobes(shape).enumerate() {
            let lanes = LANES.min(self.rows.len() - LANES * index);
            for c in 0..n {
                let [rho_d, peak] = levels[c];
                let lobe = lobe * (self.sign * peak);
                let (transformed, slope) = self.loss.transform_four((lobe + rho_d) * (1.0 / PI), block.cos);
                let residual = (block.weight * (block.transformed[self.channels[c]] - transformed)).to_array();
                for lane in 0..lanes {
                    r[(LANES * index + lane) * n + c] = residual[lane];
                }
                if let Some(j) = jacobian.as_deref_mut() {
                    let outer = -block.weight * slope * (1.0 / PI);
                    let by_lobe = outer * lobe;
                    let mut store = |column: usize, values: f64x4| {
                        for (lane, value) in values.to_array()[..lanes].iter().enumerate() {
                            j[((LANES * index + lane) * n + c, column)] = *value;
                        }
                    };
                    store(layout.diffuse(c), outer * rho_d);
                    store(layout.peak(c), by_lobe);
                    for (k, slope) in slopes.iter().enumerate() {
                        store(layout.shape(k), by_lobe * *slope);
                    }
                }
            }
        }
    }
}

impl<D: NormalDistribution<N>, const N: usize> LeastSquares for DistributionProblem<D, N> {
    fn parameters(&self) -> usize {
        2 * self.channels.len() + N
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
