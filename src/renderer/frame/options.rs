//! The options of a frame and their validation.

use std::fmt;

use crate::passes::allocation::{Allocation, Budget, Prefilter};
use crate::passes::image_bandwidth::Geometry;
use crate::passes::pilot::LEAST_SAMPLES;
use crate::passes::upsampling_stencil::Upsampling;

/// Largest number of samples per pixel.
const MOST_SAMPLES_PER_PIXEL: f64 = 65_536.0;
/// Largest target of the relative error.
const LARGEST_ERROR: f64 = 10.0;
/// Most samples of a pilot point.
const MOST_PILOT_SAMPLES: u32 = 4096;
/// Smallest and largest number of samples per cycle, over two.
const SAMPLING_RATES: [f32; 2] = [0.01, 100.0];

/// Rendering mode: the active parts of the algorithm.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Mode {
    /// Pixels and counts both follow the prediction.
    #[default]
    Adaptive,
    /// The prediction decides which pixels are shaded; all points take the same number of samples.
    AdaptivePixels,
    /// Every pixel is shaded; the prediction decides with how many samples.
    AdaptiveCounts,
    /// Every pixel with the same number of samples: no prediction.
    Reference,
}

impl Mode {
    /// Whether the pilot predicts.
    #[must_use]
    pub fn predicts(self) -> bool {
        self != Self::Reference
    }

    /// Whether the prediction decides which pixels are shaded.
    pub(crate) fn divides(self) -> bool {
        matches!(self, Self::Adaptive | Self::AdaptivePixels)
    }
}

/// Options of a frame. [`RenderOptions::check`] validates them before anything is rendered.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RenderOptions {
    /// Rendering mode: the active parts of the algorithm.
    pub mode: Mode,
    /// Sample budget; in [`Mode::Reference`] samples per pixel, rounded.
    pub budget: Budget,
    /// Seed of all sample points.
    pub seed: u32,
    /// Samples of a pilot point, n_b, 4 to 4096.
    pub pilot_samples: u32,
    /// Transport of bandwidth from the surface to the image.
    pub geometry: Geometry,
    /// k_s: samples per cycle over two, 0.01 to 100.
    pub sampling_rate: f32,
    /// Sample allocation.
    pub allocation: Allocation,
    /// Up-sampling filter.
    pub upsampling: Upsampling,
    /// Whether the light may be prefiltered.
    pub prefilter: Prefilter,
}

impl Default for RenderOptions {
    fn default() -> Self {
        Self {
            mode: Mode::default(),
            budget: Budget::SamplesPerPixel(4.0),
            seed: 0,
            pilot_samples: 16,
            geometry: Geometry::default(),
            sampling_rate: 1.0,
            allocation: Allocation::default(),
            upsampling: Upsampling::default(),
            prefilter: Prefilter::default(),
        }
    }
}

/// An option of [`RenderOptions`] that has a range.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RangedOption {
    /// [`Budget::SamplesPerPixel`].
    SamplesPerPixel,
    /// [`Budget::TargetError`].
    TargetError,
    /// [`RenderOptions::pilot_samples`].
    PilotSamples,
    /// [`RenderOptions::sampling_rate`].
    SamplingRate,
    /// [`Prefilter::Above`].
    PrefilterThreshold,
}

impl fmt::Display for RangedOption {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::SamplesPerPixel => "samples per pixel",
            Self::TargetError => "target error",
            Self::PilotSamples => "pilot samples",
            Self::SamplingRate => "sampling rate",
            Self::PrefilterThreshold => "prefilter threshold",
        })
    }
}

/// Errors of options.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum OptionsError {
    /// A value outside of its range, or not a number.
    #[error("{option} {value}: must lie {range}")]
    Range {
        /// The option.
        option: RangedOption,
        /// Its value.
        value: f64,
        /// Its range: "above 0, up to 10".
        range: &'static str,
    },
    /// [`Mode::Reference`] has no prediction that this option could follow.
    #[error("{0} cannot be used in reference mode, which makes no prediction")]
    NeedsPrediction(RangedOption),
    /// Less than half a sample per pixel in [`Mode::Reference`], which would be rounded to none.
    #[error("{0} samples per pixel: the reference mode needs at least one")]
    NoSample(f64),
}

impl RenderOptions {
    /// Checks every value by itself and against the mode.
    ///
    /// # Errors
    /// The first option that cannot be used.
    pub fn check(&self) -> Result<(), OptionsError> {
        use RangedOption::{PilotSamples, PrefilterThreshold, SamplesPerPixel, SamplingRate, TargetError};
        let lies = |option, value: f64, lies: bool, range| {
            if lies { Ok(()) } else { Err(OptionsError::Range { option, value, range }) }
        };
        match self.budget {
            Budget::TargetError(_) if !self.mode.predicts() => return Err(OptionsError::NeedsPrediction(TargetError)),
            Budget::TargetError(error) => {
                lies(TargetError, error, error > 0.0 && error <= LARGEST_ERROR, "above 0, up to 10")?;
            }
            Budget::SamplesPerPixel(samples) => {
                let inside = samples > 0.0 && samples <= MOST_SAMPLES_PER_PIXEL;
                lies(SamplesPerPixel, samples, inside, "above 0, up to 65536")?;
                if !self.mode.predicts() && samples.round() < 1.0 {
                    return Err(OptionsError::NoSample(samples));
                }
            }
        }
        let (rate, [least, most]) = (self.sampling_rate, SAMPLING_RATES);
        lies(SamplingRate, rate.into(), rate >= least && rate <= most, "from 0.01 to 100")?;
        let samples = self.pilot_samples;
        let inside = (LEAST_SAMPLES..=MOST_PILOT_SAMPLES).contains(&samples);
        lies(PilotSamples, samples.into(), inside, "from 4 to 4096")?;
        match self.prefilter {
            Prefilter::Above(_) if !self.mode.predicts() => Err(OptionsError::NeedsPrediction(PrefilterThreshold)),
            Prefilter::Above(threshold) => {
                let inside = threshold >= 0.0 && threshold.is_finite();
                lies(PrefilterThreshold, threshold.into(), inside, "from 0, finite")
            }
            Prefilter::Never | Prefilter::Always => Ok(()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn limits_are_inside_and_what_lies_beyond_is_named() {
        let default = RenderOptions::default();
        assert_eq!(default.check(), Ok(()));
        let ranged = |options: RenderOptions| match options.check() {
            Err(OptionsError::Range { option, .. }) => Some(option),
            Ok(()) => None,
            Err(other) => panic!("{other}"),
        };
        let spp = |samples| ranged(RenderOptions { budget: Budget::SamplesPerPixel(samples), ..default });
        assert_eq!([0.01, 65_536.0].map(spp), [None; 2]);
        assert_eq!([0.0, -1.0, 65_537.0, f64::NAN].map(spp), [Some(RangedOption::SamplesPerPixel); 4]);
        let error = |error| ranged(RenderOptions { budget: Budget::TargetError(error), ..default });
        assert_eq!([1e-3, 10.0].map(error), [None; 2]);
        assert_eq!([0.0, 10.5, f64::INFINITY].map(error), [Some(RangedOption::TargetError); 3]);
        // from 1.48 million on, products of counts did not fit into 32 bits
        let pilot = |pilot_samples| ranged(RenderOptions { pilot_samples, ..default });
        assert_eq!([4, 4096].map(pilot), [None; 2]);
        assert_eq!([0, 3, 4097, 1_500_000, u32::MAX].map(pilot), [Some(RangedOption::PilotSamples); 5]);
        let rate = |sampling_rate| ranged(RenderOptions { sampling_rate, ..default });
        assert_eq!([0.01, 100.0].map(rate), [None; 2]);
        assert_eq!([0.0, 101.0, f32::NAN].map(rate), [Some(RangedOption::SamplingRate); 3]);
        let threshold = |x| ranged(RenderOptions { prefilter: Prefilter::Above(x), ..default });
        assert_eq!([0.0, 7.0].map(threshold), [None; 2]);
        assert_eq!([-0.1, f32::INFINITY, f32::NAN].map(threshold), [Some(RangedOption::PrefilterThreshold); 3]);
    }

    #[test]
    fn the_reference_mode_follows_no_prediction() {
        let reference = RenderOptions { mode: Mode::Reference, ..RenderOptions::default() };
        assert_eq!(reference.check(), Ok(()));
        let error = RenderOptions { budget: Budget::TargetError(0.1), ..reference }.check();
        assert_eq!(error, Err(OptionsError::NeedsPrediction(RangedOption::TargetError)));
        let error = RenderOptions { prefilter: Prefilter::Above(0.1), ..reference }.check();
        assert_eq!(error, Err(OptionsError::NeedsPrediction(RangedOption::PrefilterThreshold)));
        let error = RenderOptions { budget: Budget::SamplesPerPixel(0.4), ..reference }.check();
        assert_eq!(error, Err(OptionsError::NoSample(0.4)));
    }
}
