//! Smith's masking of three channels for directions that change all the time.

use crate::masking::curve::G1Curve;
use wide::{bytemuck::cast, f32x4, f32x8, i32x8};

/// Nodes per power of two of `cot^2 theta`, as bits of a number's fraction.
const FRACTION_BITS: u32 = 5;
const REST_BITS: u32 = 23 - FRACTION_BITS;
const REST_MASK: i32 = (1 << REST_BITS) - 1;

/// `mu Lambda` of three channels, linear between nodes of `mu^2 = cot^2 theta`: the numbers in single precision whose
/// fraction ends after 5 bits, so that the place in the table is read off the bits of `mu^2`. `G1` is within 8e-5 of the
/// quadrature, relative, for alpha in [1e-6, 1] and p in [0, 2] (test below).
#[derive(Clone, Debug)]
pub(crate) struct MaskingTable {
    low: f32,
    high: f32,
    nodes: Vec<f32x4>,
}

impl MaskingTable {
    pub(crate) fn new(curves: [&G1Curve; 3]) -> Self {
        let ranges = curves.map(G1Curve::range);
        let low = ranges.iter().map(|range| range[0]).fold(f64::INFINITY, f64::min);
        let high = ranges.iter().map(|range| range[1]).fold(0.0, f64::max);
        let node = |mu: f64| ((mu * mu).clamp(1e-37, 1e37) as f32).to_bits() >> REST_BITS;
        let (first, last) = (node(low), node(high) + 1);
        let at = |node: u32| f32::from_bits(node << REST_BITS);
        let mu_lambdas = |node: u32| {
            let mu = f64::from(at(node)).sqrt();
            let position = G1Curve::position(mu, 1.0);
            let [r, g, b] = curves.map(|curve| curve.mu_lambda(position, mu, 1.0) as f32);
            f32x4::new([r, g, b, 0.0])
        };
        let nodes = (first..=last).chain([last]).map(mu_lambdas).collect();
        Self { low: at(first), high: at(last), nodes }
    }

    /// `G1 / cos theta` per channel for directions with `cos theta` above zero and the square of the sine; finite.
    #[inline]
    pub(crate) fn g1_over_cos(&self, cos: f32x8, sin_square: f32x8) -> [f32x8; 3] {
        let mu_square = cos * cos / sin_square.fast_max(f32x8::splat(1e-24));
        let held: i32x8 = cast(mu_square.fast_max(f32x8::splat(self.low)).fast_min(f32x8::splat(self.high)));
        let share = f32x8::from_i32x8(held & i32x8::splat(REST_MASK)) * (1.0 / (1 << REST_BITS) as f32);
        let (place, share) = ((held - i32x8::splat(self.low.to_bits() as i32)).to_array(), share.to_array());
        let mut mu_lambda = [[0.0; 8]; 3];
        for lane in 0..8 {
            let node = (place[lane] >> REST_BITS) as usize;
            let (lower, upper) = (self.nodes[node], self.nodes[node + 1]);
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
    use crate::distributions::shifted_gamma::ShiftedGamma;
    use crate::masking::smith::SmithG1;

    #[test]
    fn follows_the_quadrature_up_to_the_horizon() {
        let mut worst: f64 = 0.0;
        for alpha in [[1e-6, 1e-5, 1e-4], [1e-3, 0.01, 0.1], [0.3, 1.0, 1e-6]] {
            for p in [0.0, 0.5, 1.0, 2.0] {
                let distributions = alpha.map(|alpha| ShiftedGamma::new(alpha, p).unwrap());
                let curves = distributions.each_ref().map(G1Curve::new);
                let table = MaskingTable::new(curves.each_ref());
                for n in 1..400 {
                    let mu = libm::exp(3.0 - f64::from(n) * 0.075);
                    let sin = 1.0 / (1.0 + mu * mu).sqrt();
                    let (cos, sin_square) = ((mu * sin) as f32, (sin * sin) as f32);
                    let found = table.g1_over_cos(f32x8::splat(cos), f32x8::splat(sin_square));
                    for c in 0..3 {
                        let exact = SmithG1::new(&distributions[c]).g1_from(mu * sin, sin) / (mu * sin);
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
