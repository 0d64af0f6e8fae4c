//! Smith's `ln G1` at the rows of the theta_h slice over the box of (alpha, p): what step 1 searches with.

use crate::options::{ALPHA_RANGE, P_RANGE};
use brdfit_brdf::{ShiftedGamma, SmithG1};
use brdfit_measured::{Dimensions, SamplePosition};
use std::sync::OnceLock;
use wide::f64x4;

/// Spacing of the nodes in `ln alpha` and in `p`.
const STEP: [f64; 2] = [0.25, 0.2];

/// `ln G1(theta)` on a lattice over (ln alpha, p), at the 90 sample angles of the theta_h slice, with bicubic (Catmull-Rom)
/// interpolation: once continuously differentiable, error of `G1` below 2e-4 up to 75 degrees, where the cut-off lies by
/// default (test below). A search on it ends so close to the exact minimum that a few iterations with the quadrature finish it.
pub(crate) struct G1Table {
    /// Nodes along ln alpha and p, one more on each side than the box needs.
    nodes: [usize; 2],
    /// `values[(i * nodes[1] + j) * 90 + bin]`
    values: Vec<f64>,
}

/// Where (ln alpha, p) lies in the lattice, with the weights of its sixteen nodes and their derivatives.
pub(crate) struct Stencil {
    /// Offset of each node's 90 values.
    offsets: [usize; 16],
    weights: [f64; 16],
    by_ln_alpha: [f64; 16],
    by_p: [f64; 16],
}

impl G1Table {
    /// The table of a sample position; built when first asked for, some 30 ms.
    pub(crate) fn of(position: SamplePosition) -> &'static Self {
        static TABLES: [OnceLock<G1Table>; 2] = [OnceLock::new(), OnceLock::new()];
        let slot = match position {
            SamplePosition::Edge => 0,
            SamplePosition::Centre => 1,
        };
        TABLES[slot].get_or_init(|| Self::new(position))
    }

    fn new(position: SamplePosition) -> Self {
        let span = |range: [f64; 2], step: f64| ((range[1] - range[0]) / step).ceil() as usize + 3;
        let nodes = [span(ALPHA_RANGE.map(libm::log), STEP[0]), span(P_RANGE, STEP[1])];
        let cotangents: Vec<f64> = (0..90)
            .map(|bin| {
                let theta = Dimensions::HALF_TURN.theta_h_sample(bin, position);
                libm::cos(theta) / libm::sin(theta)
            })
            .collect();
        let mut values = Vec::with_capacity(nodes[0] * nodes[1] * 90);
        for i in 0..nodes[0] {
            let alpha = libm::exp(libm::log(ALPHA_RANGE[0]) + (i as f64 - 1.0) * STEP[0]);
            for j in 0..nodes[1] {
                let p = P_RANGE[0] + (j as f64 - 1.0) * STEP[1];
                let distribution = ShiftedGamma::new(alpha, p).expect("the box lies inside of the model's domain");
                let smith = SmithG1::new(&distribution);
                // ln G1 = -ln(1 + mu Lambda / mu); at the normal mu is infinite
                values.extend(
                    cotangents.iter().map(
                        |&mu| {
                            if mu.is_finite() { -libm::log1p(smith.mu_lambda(mu) / mu) } else { 0.0 }
                        },
                    ),
                );
            }
        }
        Self { nodes, values }
    }

    /// The stencil of a point of the box.
    pub(crate) fn stencil(&self, ln_alpha: f64, p: f64) -> Stencil {
        let (i, w_i, d_i) = place((ln_alpha - libm::log(ALPHA_RANGE[0])) / STEP[0], self.nodes[0]);
        let (j, w_j, d_j) = place((p - P_RANGE[0]) / STEP[1], self.nodes[1]);
        let mut stencil = Stencil { offsets: [0; 16], weights: [0.0; 16], by_ln_alpha: [0.0; 16], by_p: [0.0; 16] };
        for a in 0..4 {
            for b in 0..4 {
                let n = 4 * a + b;
                stencil.offsets[n] = ((i + a) * self.nodes[1] + j + b) * 90;
                stencil.weights[n] = w_i[a] * w_j[b];
                stencil.by_ln_alpha[n] = d_i[a] * w_j[b] / STEP[0];
                stencil.by_p[n] = w_i[a] * d_j[b] / STEP[1];
            }
        }
        stencil
    }

    /// `(ln G1, [d/d ln alpha, d/dp])` at the sample angles of four theta_h bins.
    pub(crate) fn ln_g1(&self, stencil: &Stencil, bins: [usize; 4]) -> (f64x4, [f64x4; 2]) {
        let zero = f64x4::splat(0.0);
        let (mut value, mut by_ln_alpha, mut by_p) = (zero, zero, zero);
        for n in 0..16 {
            let plane = &self.values[stencil.offsets[n]..stencil.offsets[n] + 90];
            let node = f64x4::from(bins.map(|bin| plane[bin]));
            value += node * stencil.weights[n];
            by_ln_alpha += node * stencil.by_ln_alpha[n];
            by_p += node * stencil.by_p[n];
        }
        (value, [by_ln_alpha, by_p])
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

    #[test]
    fn stays_close_to_the_quadrature_inside_the_box() {
        let table = G1Table::of(SamplePosition::Edge);
        let mut worst: f64 = 0.0;
        for n in 0..400 {
            let (u, v) = ((f64::from(n) * 0.618_033_988).fract(), (f64::from(n) * 0.754_877_666).fract());
            let ln_alpha = libm::log(1e-6) * (1.0 - u);
            let p = 2.0 * v;
            let smith = SmithG1::new(&ShiftedGamma::new(libm::exp(ln_alpha), p).unwrap());
            let stencil = table.stencil(ln_alpha, p);
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
        let table = G1Table::of(SamplePosition::Centre);
        for (ln_alpha, p) in [(-7.3, 0.37), (-2.05, 1.61), (-0.02, 0.01), (-13.8, 1.99)] {
            let value = |a: f64, b: f64| table.ln_g1(&table.stencil(a, b), [80; 4]).0.to_array()[0];
            let (_, slopes) = table.ln_g1(&table.stencil(ln_alpha, p), [80; 4]);
            let [by_ln_alpha, by_p] = slopes.map(|slope| slope.to_array()[1]);
            let h = 1e-6;
            assert!((by_ln_alpha - (value(ln_alpha + h, p) - value(ln_alpha - h, p)) / (2.0 * h)).abs() < 1e-8);
            assert!((by_p - (value(ln_alpha, p + h) - value(ln_alpha, p - h)) / (2.0 * h)).abs() < 1e-8);
        }
    }
}
