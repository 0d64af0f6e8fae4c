//! Logarithm and exponential to base two of eight numbers in single precision.
//!
//! Additions, multiplications, divisions and shifts of the bits, each rounded by itself: the same bits on every machine.
//! (`exp` and `ln` of `wide` call no C library either, but fuse multiplication and addition where the program is compiled for a
//! processor that can, and then differ in the last bit; half of their time goes into special cases that do not occur here.)

use wide::{bytemuck::cast, f32x8, i32x8};

/// Coefficients of `2^t = 1 + t (c0 + c1 t + ..)` on [-1/2, 1/2], last first: with c0 = ln 2 the least maximum of the relative
/// error, 1.1e-7.
const POWER: [f32; 5] = [0.001_330_060_7, 0.009_669_691, 0.055_505_585, 0.240_222_83, std::f32::consts::LN_2];
/// Coefficients of `log2((1 + s) / (1 - s)) = s (c0 + c1 s^2 + c2 s^4)` for |s| < 0.172, last first: the least maximum of the
/// error, 4e-8.
const LOGARITHM: [f32; 3] = [0.598_973_9, 0.961_470_8, 2.885_391_2];

/// `2^x` for x in [-127, 127], within 2e-7 relative, exact where x is an integer; zero below -126.5.
#[inline]
pub(crate) fn exp2(x: f32x8) -> f32x8 {
    // adding 1.5 2^23 rounds to an integer and leaves it in the lowest bits
    const ROUND: f32 = 12_582_912.0;
    let shifted = x + ROUND;
    let t = x - (shifted - ROUND);
    let exponent: i32x8 = cast(shifted);
    let power: f32x8 = cast((exponent + i32x8::splat(127)) << 23);
    (polynomial(&POWER, t) * t + 1.0) * power
}

/// `log2 x` for normal x above zero, within 1.5e-7 of the larger of 1 and its magnitude, exact at powers of two.
#[inline]
pub(crate) fn log2(x: f32x8) -> f32x8 {
    // x = 2^e m with m in [sqrt(1/2), sqrt 2)
    const ROOT_HALF: i32 = std::f32::consts::FRAC_1_SQRT_2.to_bits() as i32;
    let bits: i32x8 = cast(x);
    let exponent: i32x8 = (bits - i32x8::splat(ROOT_HALF)) >> 23;
    let m: f32x8 = cast(bits - (exponent << 23));
    let s = (m - 1.0) / (m + 1.0);
    f32x8::from_i32x8(exponent) + polynomial(&LOGARITHM, s * s) * s
}

/// The polynomial with these coefficients, last first.
#[inline]
fn polynomial<const N: usize>(coefficients: &[f32; N], x: f32x8) -> f32x8 {
    coefficients[1..].iter().fold(f32x8::splat(coefficients[0]), |sum, &coefficient| sum * x + coefficient)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn powers_agree_with_double_precision() {
        let mut worst: f64 = 0.0;
        for n in 0..253_000 / 8 {
            let x: [f32; 8] = std::array::from_fn(|lane| -126.0 + 0.001 * (8 * n + lane) as f32);
            for (x, ours) in x.into_iter().zip(exp2(x.into()).to_array()) {
                worst = worst.max((f64::from(ours) / libm::exp2(f64::from(x)) - 1.0).abs());
            }
        }
        println!("largest relative error of 2^x: {worst:.2e}");
        assert!(worst < 2e-7, "{worst}");
        let exact = [-126.0, -3.0, -1.0, 0.0, 1.0, 10.0, 126.0, 127.0];
        assert_eq!(exp2(exact.into()).to_array(), exact.map(|x: f32| x.exp2()));
        assert_eq!(exp2(f32x8::splat(-127.0)), f32x8::ZERO);
    }

    #[test]
    fn logarithms_agree_with_double_precision() {
        let mut worst: f64 = 0.0;
        for n in 0..30_000 {
            // both sides of one densely, then all normal numbers
            let x: [f32; 8] = std::array::from_fn(|lane| {
                let place = (8 * n + lane) as f32 / 240_000.0;
                if n % 2 == 0 { 0.5 + 1.5 * place } else { libm::exp2f(-126.0 + 253.0 * place) }
            });
            for (x, ours) in x.into_iter().zip(log2(x.into()).to_array()) {
                let exact = libm::log2(f64::from(x));
                worst = worst.max((f64::from(ours) - exact).abs() / exact.abs().max(1.0));
            }
        }
        println!("largest error of log2 x: {worst:.2e}");
        assert!(worst < 1.5e-7, "{worst}");
        let exact = [1.0, 2.0, 0.5, 1024.0, 0.125, 4.0, 0.25, f32::MIN_POSITIVE];
        assert_eq!(log2(exact.into()).to_array(), exact.map(|x: f32| x.log2()));
    }
}
