//! Pearson's chi-square test, for the tests of this crate and those beside it.

use super::sobol;

/// A correct sampler fails with this probability per case; the points are fixed, so it passes always or never.
pub(crate) const SIGNIFICANCE: f64 = 1e-3;

/// Independent numbers: the first point of as many sequences.
pub(crate) fn independent(seed: u32) -> [f32; 2] {
    let mut u = [[0.0], [0.0]];
    let [a, b] = &mut u;
    sobol::fill(sobol::mix(seed), 0, [a, b]);
    [u[0][0], u[1][0]]
}

/// The probability of a chi-square value this large or larger: Wilson and Hilferty's normal approximation, 1931, better than 1e-3 from
/// 30 degrees of freedom on.
fn tail(chi_square: f64, degrees: f64) -> f64 {
    let variance = 2.0 / (9.0 * degrees);
    let z = ((chi_square / degrees).cbrt() - (1.0 - variance)) / variance.sqrt();
    0.5 * libm::erfc(z / std::f64::consts::SQRT_2)
}

/// The probability that counts differ from what is expected as much as these or more: Pearson's statistic; bins in which fewer
/// than five draws are expected are joined.
pub(crate) fn p_value(counts: &[u32], expected: &[f64], draws: f64) -> f64 {
    let (mut sum, mut bins, mut rest) = (0.0, 0.0, (0.0, 0.0));
    let mut add = |count: f64, mean: f64| {
        sum += (count - mean) * (count - mean) / mean;
        bins += 1.0;
    };
    for (&count, &probability) in counts.iter().zip(expected) {
        let mean = probability * draws;
        if mean >= 5.0 {
            add(count.into(), mean);
        } else {
            rest = (rest.0 + f64::from(count), rest.1 + mean);
        }
    }
    if rest.1 >= 5.0 {
        add(rest.0, rest.1);
    } else {
        assert!(rest.0 < 25.0, "{} draws where {} are expected", rest.0, rest.1);
    }
    tail(sum, bins - 1.0)
}
