//! The upper incomplete gamma function `Gamma(s, x) = int_x^inf t^(s-1) e^(-t) dt` for real `s` of either sign.
//!
//! The normalisation of the shifted gamma distribution needs `s = 1 - p`, which may be zero or negative; the usual
//! libraries stop at `s > 0`. Three regions cover what is needed:
//!
//! - `x >= 1`: Legendre's continued fraction in its even form (DLMF 8.9.2), evaluated by the modified Lentz method;
//! - `x < 1`, `s > 1/2`: `Gamma(s)` minus the power series of the lower function;
//! - `x < 1`, `s <= 1/2`: Gautschi's form (ACM TOMS 5, 466, 1979) around `s0` in [-1/2, 1/2], then recurrence downwards.
//!
//! Everything runs on dual numbers, so the derivative with respect to `s` comes with the value.

use crate::math::dual::Dual;

/// Taylor coefficients of `1 / Gamma(1 + s)` around `s = 0` (DLMF 5.7.1 shifted by one); on |s| <= 1/2 the first term left
/// out is below 1e-26.
const RECIPROCAL_GAMMA: [f64; 27] = [
    1.0,
    0.577_215_664_901_532_9,
    -0.655_878_071_520_253_9,
    -0.042_002_635_034_095_24,
    0.166_538_611_382_291_5,
    -0.042_197_734_555_544_34,
    -0.009_621_971_527_876_974,
    0.007_218_943_246_663_1,
    -0.001_165_167_591_859_065_1,
    -0.000_215_241_674_114_950_98,
    0.000_128_050_282_388_116_2,
    -0.000_020_134_854_780_788_24,
    -1.250_493_482_142_670_7e-6,
    1.133_027_231_981_696e-6,
    -2.056_338_416_977_607e-7,
    6.116_095_104_481_416e-9,
    5.002_007_644_469_223e-9,
    -1.181_274_570_487_02e-9,
    1.043_426_711_691_100_5e-10,
    7.782_263_439_905_071e-12,
    -3.696_805_618_642_206e-12,
    5.100_370_287_454_476e-13,
    -2.058_326_053_566_507e-14,
    -5.348_122_539_423_018e-15,
    1.226_778_628_238_260_8e-15,
    -1.181_259_301_697_458_8e-16,
    1.186_692_254_751_600_3e-18,
];

/// `Gamma(s, x)` for `s` in (-25, 100) and `x >= 1e-12`.
///
/// Relative error at most 1e-13 on the stored mpmath vectors (`data-fixtures/gamma.json`; `docs/accuracy.md` has the
/// measured figures). Returns NaN outside of the domain.
pub fn upper_gamma(s: f64, x: f64) -> f64 {
    let s = Dual::constant(s);
    match region(s.value, x) {
        Region::Outside => f64::NAN,
        Region::Fraction => scaled_beyond_one(s, x).value * libm::exp(s.value * libm::log(x) - x),
        Region::Series => gamma_minus_lower_series(s, x).value,
        Region::Gautschi => gautschi(s, x).value,
    }
}

/// `(ln Gamma(s, x), d/ds ln Gamma(s, x))`, both dimensionless; the same domain as [`upper_gamma`].
///
/// The logarithm neither overflows nor underflows for large `x`. Relative error of `Gamma` at most 1e-13, error of the
/// derivative at most 1e-12 relative to `max(1, |value|)`, on the stored mpmath vectors. NaN outside of the domain.
pub fn ln_upper_gamma(s: f64, x: f64) -> (f64, f64) {
    let s_dual = Dual::variable(s);
    let result = match region(s, x) {
        Region::Outside => return (f64::NAN, f64::NAN),
        Region::Fraction => {
            let ln_x = libm::log(x);
            scaled_beyond_one(s_dual, x).ln() + s_dual * ln_x + (-x)
        }
        Region::Series => gamma_minus_lower_series(s_dual, x).ln(),
        Region::Gautschi => gautschi(s_dual, x).ln(),
    };
    (result.value, result.slope)
}

enum Region {
    Outside,
    Fraction,
    Series,
    Gautschi,
}

fn region(s: f64, x: f64) -> Region {
    let inside = s > -25.0 && s < 100.0 && (1e-12..f64::INFINITY).contains(&x);
    if !inside {
        Region::Outside
    } else if x >= 1.0 {
        Region::Fraction
    } else if s > 0.5 {
        Region::Series
    } else {
        Region::Gautschi
    }
}

/// `Gamma(s, x) e^x x^(-s)` for `x >= 1`: the continued fraction for `s <= 3/2`, from there by the recurrence upwards, whose
/// terms are all positive.
fn scaled_beyond_one(s: Dual, x: f64) -> Dual {
    let steps = (s.value - 1.5).ceil().max(0.0);
    let mut t = s + (-steps);
    let mut h = continued_fraction(t, x);
    for _ in 0..steps as u32 {
        h = (t * h + 1.0) * (1.0 / x);
        t = t + 1.0;
    }
    h
}

/// `Gamma(s, x) e^x x^(-s)` for `x >= 1`, `s <= 3/2` by the even part of Legendre's continued fraction.
fn continued_fraction(s: Dual, x: f64) -> Dual {
    const TINY: f64 = 1e-290;
    let mut b = -s + (x + 1.0);
    let mut c = Dual::constant(1.0 / TINY);
    let mut d = Dual::constant(1.0) / nonzero(b, TINY);
    let mut h = d;
    for n in 1..=400 {
        let n = f64::from(n);
        let a = (s + (-n)) * n;
        b = b + 2.0;
        d = Dual::constant(1.0) / nonzero(a * d + b, TINY);
        c = nonzero(b + a / c, TINY);
        let step = c * d;
        h = h * step;
        if (step.value - 1.0).abs() < 1e-16 && step.slope.abs() < 1e-15 {
            break;
        }
    }
    h
}

fn nonzero(v: Dual, tiny: f64) -> Dual {
    if v.value.abs() < tiny { Dual { value: tiny, slope: v.slope } } else { v }
}

/// `1 / Gamma(1 + s)` and `(1 / Gamma(1 + s) - 1) / s` for |s| <= 1/2.
fn reciprocal_gamma(s: Dual) -> (Dual, Dual) {
    let mut q = Dual::constant(0.0);
    for &coefficient in RECIPROCAL_GAMMA[1..].iter().rev() {
        q = q * s + coefficient;
    }
    (q * s + 1.0, q)
}

/// `sum_{n >= first} (-x)^n / (n! (s + n))`.
fn lower_series(s: Dual, x: f64, first: u32) -> Dual {
    let mut sum = Dual::constant(0.0);
    let mut power = 1.0;
    for n in 0..60_u32 {
        if n > 0 {
            power *= -x / f64::from(n);
        }
        if n < first {
            continue;
        }
        let term = Dual::constant(power) / (s + f64::from(n));
        sum = sum + term;
        if n > 1 && power.abs() < 1e-18 * sum.value.abs() {
            break;
        }
    }
    sum
}

/// `Gamma(s)` for `s > 1/2`, reduced to [1/2, 3/2] by its recurrence.
fn gamma(s: Dual) -> Dual {
    let mut factor = Dual::constant(1.0);
    let mut t = s;
    while t.value > 1.5 {
        t = t + (-1.0);
        factor = factor * t;
    }
    factor / reciprocal_gamma(t + (-1.0)).0
}

/// `x < 1`, `s > 1/2`.
fn gamma_minus_lower_series(s: Dual, x: f64) -> Dual {
    let power = (s * libm::log(x)).exp();
    gamma(s) - power * lower_series(s, x, 0)
}

/// `expm1(y) / y`.
fn expm1_over(y: Dual) -> Dual {
    let v = y.value;
    if v.abs() < 1.0 {
        let mut value = 0.0;
        let mut slope = 0.0;
        // sum y^k / (k+1)!, by Horner from k = 18, with its derivative
        let mut k = 18;
        while k >= 0 {
            let inverse_factorial = INVERSE_FACTORIAL[k as usize + 1];
            slope = slope * v + value;
            value = value * v + inverse_factorial;
            k -= 1;
        }
        Dual { value, slope: slope * y.slope }
    } else {
        let value = libm::expm1(v) / v;
        let slope = (libm::exp(v) - value) / v;
        Dual { value, slope: slope * y.slope }
    }
}

const INVERSE_FACTORIAL: [f64; 20] = {
    let mut table = [1.0; 20];
    let mut n = 1;
    while n < 20 {
        table[n] = table[n - 1] / n as f64;
        n += 1;
    }
    table
};

/// `x < 1`, `s <= 1/2`.
fn gautschi(s: Dual, x: f64) -> Dual {
    let shift = if s.value < -0.5 { (-0.5 - s.value).ceil() } else { 0.0 };
    let ln_x = libm::log(x);
    let s0 = s + shift;
    let (reciprocal, quotient) = reciprocal_gamma(s0);
    let y = s0 * ln_x;
    let power = y.exp();
    let mut value = -quotient / reciprocal - expm1_over(y) * ln_x - power * lower_series(s0, x, 1);
    // Gamma(t - 1, x) = (Gamma(t, x) - x^(t-1) e^(-x)) / (t - 1)
    let e = libm::exp(-x);
    let mut t = s0;
    let mut term = power * e;
    for _ in 0..shift as u32 {
        t = t + (-1.0);
        term = term * (1.0 / x);
        value = (value - term) / t;
    }
    value
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn closed_forms() {
        for x in [1e-8_f64, 0.01, 0.3, 0.999, 1.0, 2.5, 30.0] {
            // Gamma(1, x) = e^-x, Gamma(2, x) = (x + 1) e^-x, Gamma(1/2, x) = sqrt(pi) erfc(sqrt x)
            assert!((upper_gamma(1.0, x) / (-x).exp() - 1.0).abs() < 1e-14, "{x}");
            assert!((upper_gamma(2.0, x) / ((x + 1.0) * (-x).exp()) - 1.0).abs() < 1e-14, "{x}");
            let erfc = std::f64::consts::PI.sqrt() * libm::erfc(x.sqrt());
            assert!((upper_gamma(0.5, x) / erfc - 1.0).abs() < 1e-13, "{x}");
        }
    }

    #[test]
    fn the_recurrence_holds_across_the_regions() {
        // Gamma(s + 1, x) = s Gamma(s, x) + x^s e^-x
        for s in [-2.3, -1.0, -0.5, -0.2, 0.0, 0.3, 0.5, 0.7, 1.4] {
            for x in [1e-4_f64, 0.2, 0.9, 1.0, 1.1, 7.0] {
                let left = upper_gamma(s + 1.0, x);
                let (a, b) = (s * upper_gamma(s, x), x.powf(s) * (-x).exp());
                let scale = a.abs().max(b.abs()).max(left);
                assert!((left - a - b).abs() < 1e-13 * scale, "s {s} x {x}");
            }
        }
    }

    #[test]
    fn outside_of_the_domain_is_nan() {
        for (s, x) in [(0.5, 0.0), (0.5, -1.0), (f64::NAN, 1.0), (0.5, f64::NAN), (200.0, 1.0)] {
            assert!(ln_upper_gamma(s, x).0.is_nan(), "s {s} x {x}");
            assert!(upper_gamma(s, x).is_nan(), "s {s} x {x}");
        }
    }
}
