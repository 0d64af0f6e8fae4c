//! Differences between an image and its reference, over the foreground.

use crate::images::exposure::Exposure;

/// Peak signal-to-noise ratio in decibels of what a display shows: exposed, limited to [0, 1], on the curve of sRGB,
/// mean square over the foreground and the channels. Infinite if there is no difference.
///
/// # Panics
/// If the images and the mask differ in length.
#[must_use]
pub fn psnr(image: &[[f32; 3]], reference: &[[f32; 3]], foreground: &[bool], exposure: Exposure) -> f64 {
    let mean = mean_over(image, reference, foreground, |x, y| {
        let (x, y) = (exposure.encode(x), exposure.encode(y));
        std::array::from_fn(|c| {
            let difference = f64::from(x[c]) - f64::from(y[c]);
            difference * difference
        })
    });
    -10.0 * libm::log10(mean)
}

/// Relative mean square error, the mean of (x - y)^2 / (y^2 + 0.01) over the foreground and the channels, x and y the
/// exposed radiance of image and reference, not limited.
///
/// # Panics
/// If the images and the mask differ in length.
#[must_use]
pub fn relmse(image: &[[f32; 3]], reference: &[[f32; 3]], foreground: &[bool], exposure: Exposure) -> f64 {
    mean_over(image, reference, foreground, |x, y| {
        let (x, y) = (exposure.expose(x), exposure.expose(y));
        std::array::from_fn(|c| {
            let (x, y) = (f64::from(x[c]), f64::from(y[c]));
            (x - y) * (x - y) / (y * y + 0.01)
        })
    })
}

/// Mean of a measure over the channels of the foreground, summed in the order of the pixels; 0 without foreground.
fn mean_over(
    image: &[[f32; 3]],
    reference: &[[f32; 3]],
    foreground: &[bool],
    measure: impl Fn([f32; 3], [f32; 3]) -> [f64; 3],
) -> f64 {
    assert!(image.len() == reference.len() && image.len() == foreground.len(), "images of the same size");
    let (mut sum, mut count) = (0.0, 0_usize);
    for ((&x, &y), _) in image.iter().zip(reference).zip(foreground).filter(|&(_, &shown)| shown) {
        let [r, g, b] = measure(x, y);
        sum += r + g + b;
        count += 3;
    }
    sum / count.max(1) as f64
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// An image without structure that spans four decades.
    fn image(seed: u32) -> Vec<[f32; 3]> {
        let value = |k: u32| {
            let bits = (k ^ seed).wrapping_mul(2_654_435_761) >> 8;
            libm::powf(10.0, bits as f32 / 16_777_216.0 * 4.0 - 3.0)
        };
        (0..500).map(|k| [value(3 * k), value(3 * k + 1), value(3 * k + 2)]).collect()
    }

    #[test]
    fn known_differences_give_known_numbers() {
        // 8 of 255 steps of sRGB everywhere: 20 log10(255/8) = 30.069 dB
        let shown = |byte: u8| [brdfit_figures::srgb::decode(f32::from(byte) / 255.0) / 3.0; 3];
        let (x, y): (Vec<_>, Vec<_>) = (0..240).map(|byte| (shown(byte + 8), shown(byte))).unzip();
        let exposure = Exposure::new(3.0).unwrap();
        assert!((psnr(&x, &y, &[true; 240], exposure) - 30.069_3).abs() < 1e-3);

        // 10 % of exposed radiance 0.5: 0.0025/0.26
        let (x, y) = (vec![[0.275; 3]; 7], vec![[0.25; 3]; 7]);
        let exposure = Exposure::new(2.0).unwrap();
        assert!((relmse(&x, &y, &[true; 7], exposure) - 0.009_615_385).abs() < 1e-8);
    }

    #[test]
    fn nothing_is_no_difference() {
        let x = image(1);
        assert_eq!(psnr(&x, &x, &[true; 500], Exposure::ONE), f64::INFINITY);
        assert_eq!(relmse(&x, &x, &[true; 500], Exposure::ONE), 0.0);
        assert_eq!(relmse(&x, &image(2), &[false; 500], Exposure::ONE), 0.0);
    }

    #[test]
    fn psnr_sees_nothing_beyond_white_and_relmse_does() {
        let (x, y) = (vec![[9.0; 3]; 4], vec![[3.0; 3]; 4]);
        assert_eq!(psnr(&x, &y, &[true; 4], Exposure::ONE), f64::INFINITY);
        assert!((relmse(&x, &y, &[true; 4], Exposure::ONE) - 36.0 / 9.01).abs() < 1e-12);
    }

    proptest! {
        #[test]
        fn only_the_foreground_and_the_exposed_values_count(seed in 1_u32..1000, exponent in -8..8, modulus in 2_usize..9) {
            let (x, y) = (image(0), image(seed));
            let mask: Vec<bool> = (0..x.len()).map(|k| k % modulus != 0).collect();
            let kept = |image: &[[f32; 3]]| {
                let shown = image.iter().zip(&mask).filter(|&(_, &shown)| shown);
                shown.map(|(&colour, _)| colour).collect::<Vec<_>>()
            };
            let (few_x, few_y) = (kept(&x), kept(&y));
            let all = vec![true; few_x.len()];
            let unit = libm::exp2f(exponent as f32);
            let scaled = |image: &[[f32; 3]]| image.iter().map(|c| c.map(|v| unit * v)).collect::<Vec<_>>();
            let exposure = Exposure::new(1.0 / unit).unwrap();
            for metric in [psnr, relmse] {
                let expected = metric(&x, &y, &mask, Exposure::ONE);
                prop_assert_eq!(metric(&few_x, &few_y, &all, Exposure::ONE), expected);
                prop_assert_eq!(metric(&scaled(&x), &scaled(&y), &mask, exposure), expected);
            }
        }
    }
}
