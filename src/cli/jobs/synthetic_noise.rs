//! Noise for synthetic measurements: a pure function of a seed and a place, so that it depends neither on the order of the
//! evaluation nor on a library's choice of generator.

use std::f64::consts::PI;

/// Standard normal numbers, one per place.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Noise {
    key: u64,
}

impl Noise {
    pub(crate) fn new(seed: u64) -> Self {
        Self { key: mix(seed ^ 0x5851_f42d_4c95_7f2d) }
    }

    /// The number at a place; places differ by any bit.
    pub(crate) fn standard_normal(self, place: u64) -> f64 {
        let bits = mix(self.key ^ mix(place));
        // Box and Muller 1958, with 53 and 64 bits: u in (0, 1], so that the logarithm is finite.
        let u = ((bits >> 11) + 1) as f64 / (1_u64 << 53) as f64;
        let v = mix(bits) as f64 / 2_f64.powi(64);
        (-2.0 * libm::log(u)).sqrt() * libm::cos(2.0 * PI * v)
    }
}

/// One step of SplitMix64 (Steele, Lea & Flood 2014, "Fast splittable pseudorandom number generators"): a bijection whose
/// output bits depend on all input bits.
fn mix(x: u64) -> u64 {
    let x = x.wrapping_add(0x9e37_79b9_7f4a_7c15);
    let x = (x ^ (x >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let x = (x ^ (x >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    x ^ (x >> 31)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_step_is_that_of_splitmix64() {
        // First outputs of the published generator for the seed 0, whose state grows by the same constant.
        let outputs: Vec<u64> = (0..3_u64).map(|n| mix(n.wrapping_mul(0x9e37_79b9_7f4a_7c15))).collect();
        assert_eq!(outputs, [0xe220_a839_7b1d_cdaf, 0x6e78_9e6a_a1b9_65f4, 0x06c4_5d18_8009_454f]);
    }

    #[test]
    fn moments_and_tails_are_those_of_a_normal() {
        let noise = Noise::new(7);
        let count = 200_000;
        let sample: Vec<f64> = (0..count).map(|place| noise.standard_normal(place)).collect();
        let moment = |k: i32| sample.iter().map(|x| x.powi(k)).sum::<f64>() / count as f64;
        // five standard deviations of each estimate
        for (k, expected, variance) in [(1, 0.0, 1.0), (2, 1.0, 2.0), (3, 0.0, 15.0), (4, 3.0, 96.0_f64)] {
            let allowed = 5.0 * (variance / count as f64).sqrt();
            assert!((moment(k) - expected).abs() < allowed, "moment {k}: {}", moment(k));
        }
        let beyond_two = sample.iter().filter(|x| x.abs() > 2.0).count() as f64 / count as f64;
        assert!((beyond_two - 0.0455).abs() < 0.0025, "{beyond_two}");
        let neighbours = sample.windows(2).map(|w| w[0] * w[1]).sum::<f64>() / count as f64;
        assert!(neighbours.abs() < 5.0 / (count as f64).sqrt(), "{neighbours}");
    }

    #[test]
    fn seeds_differ() {
        assert_ne!(Noise::new(1).standard_normal(0), Noise::new(2).standard_normal(0));
        assert_eq!(Noise::new(1).standard_normal(5), Noise::new(1).standard_normal(5));
    }
}
