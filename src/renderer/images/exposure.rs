//! Exposure: from radiance to displayed values.

use brdfit_figures::srgb;

use crate::lights::octahedral::light::LUMINANCE;

/// Luminance of a linear colour, ITU-R BT.709 primaries.
#[must_use]
pub fn luminance(colour: [f32; 3]) -> f32 {
    LUMINANCE[0] * colour[0] + LUMINANCE[1] * colour[1] + LUMINANCE[2] * colour[2]
}

/// Exposure factor of radiance: exposed radiance 1 is the brightest value of the display.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Exposure(f32);

impl Exposure {
    /// Mean luminance of the exposed foreground, unless that is too bright.
    const MEAN: f64 = 0.35;
    /// Largest 95th percentile of the luminance of the exposed foreground.
    const BRIGHT: f64 = 0.9;

    /// No exposure: factor 1.
    pub const ONE: Self = Self(1.0);

    /// A factor of the user's choice; `None` unless it is positive and finite.
    #[must_use]
    pub fn new(factor: f32) -> Option<Self> {
        (factor > 0.0 && factor.is_finite()).then_some(Self(factor))
    }

    /// min(0.35 / mean, 0.9 / 95th percentile) of the luminance of the foreground, the pixels whose `foreground` is true;
    /// percentiles between two pixels are interpolated. An image without light in it gets the exposure 1, one without light
    /// in 95 % of it what its mean asks for.
    ///
    /// # Panics
    /// If image and mask differ in length.
    #[must_use]
    pub fn of(reference: &[[f32; 3]], foreground: &[bool]) -> Self {
        assert_eq!(reference.len(), foreground.len(), "one mask value per pixel");
        let shown = reference.iter().zip(foreground).filter(|&(_, &shown)| shown);
        let mut values: Vec<f32> = shown.map(|(&colour, _)| luminance(colour)).collect();
        let mean = values.iter().map(|&value| f64::from(value)).sum::<f64>() / values.len().max(1) as f64;
        let bright = percentile(&mut values, 0.95);
        let factor = (Self::MEAN / mean).min(Self::BRIGHT / bright);
        Self::new(factor as f32).unwrap_or(Self::ONE)
    }

    /// The factor.
    #[must_use]
    pub fn factor(self) -> f32 {
        self.0
    }

    /// Exposed radiance, not limited.
    #[must_use]
    pub fn expose(self, radiance: [f32; 3]) -> [f32; 3] {
        radiance.map(|value| self.0 * value)
    }

    /// Exposed radiance as components of sRGB from 0 to 1, limited to them.
    #[must_use]
    pub fn encode(self, radiance: [f32; 3]) -> [f32; 3] {
        self.expose(radiance).map(srgb::encode)
    }

    /// Exposed radiance as bytes of sRGB, rounded to the nearest.
    #[must_use]
    pub fn bytes(self, radiance: [f32; 3]) -> [u8; 3] {
        self.expose(radiance).map(srgb::byte)
    }
}

/// The value that a share of the values does not exceed, interpolated between the two nearest ranks; 0 without values.
fn percentile(values: &mut [f32], share: f64) -> f64 {
    if values.is_empty() {
        return 0.0;
    }
    let rank = share * (values.len() - 1) as f64;
    let (_, &mut below, rest) = values.select_nth_unstable_by(rank as usize, f32::total_cmp);
    let above = rest.iter().copied().min_by(f32::total_cmp).unwrap_or(below);
    f64::from(below) + (rank - rank.floor()) * (f64::from(above) - f64::from(below))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn grey(values: impl IntoIterator<Item = f32>) -> Vec<[f32; 3]> {
        values.into_iter().map(|value| [value; 3]).collect()
    }

    #[test]
    fn percentiles_are_interpolated() {
        // numpy.percentile([7, 1, 3, 2, 11], 95), by hand: rank 3.8 between 7 and 11
        let mut values = [7.0, 1.0, 3.0, 2.0, 11.0];
        assert!((percentile(&mut values, 0.95) - 10.2).abs() < 1e-12);
        assert_eq!(percentile(&mut values, 0.0), 1.0);
        assert_eq!(percentile(&mut values, 1.0), 11.0);
    }

    #[test]
    fn the_mean_decides_unless_the_brightest_are_too_bright() {
        let even = grey([2.0; 100]);
        assert!((Exposure::of(&even, &[true; 100]).factor() - 0.175).abs() < 1e-6);
        // a tenth at 8, the rest at 1: mean 1.7 asks for 0.206, the 95th percentile for 0.1125
        let spotted = grey((0..100).map(|k| if k % 10 == 0 { 8.0 } else { 1.0 }));
        assert!((Exposure::of(&spotted, &[true; 100]).factor() - 0.1125).abs() < 1e-6);
    }

    #[test]
    fn the_background_and_darkness_do_not_count() {
        let mut image = grey([2.0; 100]);
        let mut mask = [true; 100];
        for k in 50..100 {
            (image[k], mask[k]) = ([1e6; 3], false);
        }
        assert!((Exposure::of(&image, &mask).factor() - 0.175).abs() < 1e-6);
        assert_eq!(Exposure::of(&image, &[false; 100]), Exposure::ONE);
        assert_eq!(Exposure::of(&grey([0.0; 4]), &[true; 4]), Exposure::ONE);
        let lamp = grey((0..100).map(|k| if k == 0 { 70.0 } else { 0.0 }));
        assert!((Exposure::of(&lamp, &[true; 100]).factor() - 0.5).abs() < 1e-6);
        assert_eq!([0.0, -1.0, f32::NAN, f32::INFINITY].map(Exposure::new), [None; 4]);
    }

    proptest! {
        #[test]
        fn the_exposed_image_does_not_depend_on_the_unit(
            values in proptest::collection::vec([0.0_f32..9.0, 0.0_f32..9.0, 0.0_f32..9.0], 1..60), exponent in -20..20,
        ) {
            let unit = libm::exp2f(exponent as f32);
            let scaled: Vec<_> = values.iter().map(|colour| colour.map(|value| unit * value)).collect();
            let mask = vec![true; values.len()];
            let (one, other) = (Exposure::of(&values, &mask), Exposure::of(&scaled, &mask));
            for (&a, &b) in values.iter().zip(&scaled) {
                prop_assert_eq!(one.bytes(a), other.bytes(b));
            }
        }
    }
}
