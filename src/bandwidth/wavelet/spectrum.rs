//! The bandwidth at a pixel from its energies per band: the noise rule, the percentile and the epsilon rule.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Rule by which the bandwidth of a pixel follows from its energies per band.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Rule {
    /// The bandwidth is this percentile of the energies of the bands that count, each spread evenly over the octave of its band in
    /// log2 of the frequency (95: Bagher 2013, section 2.1).
    Percentile(f64),
    /// Bagher 2013, eq. (7): the finest level at which the sum of the largest coefficients of this and all finer levels reaches this
    /// share of the largest one. For reproduction: about four times too high on sine gratings.
    Epsilon(f64),
}

/// Octaves per segment of the spectrum: bands overlap by half an octave.
const SEGMENT: f32 = 0.5;

/// Base-2 logarithm of the upper end of the spectrum in cycles per pixel: `sqrt(2)/2`, the diagonal band of level 1.
pub(crate) const TOP: f32 = -0.5;

/// Samples that are worked on together.
const LANES: usize = 16;

/// Energies per band at the samples of one row: `[sides, diagonals]` of each level, finest first, then the mean.
#[derive(Clone, Debug, Default)]
pub(crate) struct Spectra {
    energies: Vec<f32>,
    logarithms: Vec<f32>,
    samples: usize,
    /// Samples of a row of `energies`: a multiple of [`LANES`].
    stride: usize,
    levels: usize,
}

impl Spectra {
    pub(crate) fn new(samples: usize, levels: usize) -> Self {
        let stride = samples.next_multiple_of(LANES);
        Self { energies: vec![0.0; stride * (2 * levels + 1)], logarithms: vec![0.0; stride], samples, stride, levels }
    }

    /// Takes a shape; the energies are left to be written.
    pub(crate) fn shape(&mut self, samples: usize, levels: usize) {
        if (self.samples, self.levels) != (samples, levels) {
            *self = Self::new(samples, levels);
        }
    }

    /// Sides and diagonals of a level.
    #[inline(always)]
    pub(crate) fn level(&mut self, level: usize) -> [&mut [f32]; 2] {
        let (sides, diagonals) = self.energies[2 * level * self.stride..].split_at_mut(self.stride);
        [&mut sides[..self.samples], &mut diagonals[..self.samples]]
    }

    /// The approximation.
    #[inline(always)]
    pub(crate) fn mean(&mut self) -> &mut [f32] {
        &mut self.energies[2 * self.levels * self.stride..][..self.samples]
    }

    /// Base 2 logarithm of the percentile's frequency of each sample in cycles per sample, without calibration, or negative
    /// infinity where no band counts. A band of at most `delta_square` times the sum of all energies, the mean's included, does
    /// not count.
    #[inline(always)]
    pub(crate) fn percentiles(&mut self, share: f32, delta_square: f32) -> &[f32] {
        let (stride, bands) = (self.stride, 2 * self.levels);
        let (energies, out) = (&self.energies[..stride * (bands + 1)], &mut self.logarithms[..stride]);
        for (group, out) in out.chunks_exact_mut(LANES).enumerate() {
            let load = |band: usize| -> [f32; LANES] {
                let from = &energies[band * stride + group * LANES..][..LANES];
                std::array::from_fn(|l| from[l])
            };
            let mut all = load(bands);
            for band in 0..bands {
                let energy = load(band);
                for l in 0..LANES {
                    all[l] += energy[l];
                }
            }
            let counted = |band: usize| {
                let energy = load(band);
                std::array::from_fn(|l| if energy[l] > delta_square * all[l] { energy[l] } else { 0.0 })
            };
            let mut need = [0.0_f32; LANES];
            for band in 0..bands {
                let energy: [f32; LANES] = counted(band);
                for l in 0..LANES {
                    need[l] += energy[l];
                }
            }
            let mut walk = Walk::new(need.map(|sum| share * sum));
            let mut above = [0.0; LANES];
            for level in 0..self.levels {
                let (sides, diagonals) = (counted(2 * level), counted(2 * level + 1));
                walk.segment(&diagonals, &above);
                walk.segment(&diagonals, &sides);
                above = sides;
            }
            walk.segment(&[0.0; LANES], &above);
            for l in 0..LANES {
                let depth = walk.whole[l] + ((walk.need[l] - walk.before[l]) / walk.within[l]).min(1.0);
                out[l] = if need[l] > 0.0 { TOP - SEGMENT * depth } else { f32::NEG_INFINITY };
            }
        }
        &out[..self.samples]
    }

    /// Base 2 logarithm of the upper end, in cycles per sample, of the octave of the finest level that the epsilon rule finds,
    /// or negative infinity without any energy.
    pub(crate) fn finest_levels(&mut self, epsilon: f32) -> &[f32] {
        for n in 0..self.samples {
            // coefficients per level, from energies per sample
            let coefficient = |level: usize| {
                let energy = |band: usize| self.energies[band * self.stride + n];
                (4.0_f32.powi(level as i32 + 1) * (energy(2 * level) + energy(2 * level + 1))).sqrt()
            };
            let largest = (0..self.levels).map(coefficient).fold(0.0, f32::max);
            let mut sum = 0.0;
            let finest = (0..self.levels).find(|&level| {
                sum += coefficient(level);
                sum >= epsilon * largest && largest > 0.0
            });
            self.logarithms[n] = finest.map_or(f32::NEG_INFINITY, |level| -1.0 - level as f32);
        }
        &self.logarithms[..self.samples]
    }
}

/// The way down the spectrum, one segment of half an octave after the other, until the sum reaches `need`.
struct Walk {
    need: [f32; LANES],
    sum: [f32; LANES],
    /// Sum before the segment in which it reaches `need`, and the energy of that segment.
    before: [f32; LANES],
    within: [f32; LANES],
    /// Segments before that.
    whole: [f32; LANES],
}

impl Walk {
    fn new(need: [f32; LANES]) -> Self {
        Self { need, sum: [0.0; LANES], before: [0.0; LANES], within: [1.0; LANES], whole: [0.0; LANES] }
    }

    /// The next segment: half of the octaves of two bands.
    #[inline(always)]
    fn segment(&mut self, a: &[f32; LANES], b: &[f32; LANES]) {
        for l in 0..LANES {
            let energy = 0.5 * (a[l] + b[l]);
            let open = self.sum[l] < self.need[l];
            let next = self.sum[l] + energy;
            self.within[l] = if open { energy } else { self.within[l] };
            self.before[l] = if open { self.sum[l] } else { self.before[l] };
            self.whole[l] += if next < self.need[l] { 1.0 } else { 0.0 };
            self.sum[l] = next;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const COUNT: usize = 4;

    /// Spectra of the samples `[D1, H1 + V1, D2, H2 + V2, .., mean]`.
    fn spectra(samples: &[[f32; 2 * COUNT + 1]]) -> Spectra {
        let mut spectra = Spectra::new(samples.len(), COUNT);
        for (n, sample) in samples.iter().enumerate() {
            for level in 0..COUNT {
                let [sides, diagonals] = spectra.level(level);
                (diagonals[n], sides[n]) = (sample[2 * level], sample[2 * level + 1]);
            }
            spectra.mean()[n] = sample[2 * COUNT];
        }
        spectra
    }

    /// By the definition: every band is spread evenly over an octave, which for D1 ends at `sqrt(1/2)` and for the others half an
    /// octave below the one before; bisection for the frequency above which the share lies.
    fn slow(sample: &[f32; 2 * COUNT + 1], share: f64, delta_square: f64) -> Option<f64> {
        let sample = sample.map(f64::from);
        let all: f64 = sample.iter().sum();
        let bands = sample.map(|energy| if energy > delta_square * all { energy } else { 0.0 });
        let top = |band: usize| -0.5 - 0.5 * band as f64;
        let above = |x: f64| (0..2 * COUNT).map(|band| bands[band] * (top(band) - x).clamp(0.0, 1.0)).sum::<f64>();
        let sum: f64 = bands[..2 * COUNT].iter().sum();
        let (mut low, mut high) = (top(2 * COUNT + 1), -0.5);
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            if above(middle) > share * sum { low = middle } else { high = middle }
        }
        (sum > 0.0).then_some(low)
    }

    proptest! {
        #[test]
        fn percentiles_follow_the_definition(
            samples in prop::collection::vec(prop::array::uniform9(prop_oneof![Just(0.0_f32), 1e-6..1.0_f32]), 1..40),
            share in 0.01..0.99_f64, delta_square in prop_oneof![Just(0.0), Just(4e-4)],
        ) {
            let mut spectra = spectra(&samples);
            let ours = spectra.percentiles(share as f32, delta_square as f32);
            prop_assert_eq!(ours.len(), samples.len());
            for (ours, sample) in ours.iter().zip(&samples) {
                match slow(sample, share, delta_square) {
                    None => prop_assert_eq!(*ours, f32::NEG_INFINITY),
                    // where a segment holds nearly nothing, the place in it is a quotient of roundings
                    Some(_) if *ours == f32::NEG_INFINITY => prop_assert!(false, "no frequency of {sample:?}"),
                    Some(slow) => prop_assert!((f64::from(*ours) - slow).abs() < 1e-3, "{ours} {slow} {sample:?}"),
                }
            }
        }
    }

    #[test]
    fn one_band_alone() {
        for band in 0..2 * COUNT {
            let mut sample = [0.0; 2 * COUNT + 1];
            sample[band] = 3.0;
            let found = spectra(&[sample]).percentiles(0.25, 4e-4)[0];
            assert_eq!(found, -0.5 - 0.5 * band as f32 - 0.25);
        }
    }

    #[test]
    fn bands_that_do_not_stand_out_of_the_mean_do_not_count() {
        let mut sample = [0.0; 2 * COUNT + 1];
        (sample[0], sample[5], sample[2 * COUNT]) = (1e-5, 0.1, 1.0);
        let both = spectra(&[sample]).percentiles(1e-6, 0.0)[0];
        let coarse = spectra(&[sample]).percentiles(1e-6, 4e-4)[0];
        assert!((TOP - both).abs() < 0.02 && (TOP - 2.5 - coarse).abs() < 0.02, "{both} {coarse}");
        sample[5] = 4e-4;
        assert_eq!(spectra(&[sample]).percentiles(0.05, 4e-4)[0], f32::NEG_INFINITY);
    }

    #[test]
    fn the_epsilon_rule_counts_coefficients_from_the_finest() {
        // coefficients 1, 2, 8, 0 of the levels, finest first: energies are their squares over 4, 16, 64
        let mut sample = [0.0; 2 * COUNT + 1];
        (sample[0], sample[3], sample[4], sample[2 * COUNT]) = (1.0 / 4.0, 4.0 / 16.0, 64.0 / 64.0, 9.0);
        let finest = |epsilon| spectra(&[sample]).finest_levels(epsilon)[0];
        assert_eq!(finest(0.12), -1.0);
        assert_eq!(finest(0.37), -2.0);
        assert_eq!(finest(0.4), -3.0);
        assert_eq!(spectra(&[[0.0; 2 * COUNT + 1]]).finest_levels(0.1)[0], f32::NEG_INFINITY);
    }
}
