//! Angles from their tangents, eight at a time.

use std::f32::consts::FRAC_PI_2;

use wide::f32x8;

/// The angle in radians, 0 to a right angle, whose tangent is `y / x`, for y, x >= 0; 0 where both are. Relative error
/// below 3e-7.
#[inline]
pub(crate) fn angle(y: f32x8, x: f32x8) -> f32x8 {
    /// `atan(t) / t` in powers of t^2 on [0, 1]: least relative error for eight coefficients, 9.9e-8.
    const SERIES: [f32; 8] = [
        0.999_999_9,
        -0.333_319_9,
        0.199_697_24,
        -0.140_194_8,
        0.099_142_94,
        -0.059_486_403,
        0.024_252_407,
        -0.004_693_276_4,
    ];
    let tangent = x.fast_min(y) / x.fast_max(y).fast_max(f32x8::splat(f32::MIN_POSITIVE));
    let square = tangent * tangent;
    let [first @ .., last] = SERIES;
    let sum = first.iter().rev().fold(f32x8::splat(last), |sum, &c| sum * square + f32x8::splat(c));
    let small = tangent * sum;
    y.simd_gt(x).select(f32x8::splat(FRAC_PI_2) - small, small)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn angles_are_those_of_the_quotient() {
        let mut worst: f64 = 0.0;
        for n in 0..2000 {
            let exact = f64::from(n) / 2000.0 * std::f64::consts::FRAC_PI_2;
            let (y, x) = (libm::sin(exact) as f32, libm::cos(exact) as f32);
            let found = f64::from(angle(f32x8::splat(y), f32x8::splat(x)).to_array()[0]);
            let exact = libm::atan2(f64::from(y), f64::from(x));
            worst = worst.max((found - exact).abs() / exact.max(1e-30));
        }
        println!("largest relative error of an angle: {worst:.2e}");
        assert!(worst < 3e-7);
        assert_eq!(angle(f32x8::ZERO, f32x8::ZERO).to_array(), [0.0; 8]);
    }
}
