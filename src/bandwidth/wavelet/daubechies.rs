//! One step of the Daubechies wavelet transform with four taps, in one dimension.

use std::ops::{Add, Mul, Sub};

/// Numbers that the transform works on: `f32` and `f64`.
pub trait Real:
    Copy + Default + PartialEq + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> + Send + Sync + 'static
{
    /// The nearest number of this type.
    fn from_f64(value: f64) -> Self;
}

impl Real for f32 {
    fn from_f64(value: f64) -> Self {
        value as f32
    }
}

impl Real for f64 {
    fn from_f64(value: f64) -> Self {
        value
    }
}

/// Border extension of a signal.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Border {
    /// Reflected by half a sample: `x[-1] = x[0]`, `x[n] = x[n-1]`. The transform stays invertible, but is not orthonormal in the
    /// first and the last coefficient.
    #[default]
    Reflect,
    /// Periodic: `x[-1] = x[n-1]`. The transform is orthonormal.
    Periodic,
}

const SQRT_3: f64 = 1.732_050_807_568_877_2;
const NORM: f64 = 4.0 * std::f64::consts::SQRT_2;

/// Low-pass taps of the orthonormal Daubechies wavelet with two vanishing moments (Daubechies 1988; PyWavelets' `db2`
/// reversed): `low[k] = sum_t LOW[t] x[2k - 1 + t]`.
pub const LOW: [f64; 4] = [(1.0 + SQRT_3) / NORM, (3.0 + SQRT_3) / NORM, (3.0 - SQRT_3) / NORM, (1.0 - SQRT_3) / NORM];

/// High-pass taps: `HIGH[t] = (-1)^t LOW[3 - t]`.
pub const HIGH: [f64; 4] = [LOW[3], -LOW[2], LOW[1], -LOW[0]];

/// The samples before the first and after the last one.
#[inline(always)]
fn beyond<T: Copy>(x: &[T], border: Border) -> (T, T) {
    let (first, last) = (x[0], x[x.len() - 1]);
    match border {
        Border::Reflect => (first, last),
        Border::Periodic => (last, first),
    }
}

/// Sums of the four taps over shifted rows: `out[k] = t0 a[k] + t1 b[k] + t2 c[k] + t3 d[k]`.
#[inline(always)]
pub(crate) fn four_taps<T: Real>(taps: [T; 4], rows: [&[T]; 4], out: &mut [T]) {
    let [a, b, c, d] = rows;
    let n = out.len();
    let (a, b, c, d) = (&a[..n], &b[..n], &c[..n], &d[..n]);
    for k in 0..n {
        out[k] = (taps[0] * a[k] + taps[1] * b[k]) + (taps[2] * c[k] + taps[3] * d[k]);
    }
}

/// The taps in the precision of the signal.
#[inline(always)]
pub(crate) fn taps<T: Real>(taps: [f64; 4]) -> [T; 4] {
    taps.map(T::from_f64)
}

/// Analyses `x` (even length n): `low[k] = sum_t LOW[t] x[2k - 1 + t]`, `high[k]` alike, k in 0 .. n/2; this is the phase of
/// PyWavelets' mode `periodization`. `scratch` holds n + 2 values.
///
/// # Panics
/// If the length is odd or zero, or another slice has the wrong length.
#[inline(always)]
pub fn analyse<T: Real>(x: &[T], border: Border, low: &mut [T], high: &mut [T], scratch: &mut [T]) {
    let half = x.len() / 2;
    assert!(half > 0 && x.len() == 2 * half, "the length {} is not even", x.len());
    assert!(low.len() == half && high.len() == half && scratch.len() == x.len() + 2, "wrong lengths");
    // odd[k] = x[2k - 1], even[k] = x[2k]
    let (odd, even) = scratch.split_at_mut(half + 1);
    let (before, after) = beyond(x, border);
    for (k, pair) in x.chunks_exact(2).enumerate() {
        even[k] = pair[0];
        odd[k + 1] = pair[1];
    }
    odd[0] = before;
    even[half] = after;
    let rows = [&odd[..half], &even[..half], &odd[1..], &even[1..]];
    four_taps(taps(LOW), rows, low);
    four_taps(taps(HIGH), rows, high);
}

/// Rebuilds `x` from what [`analyse`] made of it with the same border.
///
/// # Panics
/// If `x` has not twice as many samples as `low` and `high`, or none.
pub fn synthesise<T: Real>(low: &[T], high: &[T], border: Border, x: &mut [T]) {
    let half = low.len();
    assert!(half > 0 && high.len() == half && x.len() == 2 * half, "wrong lengths");
    for (n, x) in x.iter_mut().enumerate() {
        let ([k, next], taps) = rebuilding(n, half, border);
        let [a, b, c, d] = taps.map(T::from_f64);
        *x = (a * low[k] + b * high[k]) + (c * low[next] + d * high[next]);
    }
}

/// How sample n follows from `half` pairs of coefficients: indices k, l and the factors of `low[k], high[k], low[l], high[l]`.
///
/// With a reflected border the first and the last sample follow from one pair alone: the taps 0 and 1 of both filters are
/// proportional to one unit vector v, so from `x[-1] = x[0]` the pair keeps `x[0] (v0 + v1)`; so it is with the taps 3 and 2.
pub(crate) fn rebuilding(n: usize, half: usize, border: Border) -> ([usize; 2], [f64; 4]) {
    let odd = n % 2;
    let taps = if odd == 1 { [LOW[2], HIGH[2], LOW[0], HIGH[0]] } else { [LOW[3], HIGH[3], LOW[1], HIGH[1]] };
    let (k, next) = ((n + half * 2 - 1) / 2 % half, n.div_ceil(2) % half);
    let alone = |outer: f64, inner: f64| (outer * outer + inner * inner) / (inner * (outer + inner));
    match border {
        Border::Reflect if n == 0 => ([0, 0], [0.0, 0.0, LOW[1], HIGH[1]].map(|tap| tap * alone(LOW[0], LOW[1]))),
        Border::Reflect if n == 2 * half - 1 => {
            ([half - 1; 2], [LOW[2], HIGH[2], 0.0, 0.0].map(|tap| tap * alone(LOW[3], LOW[2])))
        }
        _ => ([k, next], taps),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn round_trip<T: Real>(x: &[T], border: Border) -> Vec<T> {
        let half = x.len() / 2;
        let (mut low, mut high) = (vec![T::default(); half], vec![T::default(); half]);
        analyse(x, border, &mut low, &mut high, &mut vec![T::default(); x.len() + 2]);
        let mut back = vec![T::default(); x.len()];
        synthesise(&low, &high, border, &mut back);
        back
    }

    #[test]
    fn the_filters_are_orthonormal_with_two_vanishing_moments() {
        let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        assert!((dot(&LOW, &LOW) - 1.0).abs() < 1e-15 && dot(&LOW, &HIGH).abs() < 1e-15);
        assert!(dot(&LOW[2..], &LOW[..2]).abs() < 1e-15);
        assert!(dot(&HIGH, &[1.0; 4]).abs() < 1e-15 && dot(&HIGH, &[0.0, 1.0, 2.0, 3.0]).abs() < 1e-15);
    }

    proptest! {
        #[test]
        fn reconstruction_is_perfect(mut x in prop::collection::vec(-1.0..1.0_f64, 2..70), periodic: bool) {
            x.truncate(x.len() & !1);
            let border = if periodic { Border::Periodic } else { Border::Reflect };
            for (ours, x) in round_trip(&x, border).iter().zip(&x) {
                prop_assert!((ours - x).abs() < 1e-14);
            }
            let single: Vec<f32> = x.iter().map(|&x| x as f32).collect();
            for (ours, x) in round_trip(&single, border).iter().zip(&single) {
                prop_assert!((ours - x).abs() < 2e-6);
            }
        }
    }
}
