//! Loops over arrays of numbers, eight at a time.

use wide::f32x8;

/// Hands eight entries after the other of the arrays `inputs` to `work` and stores what it returns in `outputs`. The last
/// block is filled up with zeros.
///
/// # Panics
/// If the arrays differ in length.
#[inline]
pub fn by_eights<const IN: usize, const OUT: usize>(
    inputs: [&[f32]; IN],
    mut outputs: [&mut [f32]; OUT],
    mut work: impl FnMut([f32x8; IN]) -> [f32x8; OUT],
) {
    let count = inputs[0].len();
    assert!(inputs.iter().all(|numbers| numbers.len() == count), "the inputs differ in length");
    assert!(outputs.iter().all(|numbers| numbers.len() == count), "the outputs differ in length from the inputs");
    let (blocks, rest) = (inputs.map(|numbers| numbers.as_chunks::<8>().0), count / 8 * 8);
    for n in 0..count / 8 {
        let found = work(blocks.map(|blocks| f32x8::new(blocks[n])));
        for (output, found) in outputs.iter_mut().zip(found) {
            output.as_chunks_mut::<8>().0[n] = found.to_array();
        }
    }
    if rest < count {
        let found = work(inputs.map(|numbers| {
            let mut eight = [0.0; 8];
            eight[..count - rest].copy_from_slice(&numbers[rest..]);
            f32x8::new(eight)
        }));
        for (output, found) in outputs.iter_mut().zip(found) {
            output[rest..].copy_from_slice(&found.to_array()[..count - rest]);
        }
    }
}

/// `(cos 2 pi u, sin 2 pi u)` for u in [0, 1], within 1.2e-7. Operations without contraction, the same on every machine.
#[inline]
pub(crate) fn cos_sin_of_turns(u: f32x8) -> [f32x8; 2] {
    // adding 1.5 2^23 rounds to an integer
    const ROUND: f32 = 12_582_912.0;
    let quarters = u * 4.0;
    let nearest = (quarters + ROUND) - ROUND;
    let angle = (quarters - nearest) * std::f32::consts::FRAC_PI_2;
    let square = angle * angle;
    // Taylor's, on [-pi/4, pi/4]
    let sin = angle
        + angle * square * (((square * (1.0 / 362_880.0) - 1.0 / 5040.0) * square + 1.0 / 120.0) * square - 1.0 / 6.0);
    let cos = 1.0
        + square
            * ((((square * (-1.0 / 3_628_800.0) + 1.0 / 40_320.0) * square - 1.0 / 720.0) * square + 1.0 / 24.0)
                * square
                - 0.5);
    let odd = nearest.simd_eq(f32x8::ONE) | nearest.simd_eq(f32x8::splat(3.0));
    let (c, s) = (odd.select(sin, cos), odd.select(cos, sin));
    let left = nearest.simd_eq(f32x8::ONE) | nearest.simd_eq(f32x8::splat(2.0));
    let low = nearest.simd_eq(f32x8::splat(2.0)) | nearest.simd_eq(f32x8::splat(3.0));
    [left.select(-c, c), low.select(-s, s)]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_entry_is_visited_once() {
        for count in [0_usize, 1, 7, 8, 9, 24, 30] {
            let a: Vec<f32> = (0..count).map(|n| n as f32).collect();
            let mut b = vec![-1.0; count];
            by_eights([&a], [&mut b], |[a]| [a * 2.0 + 1.0]);
            assert!(b.iter().enumerate().all(|(n, &b)| b == 2.0 * n as f32 + 1.0));
        }
    }

    #[test]
    fn turns_agree_with_double_precision() {
        let mut worst: f64 = 0.0;
        for n in 0..=40_000 {
            let u = n as f32 / 40_000.0;
            let (sin, cos) = libm::sincos(f64::from(u) * std::f64::consts::TAU);
            let [c, s] = cos_sin_of_turns(f32x8::splat(u)).map(|v| f64::from(v.to_array()[3]));
            worst = worst.max((c - cos).abs()).max((s - sin).abs());
        }
        println!("largest error of a cosine or sine: {worst:.1e}");
        assert!(worst < 1.2e-7, "{worst}");
        assert_eq!(cos_sin_of_turns(f32x8::ZERO).map(|v| v.to_array()[0]), [1.0, 0.0]);
    }
}
