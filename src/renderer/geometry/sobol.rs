//! Low-discrepancy points of the unit square, one sequence per seed.
//!
//! The first two dimensions of Sobol's sequence with Owen's nested uniform scrambling of the coordinates and of the order of the
//! points, both by hashing. Sources: Owen, "Randomly permuted (t, m, s)-nets and (t, s)-sequences", 1995; Laine and Karras,
//! "Stratified sampling for stochastic transparency", 2011 (the hash); Burley, "Practical hash-based Owen scrambling", JCGT 9(4),
//! 2020 (coordinates and order); constants by Vegdahl, "Building a better LK hash", 2021.
//!
//! Guaranteed for every seed: any `2^m` points from a multiple of `2^m` on form a (0, m, 2)-net in base 2, `m <= 24`: each
//! elementary interval of area `2^-m` holds exactly one. Sequences with different seeds are uncorrelated in practice.

use wide::{f32x8, u32x8};

/// A well-mixed 32-bit number from another one, one-to-one: the output permutation of a PCG generator, as recommended by
/// Jarzynski and Olano, "Hash functions for GPU rendering", JCGT 9(3), 2020.
pub fn mix(x: u32) -> u32 {
    let state = x.wrapping_mul(747_796_405).wrapping_add(2_891_336_453);
    let word = ((state >> ((state >> 28) + 4)) ^ state).wrapping_mul(277_803_737);
    (word >> 22) ^ word
}

/// The seed of the points for one use (a technique, a pass) at one pixel under the seed that the user chose.
pub fn seed([x, y]: [u32; 2], technique: u32, user: u32) -> u32 {
    [x, y, technique].into_iter().fold(mix(user), |hash, word| mix(hash ^ word))
}

/// Points `first`, `first + 1`, ... of the sequence of a seed, as many as the slices hold; coordinates in [0, 1), multiples of `2^-24`.
///
/// # Panics
/// If the slices differ in length.
pub fn fill(seed: u32, first: u32, u: [&mut [f32]; 2]) {
    let [x, y] = u;
    assert_eq!(x.len(), y.len(), "as many of either coordinate");
    let seeds = Seeds::new(seed);
    let mut index = first;
    let (x_blocks, x_rest) = x.as_chunks_mut::<8>();
    let (y_blocks, y_rest) = y.as_chunks_mut::<8>();
    for (x, y) in x_blocks.iter_mut().zip(y_blocks) {
        [*x, *y] = eight(seeds, index);
        index = index.wrapping_add(8);
    }
    if !x_rest.is_empty() {
        let [a, b] = eight(seeds, index);
        x_rest.copy_from_slice(&a[..x_rest.len()]);
        y_rest.copy_from_slice(&b[..y_rest.len()]);
    }
}

/// One hash per scrambled quantity.
#[derive(Clone, Copy)]
struct Seeds {
    order: u32,
    x: u32,
    y: u32,
}

impl Seeds {
    fn new(seed: u32) -> Self {
        let order = mix(seed ^ 0x68bc_21eb);
        let x = mix(order ^ 0x02e5_be93);
        Self { order, x, y: mix(x ^ 0x967a_889b) }
    }
}

/// Eight points from `first` on.
#[inline(always)]
fn eight(seeds: Seeds, first: u32) -> [[f32; 8]; 2] {
    let index = u32x8::splat(first) + u32x8::from([0, 1, 2, 3, 4, 5, 6, 7]);
    let index = reverse(scramble(reverse(index), seeds.order));
    // the coordinates of Sobol's points, bits reversed, are the index itself and its polynomial at 1 + X; so no reversal before
    let [x, y] = [(index, seeds.x), (shift_by_one(index), seeds.y)];
    [x, y].map(|(bits, seed)| to_unit(reverse(scramble(bits, seed))).to_array())
}

/// A permutation in which each bit depends on the lower ones only; on reversed bits this is Owen's scrambling.
#[inline(always)]
fn scramble(bits: u32x8, seed: u32) -> u32x8 {
    let times = |bits: u32x8, factor: u32| bits * u32x8::splat(factor);
    let bits = bits ^ times(bits, 0x3d20_adea);
    let bits = times(bits + u32x8::splat(seed), (seed >> 16) | 1);
    let bits = bits ^ times(bits, 0x0552_6c56);
    bits ^ times(bits, 0x53a2_2864)
}

/// The polynomial over the field of two elements whose coefficients are the bits, at `1 + X` in place of `X`: Pascal's triangle
/// modulo 2, the generator matrix of the second dimension. With `f = low + X^h high`, h a power of two, `f(1 + X) = low(1 + X) +
/// (1 + X^h) high(1 + X)`.
#[inline(always)]
fn shift_by_one(bits: u32x8) -> u32x8 {
    let halves = [(16, 0x0000_ffff), (8, 0x00ff_00ff), (4, 0x0f0f_0f0f), (2, 0x3333_3333), (1, 0x5555_5555)];
    halves.into_iter().fold(bits, |bits, (half, low)| bits ^ ((bits >> half) & u32x8::splat(low)))
}

/// The bits in reverse order.
#[inline(always)]
fn reverse(bits: u32x8) -> u32x8 {
    let pairs = [(1, 0x5555_5555), (2, 0x3333_3333), (4, 0x0f0f_0f0f), (8, 0x00ff_00ff)];
    let exchange = |bits: u32x8, (by, low): (u32, u32)| {
        let low = u32x8::splat(low);
        ((bits >> by) & low) | ((bits & low) << by)
    };
    let bits = pairs.into_iter().fold(bits, exchange);
    (bits >> 16) | (bits << 16)
}

/// The upper 24 bits as a number in [0, 1).
#[inline(always)]
fn to_unit(bits: u32x8) -> f32x8 {
    let numbers: [u32; 8] = (bits >> 8_u32).to_array();
    f32x8::from(numbers.map(|number| number as i32 as f32)) * (1.0 / 16_777_216.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn points(seed: u32, first: u32, count: usize) -> Vec<[f32; 2]> {
        let (mut x, mut y) = (vec![0.0; count], vec![0.0; count]);
        fill(seed, first, [&mut x, &mut y]);
        x.into_iter().zip(y).map(|(x, y)| [x, y]).collect()
    }

    /// The definition of a (0, m, 2)-net.
    fn is_net(points: &[[f32; 2]]) -> bool {
        let m = points.len().ilog2();
        (0..=m).all(|a| {
            let mut hit = vec![false; points.len()];
            for [x, y] in points {
                let (wide, tall) = (1_usize << a, 1_usize << (m - a));
                hit[(x * wide as f32) as usize * tall + (y * tall as f32) as usize] = true;
            }
            hit.into_iter().all(|hit| hit)
        })
    }

    #[test]
    fn operations_on_bits() {
        let numbers = [0, 1, 2, 3, 0x8000_0000, 0x1234_5678, u32::MAX, 0xdead_beef];
        assert_eq!(reverse(u32x8::from(numbers)).to_array(), numbers.map(u32::reverse_bits));
        // the second dimension by its recurrence, v_(j+1) = v_j xor v_j / 2
        let second = |index: u32| {
            let mut direction = 1_u32 << 31;
            (0..32).fold(0, |sum, j| {
                let with = if index >> j & 1 == 1 { sum ^ direction } else { sum };
                direction ^= direction >> 1;
                with
            })
        };
        assert_eq!(reverse(shift_by_one(u32x8::from(numbers))).to_array(), numbers.map(second));
    }

    proptest! {
        #[test]
        fn every_prefix_is_a_net(seed: u32, m in 0_u32..11, block in 0_u32..5) {
            prop_assert!(is_net(&points(seed, block << m, 1 << m)));
        }

        #[test]
        fn any_part_of_the_sequence(seed: u32, first in 0_u32..1000, count in 0_usize..40) {
            prop_assert_eq!(points(seed, first, count), &points(seed, 0, first as usize + count)[first as usize..]);
        }
    }

    /// Over the seeds every point is uniform and different points of different sequences are not correlated.
    #[test]
    fn seeds_are_independent() {
        let side = 96;
        let first: Vec<[f32; 2]> =
            (0..side * side).map(|n| points(seed([n % side, n / side], 1, 7), 0, 1)[0]).collect();
        let count = first.len() as f64;
        let mean = |f: &dyn Fn(usize) -> f64| (0..first.len()).map(f).sum::<f64>() / count;
        let at = |n: usize, axis: usize| f64::from(first[n % first.len()][axis]) - 0.5;
        let sigma = (1.0_f64 / 12.0 / count).sqrt();
        for axis in 0..2 {
            assert!(mean(&|n| at(n, axis)).abs() < 4.0 * sigma);
            // neighbours along a row and along a column
            for step in [1, side as usize] {
                assert!(mean(&|n| 12.0 * at(n, axis) * at(n + step, axis)).abs() < 4.0 / count.sqrt());
            }
        }
        assert!(mean(&|n| 12.0 * at(n, 0) * at(n, 1)).abs() < 4.0 / count.sqrt());
    }
}
