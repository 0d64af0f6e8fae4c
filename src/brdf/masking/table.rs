//! Smith's masking of three channels as a table, for arbitrary directions.

use crate::masking::curve::G1Curve;
use crate::masking::masking::{Masking, MaskingLanes};
use crate::math::fraction_nodes::FractionNodes;
use wide::{f32x4, f32x8};

/// `mu Lambda` of three channels, linear between nodes of `mu^2 = cot^2 theta`: the numbers in single precision whose
/// fraction ends after 5 bits, so that the place in the table is read off the bits of `mu^2`. `G1` is within 8e-5 of the
/// quadrature, relative, for alpha in [1e-6, 1] and p in [0, 2] (test below).
#[derive(Clone, Debug)]
pub struct MaskingTable {
    nodes: FractionNodes,
    /// At the nodes; the last twice.
    values: Vec<f32x4>,
}

impl MaskingTable {
    /// Tabulates the curves of three channels.
    pub fn new(curves: [&G1Curve; 3]) -> Self {
        let ranges = curves.map(G1Curve::range);
        let low = ranges.iter().map(|range| range[0]).fold(f64::INFINITY, f64::min);
        let high = ranges.iter().map(|range| range[1]).fold(0.0, f64::max);
        let square = |mu: f64| (mu * mu).clamp(1e-37, 1e37);
        let nodes = FractionNodes::around(square(low), square(high));
        let mu_lambdas = |mu_square: f32| {
            let mu = f64::from(mu_square).sqrt();
            let position = G1Curve::position(mu, 1.0);
            let [r, g, b] = curves.map(|curve| curve.mu_lambda(mu, 1.0, position) as f32);
            f32x4::new([r, g, b, 0.0])
        };
        Self { nodes, values: nodes.nodes().chain([nodes.high()]).map(mu_lambdas).collect() }
    }
}

impl MaskingLanes for MaskingTable {
    #[inline]
    fn g1_over_cos(&self, cos: f32x8, sin_square: f32x8) -> [f32x8; 3] {
        let mu_square = cos * cos / sin_square.fast_max(f32x8::splat(1e-24));
        let (places, share) = self.nodes.place(mu_square);
        let share = share.to_array();
        let mut mu_lambda = [[0.0; 8]; 3];
        for lane in 0..8 {
            let node = places[lane];
            let (lower, upper) = (self.values[node], self.values[node + 1]);
            let [r, g, b, _] = (lower + (upper - lower) * share[lane]).to_array();
            (mu_lambda[0][lane], mu_lambda[1][lane], mu_lambda[2][lane]) = (r, g, b);
        }
        let sin = sin_square.sqrt();
        mu_lambda.map(|mu_lambda| 1.0 / (cos + sin * f32x8::new(mu_lambda)).fast_max(f32x8::splat(f32::MIN_POSITIVE)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::distributions::normal_distribution::NormalDistribution;
    use crate::distributions::shifted_gamma::ShiftedGamma;

    #[test]
    fn follows_the_quadrature_up_to_the_horizon() {
        let mut worst: f64 = 0.0;
        for alpha in [[1e-6, 1e-5, 1e-4], [1e-3, 0.01, 0.1], [0.3, 1.0, 1e-6]] {
            for p in [0.0, 0.5, 1.0, 2.0] {
                let distributions = alpha.map(|alpha| ShiftedGamma::new(alpha, p).unwrap());
                let curves = distributions.each_ref().map(NormalDistribution::masking);
                let table = MaskingTable::new(curves.each_ref());
                for n in 1..400 {
                    let mu = libm::exp(3.0 - f64::from(n) * 0.075);
                    let sin = 1.0 / (1.0 + mu * mu).sqrt();
                    let (cos, sin_square) = ((mu * sin) as f32, (sin * sin) as f32);
                    let found = table.g1_over_cos(f32x8::splat(cos), f32x8::splat(sin_square));
                    for c in 0..3 {
                        let exact = distributions[c].g1_from(mu * sin, sin) / (mu * sin);
                        worst = worst.max((f64::from(found[c].to_array()[0]) / exact - 1.0).abs());
                    }
                }
                let normal = table.g1_over_cos(f32x8::ONE, f32x8::ZERO);
                assert!(normal.iter().all(|found| found.to_array() == [1.0; 8]));
            }
        }
        println!("largest relative error of G1: {worst:.1e}");
        assert!(worst < 8e-5, "{worst}");
    }
}
