//! Single to half precision, rounded towards plus infinity.

use half::f16;

/// The smallest half-precision number that is not below `value`: infinity above 65504, NaN for NaN.
///
/// A renderer that chooses its resolution from the stored bandwidth must never see less than what was computed.
#[must_use]
pub fn f16_rounded_up(value: f32) -> f16 {
    let nearest = f16::from_f32(value);
    if nearest.to_f32() < value {
        // the next number upwards: one bit more for a positive number, one less in magnitude for a negative one
        let bits = nearest.to_bits();
        f16::from_bits(if nearest.is_sign_negative() { bits - 1 } else { bits + 1 })
    } else {
        nearest
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// All finite halves in increasing order, with one zero.
    fn halves() -> impl Iterator<Item = f16> {
        let negative = (0x8001..=0xFBFF).rev().map(f16::from_bits);
        negative.chain((0x0000..=0x7BFF).map(f16::from_bits))
    }

    #[test]
    fn between_all_neighbours() {
        for (low, high) in halves().zip(halves().skip(1)) {
            let (below, above) = (low.to_f32(), high.to_f32());
            assert_eq!(f16_rounded_up(below).to_f32(), below);
            for value in [below.next_up(), 0.5 * (below + above), above.next_down(), above] {
                assert_eq!(f16_rounded_up(value).to_f32(), above, "{value:e} between {below:e} and {above:e}");
            }
        }
    }

    #[test]
    fn outside_the_range() {
        assert_eq!(f16_rounded_up(65504.0_f32.next_up()), f16::INFINITY);
        assert_eq!(f16_rounded_up(f32::MAX), f16::INFINITY);
        assert_eq!(f16_rounded_up(f32::NEG_INFINITY), f16::NEG_INFINITY);
        assert_eq!(f16_rounded_up(-f32::MAX), f16::MIN);
        assert_eq!(f16_rounded_up(f32::MIN_POSITIVE), f16::from_bits(1));
        assert!(f16_rounded_up(f32::NAN).is_nan());
    }
}
