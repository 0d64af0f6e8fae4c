//! Positions in tables whose nodes are the single-precision numbers with a short fraction.

use wide::{bytemuck::cast, f32x8, i32x8};

/// Nodes per power of two, as bits of a number's fraction.
const FRACTION_BITS: u32 = 5;
/// The rest of the fraction: the position between two nodes.
const REST_BITS: u32 = 23 - FRACTION_BITS;
const REST_MASK: i32 = (1 << REST_BITS) - 1;

/// The numbers in single precision from one to another whose fraction ends after 5 bits, 32 per power of two: the interval of a
/// number and its place in it are read off its bits, without a logarithm.
#[derive(Clone, Copy, Debug)]
pub(crate) struct FractionNodes {
    low: f32,
    high: f32,
}

impl FractionNodes {
    /// Nodes that enclose a range of numbers above zero.
    pub(crate) fn around(low: f64, high: f64) -> Self {
        let node = |x: f64| (x as f32).to_bits() >> REST_BITS;
        let at = |node: u32| f32::from_bits(node << REST_BITS);
        Self { low: at(node(low)), high: at(node(high) + 1) }
    }

    /// The nodes in order.
    pub(crate) fn nodes(&self) -> impl Iterator<Item = f32> + use<> {
        let [first, last] = [self.low, self.high].map(|end| end.to_bits() >> REST_BITS);
        (first..=last).map(|node| f32::from_bits(node << REST_BITS))
    }

    /// The largest.
    pub(crate) fn high(&self) -> f32 {
        self.high
    }

    /// For eight numbers, held between the ends: which node lies at or below, and the share of the way to the next. At the largest
    /// node the share is zero and there is no next one.
    #[inline(always)]
    pub(crate) fn place(&self, x: f32x8) -> ([usize; 8], f32x8) {
        let held: i32x8 = cast(x.fast_max(f32x8::splat(self.low)).fast_min(f32x8::splat(self.high)));
        let share = f32x8::from_i32x8(held & i32x8::splat(REST_MASK)) * (1.0 / (1 << REST_BITS) as f32);
        let place = held - i32x8::splat(self.low.to_bits() as i32);
        (place.to_array().map(|place| (place >> REST_BITS) as usize), share)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_lie_between_their_nodes() {
        let nodes = FractionNodes::around(1e-5, 3000.0);
        let all: Vec<f32> = nodes.nodes().collect();
        assert!(all[0] <= 1e-5 && all[1] > 1e-5 && *all.last().unwrap() == nodes.high() && nodes.high() > 3000.0);
        assert!(all.windows(2).all(|pair| pair[1] / pair[0] <= 1.0 + 1.0 / 32.0 && pair[1] > pair[0]));
        for n in 0..2000 {
            let x = libm::expf(-11.4 + n as f32 * 0.0097);
            let (place, share) = nodes.place(f32x8::splat(x));
            let (low, high) = (all[place[3]], all[place[3] + 1]);
            let back = low + (high - low) * share.to_array()[3];
            assert!(low <= x && x < high && (back / x - 1.0).abs() < 1e-6, "{x}: {low} {high} {back}");
        }
        let (ends, share) = nodes.place(f32x8::new([0.0, 1e9, 0.0, 1e9, 0.0, 0.0, 0.0, 0.0]));
        assert_eq!((ends[0], ends[1], share.to_array()[1]), (0, all.len() - 1, 0.0));
    }
}
