//! Smith's `ln G1` at the rows of the theta_h slice over the box of the shape parameters: for the search of step 1.

use brdfit_brdf::NormalDistribution;
use brdfit_measured::{Dimensions, SamplePosition};
use std::any::{Any, TypeId};
use std::sync::Mutex;
use wide::f64x4;

/// Rows of the slice.
const ROWS: usize = Dimensions::THETA_H;
/// Nodes of the interpolation along each unknown.
const WIDTH: usize = 4;
/// Most nodes of a stencil: two unknowns.
const LARGEST: usize = WIDTH * WIDTH;

/// `ln G1(theta)` on a lattice over the unknowns of the shape, at the 90 sample angles of the theta_h slice, with cubic
/// (Catmull-Rom) interpolation along each: once continuously differentiable. For the shifted gamma distribution the error of
/// `G1` is below 2e-4 up to 75 degrees, where the cut-off lies by default (test below). A search on it ends so close to the
/// exact minimum that a few iterations with the quadrature finish it.
pub(crate) struct MaskingTable<const N: usize> {
    /// The unknown at the second node along each axis, and the spacing.
    origin: [f64; N],
    step: [f64; N],
    /// Nodes along each axis, one more on each side than the box needs.
    nodes: [usize; N],
    /// 90 values per node, the last axis fastest.
    values: Vec<f64>,
}

/// Position of a shape in the lattice, with the weights of its nodes and their derivatives.
pub(crate) struct Stencil<const N: usize> {
    /// Offset of each node's 90 values.
    offsets: [usize; LARGEST],
    weights: [f64; LARGEST],
    slopes: [[f64; LARGEST]; N],
}

/// The requested tables.
static TABLES: Mutex<Vec<(TypeId, SamplePosition, &(dyn Any + Send + Sync))>> = Mutex::new(Vec::new());

impl<const N: usize> MaskingTable<N> {
    /// The table of a distribution at a sample position; built on first use, in about 30 ms. `None` for a distribution
    /// whose `G1` costs less than a table.
    pub(crate) fn of<D: NormalDistribution<N>>(position: SamplePosition) -> Option<&'static Self> {
        let step = D::SEARCH_LATTICE?;
        let mut tables = TABLES.lock().expect("no table panics while it is built");
        let id = TypeId::of::<D>();
        let known = tables.iter().find(|(other, at, _)| *other == id && *at == position).map(|(.., table)| *table);
        let table = known.unwrap_or_else(|| {
            let table: &'static Self = Box::leak(Box::new(Self::new::<D>(step, position)));
            tables.push((id, position, table));
            table
        });
        table.downcast_ref()
    }

    fn new<D: NormalDistribution<N>>(step: [f64; N], position: SamplePosition) -> Self {
        const { assert!(N >= 1 && N <= 2, "a stencil holds the nodes of two unknowns") };
        let transforms = D::SHAPE.map(|parameter| parameter.transform);
        let [low, high]: [[f64; N]; 2] =
            [0, 1].map(|end: usize| D::SHAPE.map(|parameter| parameter.transform.unknown(parameter.range[end])));
        let nodes: [usize; N] = std::array::from_fn(|n| ((high[n] - low[n]) / step[n]).ceil() as usize + 3);
        let cotangents: Vec<f64> = (0..ROWS)
            .map(|bin| {
                let theta = Dimensions::HALF_TURN.theta_h_sample(bin, position);
                libm::cos(theta) / libm::sin(theta)
            })
            .collect();
        let mut values = Vec::with_capacity(nodes.iter().product::<usize>() * ROWS);
        for node in 0..nodes.iter().product() {
            let place: [usize; N] = std::array::from_fn(|n| node / nodes[n + 1..].iter().product::<usize>() % nodes[n]);
            let shape = std::array::from_fn(|n| transforms[n].parameter(low[n] + (place[n] as f64 - 1.0) * step[n]));
            let distribution = D::from_shape(shape).expect("the box lies inside of the model's domain");
            // ln G1 = -ln(1 + mu Lambda / mu); at the normal mu is infinite
            let ln_g1 = |&mu: &f64| if mu.is_finite() { -libm::log1p(distribution.mu_lambda(mu) / mu) } else { 0.0 };
            values.extend(cotangents.iter().map(ln_g1));
        }
        Self { origin: low, step, nodes, values }
    }

    /// The stencil of a point of the box.
    pub(crate) fn stencil(&self, unknowns: &[f64; N]) -> Stencil<N> {
        let axes: [_; N] = std::array::from_fn(|n| place((unknowns[n] - self.origin[n]) / self.step[n], self.nodes[n]));
        let (offsets, weights, slopes) = ([0; LARGEST], [0.0; LARGEST], [[0.0; LARGEST]; N]);
        let mut stencil = Stencil { offsets, weights, slopes };
        for node in 0..WIDTH.pow(N as u32) {
            // the last axis fastest
            let along = |n: usize| node / WIDTH.pow((N - 1 - n) as u32) % WIDTH;
            let (mut offset, mut weight) = (0, 1.0);
            for (n, (first, weights, _)) in axes.iter().enumerate() {
                offset = offset * self.nodes[n] + first + along(n);
                weight *= weights[along(n)];
            }
            stencil.offsets[node] = offset * ROWS;
            stencil.weights[node] = weight;
            for (by, slopes) in stencil.slopes.iter_mut().enumerate() {
                let factor = |n: usize| if n == by { axes[n].2[along(n)] } else { axes[n].1[along(n)] };
                slopes[node] = (0..N).map(factor).product::<f64>() / self.step[by];
            }
        }
        stencil
    }

    /// `ln G1` and its derivatives with respect to the unknowns, at the sample angles of four theta_h bins.
    pub(crate) fn ln_g1(&self, stencil: &Stencil<N>, bins: [usize; 4]) -> (f64x4, [f64x4; N]) {
        let zero = f64x4::splat(0.0);
        let (mut value, mut slopes) = (zero, [zero; N]);
        for node in 0..WIDTH.pow(N as u32) {
            let plane = &self.values[stencil.offsets[node]..stencil.offsets[node] + ROWS];
            let values = f64x4::from(bins.map(|bin| plane[bin]));
            value += values * stencil.weights[node];
            for (slope, weights) in slopes.iter_mut().zip(&stencil.slopes) {
                *slope += values * weights[node];
            }
        }
        (value, slopes)
    }
}

/// First node, weights and derivatives of the four nodes around a position counted in steps from the second node.
fn place(position: f64, nodes: usize) -> (usize, [f64; 4], [f64; 4]) {
    let cell = position.floor().clamp(0.0, (nodes - 4) as f64);
    let t = position - cell;
    let weights = [
        0.5 * t * (t * (2.0 - t) - 1.0),
        0.5 * (t * t * (3.0 * t - 5.0) + 2.0),
        0.5 * t * (t * (4.0 - 3.0 * t) + 1.0),
        0.5 * t * t * (t - 1.0),
    ];
    let slopes = [
        0.5 * (t * (4.0 - 3.0 * t) - 1.0),
        0.5 * t * (9.0 * t - 10.0),
        0.5 * (t * (8.0 - 9.0 * t) + 1.0),
        0.5 * t * (3.0 * t - 2.0),
    ];
    (cell as usize, weights, slopes)
}

#[cfg(test)]
mod tests {
    use super::*;
    use brdfit_brdf::ShiftedGamma;

    #[test]
    fn stays_close_to_the_quadrature_inside_the_box() {
        let table = MaskingTable::of::<ShiftedGamma>(SamplePosition::Edge).unwrap();
        let mut worst: f64 = 0.0;
        for n in 0..400 {
            let (u, v) = ((f64::from(n) * 0.618_033_988).fract(), (f64::from(n) * 0.754_877_666).fract());
            let ln_alpha = libm::log(1e-6) * (1.0 - u);
            let p = 2.0 * v;
            let smith = ShiftedGamma::new(libm::exp(ln_alpha), p).unwrap();
            let stencil = table.stencil(&[ln_alpha, p]);
            for bin in 0..=82 {
                let theta = Dimensions::HALF_TURN.theta_h_sample(bin, SamplePosition::Edge);
                let (value, _) = table.ln_g1(&stencil, [bin; 4]);
                worst = worst.max((libm::exp(value.to_array()[3]) - smith.g1(theta)).abs());
            }
        }
        println!("largest error of the tabulated G1 up to 75 degrees: {worst:.1e}");
        assert!(worst < 2e-4, "{worst}");
    }

    #[test]
    fn slopes_are_those_of_the_interpolant() {
        let table = MaskingTable::of::<ShiftedGamma>(SamplePosition::Centre).unwrap();
        for (ln_alpha, p) in [(-7.3, 0.37), (-2.05, 1.61), (-0.02, 0.01), (-13.8, 1.99)] {
            let value = |a: f64, b: f64| table.ln_g1(&table.stencil(&[a, b]), [80; 4]).0.to_array()[0];
            let (_, slopes) = table.ln_g1(&table.stencil(&[ln_alpha, p]), [80; 4]);
            let [by_ln_alpha, by_p] = slopes.map(|slope| slope.to_array()[1]);
            let h = 1e-6;
            assert!((by_ln_alpha - (value(ln_alpha + h, p) - value(ln_alpha - h, p)) / (2.0 * h)).abs() < 1e-8);
            assert!((by_p - (value(ln_alpha, p + h) - value(ln_alpha, p - h)) / (2.0 * h)).abs() < 1e-8);
        }
    }
}
