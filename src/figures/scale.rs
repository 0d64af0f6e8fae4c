//! Colour scales: a perceptual colour map and a logarithmic scale.

use image::Rgb;

use crate::srgb::byte;

/// Colour of the value 0, which has no logarithm.
pub const ZERO: Rgb<u8> = Rgb([205, 205, 205]);

/// A logarithmic scale between two powers of two.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scale {
    /// Binary logarithm of the smallest value, dark.
    pub low: i32,
    /// Binary logarithm of the value from which on all are bright alike.
    pub high: i32,
    /// Whether there are larger values.
    pub beyond: bool,
}

impl Scale {
    /// Octaves at most: values further below share the darkest colour.
    const LONGEST: i32 = 12;
    /// Share of the positive values that the scale has to tell apart: the rest, such as a few peaks at grazing angles, would
    /// leave all others dark.
    const COUNTED: f64 = 0.995;

    /// The shortest scale of at least one octave that reaches from the smallest positive value to the one that 99.5 % of
    /// the positive values do not exceed.
    #[must_use]
    pub fn of(values: impl Iterator<Item = f32>) -> Self {
        let mut positive: Vec<f32> = values.filter(|&value| value > 0.0).collect();
        if positive.is_empty() {
            return Self { low: 0, high: 1, beyond: false };
        }
        let last = (Self::COUNTED * (positive.len() - 1) as f64).ceil() as usize;
        let (below, &mut largest, above) = positive.select_nth_unstable_by(last, f32::total_cmp);
        let smallest = below.iter().copied().fold(largest, f32::min);
        let high = libm::log2f(largest).ceil() as i32;
        let low = (libm::log2f(smallest).floor() as i32).clamp(high - Self::LONGEST, high - 1);
        let limit = libm::exp2f(high as f32);
        Self { low, high, beyond: above.iter().any(|&value| value > limit) }
    }

    /// Octaves from one end to the other.
    #[must_use]
    pub fn octaves(self) -> i32 {
        self.high - self.low
    }

    /// The colour of a value.
    #[must_use]
    pub fn colour(self, value: f32) -> Rgb<u8> {
        if value > 0.0 { colour((libm::log2f(value) - self.low as f32) / self.octaves() as f32) } else { ZERO }
    }
}

/// Colours from dark violet through blue and green to light yellow for `t` from 0 to 1: equal steps of t are equal steps of
/// lightness in the Oklab space (Ottosson 2020, "A perceptual color space for image processing"), here given as lightness,
/// chroma and hue in radians.
#[must_use]
pub fn colour(t: f32) -> Rgb<u8> {
    let t = t.clamp(0.0, 1.0);
    let lightness = 0.25 + 0.67 * t;
    // as much chroma as sRGB has there: least in the blue-green middle
    let chroma = 0.09 + 0.25 * (t - 0.42) * (t - 0.42);
    let hue = 5.41 - 3.63 * t;
    let (a, b) = (chroma * libm::cosf(hue), chroma * libm::sinf(hue));
    let cube = |value: f32| value * value * value;
    let l = cube(lightness + 0.396_337_78 * a + 0.215_803_76 * b);
    let m = cube(lightness - 0.105_561_346 * a - 0.063_854_17 * b);
    let s = cube(lightness - 0.089_484_18 * a - 1.291_485_5 * b);
    Rgb([
        byte(4.076_741_7 * l - 3.307_711_6 * m + 0.230_969_94 * s),
        byte(-1.268_438 * l + 2.609_757_4 * m - 0.341_319_38 * s),
        byte(-0.004_196_086_3 * l - 0.703_418_6 * m + 1.707_614_7 * s),
    ])
}

#[cfg(test)]
mod tests {
    use super::*;

    /// CIE lightness L* of a colour.
    fn lightness(Rgb(bytes): Rgb<u8>) -> f64 {
        let linear = bytes.map(|byte| {
            let c = f64::from(byte) / 255.0;
            if c <= 0.04045 { c / 12.92 } else { ((c + 0.055) / 1.055).powf(2.4) }
        });
        let luminance = 0.2126 * linear[0] + 0.7152 * linear[1] + 0.0722 * linear[2];
        116.0 * luminance.cbrt() - 16.0
    }

    #[test]
    fn brighter_is_more() {
        let steps: Vec<f64> = (0..=64).map(|k| lightness(colour(k as f32 / 64.0))).collect();
        for pair in steps.windows(2) {
            let step = pair[1] - pair[0];
            assert!((0.4..2.5).contains(&step), "a step of {step} in lightness instead of about 1.2");
        }
    }

    #[test]
    fn zero_looks_like_no_other_value() {
        // grey, and no colour of the map is
        for k in 0..=256 {
            let Rgb(bytes) = colour(k as f32 / 256.0);
            let (low, high) = (bytes.iter().min().unwrap(), bytes.iter().max().unwrap());
            assert!(high - low >= 40, "{k}: {bytes:?}");
        }
        let scale = Scale { low: -2, high: 6, beyond: false };
        assert_eq!(scale.colour(0.0), ZERO);
        assert_eq!(scale.colour(1e-20), colour(0.0));
        assert_eq!(scale.colour(4.0), colour(0.5));
        assert_eq!(scale.colour(64.0), colour(1.0));
    }

    #[test]
    fn scales_end_at_powers_of_two() {
        let of = |values: &[f32]| Scale::of(values.iter().copied());
        let exact = |low, high| Scale { low, high, beyond: false };
        assert_eq!(of(&[0.0, 0.7, 70.0]), exact(-1, 7));
        assert_eq!(of(&[2.0, 2.0]), exact(0, 1));
        assert_eq!(of(&[1e-30, 8.0]), exact(-9, 3));
        assert_eq!(of(&[0.0]), exact(0, 1));
    }

    #[test]
    fn a_few_peaks_do_not_stretch_the_scale() {
        let mut values = vec![3.0; 1000];
        values[0] = 1.0;
        values[7] = 500.0;
        assert_eq!(Scale::of(values.iter().copied()), Scale { low: 0, high: 2, beyond: true });
    }
}
