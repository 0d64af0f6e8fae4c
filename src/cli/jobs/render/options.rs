//! The options of `brdfit render` that influence an image: from arguments to the options of the renderer, and to what the
//! statistics say. Limits are the renderer's.

use brdfit_renderer::{Budget, OptionsError, Prefilter, RangedOption, RenderOptions};
use clap::ValueEnum;
use schemars::JsonSchema;
use serde::Serialize;

use crate::args::render::RenderArgs;
use crate::terminal::exit_code::Problem;

/// Options of the renderer.
///
/// # Errors
/// Options outside of their range or against each other.
pub(crate) fn options(args: &RenderArgs) -> Result<RenderOptions, Problem> {
    let options = RenderOptions {
        mode: args.mode.into(),
        budget: args.target_error.map_or(Budget::SamplesPerPixel(args.spp), Budget::TargetError),
        seed: args.seed,
        pilot_samples: args.pilot_samples,
        geometry: args.geometry.into(),
        sampling_rate: args.sampling_rate,
        allocation: args.allocation.into(),
        upsampling: args.upsample.into(),
        prefilter: prefilter(&args.prefilter)?,
    };
    options.check().map_err(|error| refused(error, args))?;
    Ok(options)
}

fn prefilter(word: &str) -> Result<Prefilter, Problem> {
    match word {
        "never" => Ok(Prefilter::Never),
        "always" => Ok(Prefilter::Always),
        number => number.parse().map(Prefilter::Above).map_err(|_| not_a_threshold(word)),
    }
}

fn not_a_threshold(word: &str) -> Problem {
    Problem::usage(format!("--prefilter {word}: must be never, always, or a number from 0"))
}

/// An error of the renderer by the names of the command line.
fn refused(error: OptionsError, args: &RenderArgs) -> Problem {
    let message = match error {
        OptionsError::Range { option: RangedOption::PrefilterThreshold, .. } => {
            return not_a_threshold(&args.prefilter);
        }
        OptionsError::Range { option, value, range } => format!("{} {value}: must lie {range}", flag(option)),
        OptionsError::NeedsPrediction(RangedOption::PrefilterThreshold) => {
            format!("--prefilter {}: --mode reference accepts only never or always", args.prefilter)
        }
        OptionsError::NeedsPrediction(option) => {
            format!("{} cannot be used with --mode reference; use --spp", flag(option))
        }
        OptionsError::NoSample(samples) => {
            format!("--spp {samples}: --mode reference needs at least one sample per pixel")
        }
    };
    Problem::usage(message)
}

fn flag(option: RangedOption) -> &'static str {
    match option {
        RangedOption::SamplesPerPixel => "--spp",
        RangedOption::TargetError => "--target-error",
        RangedOption::PilotSamples => "--pilot-samples",
        RangedOption::SamplingRate => "--sampling-rate",
        RangedOption::PrefilterThreshold => "--prefilter",
    }
}

/// Options, as on the command line.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub(crate) struct OptionsEntry {
    /// Rendering mode.
    pub(crate) mode: String,
    /// Requested mean number of samples per surface pixel.
    pub(crate) spp: Option<f64>,
    /// Requested relative error.
    pub(crate) target_error: Option<f64>,
    /// Seed.
    pub(crate) seed: u32,
    /// Number of averaged frames.
    pub(crate) frames: u32,
    /// Samples of a pilot point.
    pub(crate) pilot_samples: u32,
    /// Transport of bandwidth from the surface to the image.
    pub(crate) geometry: String,
    /// Sampling rate in units of the Nyquist rate.
    pub(crate) sampling_rate: f32,
    /// Sample allocation.
    pub(crate) allocation: String,
    /// Filter that fills the pixels between the shaded ones.
    pub(crate) upsample: String,
    /// never, always, or the threshold.
    pub(crate) prefilter: String,
}

impl OptionsEntry {
    /// The options, as on the command line.
    pub(crate) fn new(args: &RenderArgs, options: &RenderOptions) -> Self {
        let (spp, target_error) = match options.budget {
            Budget::SamplesPerPixel(spp) => (Some(spp), None),
            Budget::TargetError(error) => (None, Some(error)),
        };
        Self {
            mode: word(args.mode),
            spp,
            target_error,
            seed: options.seed,
            frames: args.frames,
            pilot_samples: if options.mode.predicts() { options.pilot_samples } else { 0 },
            geometry: word(args.geometry),
            sampling_rate: options.sampling_rate,
            allocation: word(args.allocation),
            upsample: word(args.upsample),
            prefilter: match options.prefilter {
                Prefilter::Never => "never".to_owned(),
                Prefilter::Always => "always".to_owned(),
                Prefilter::Above(threshold) => threshold.to_string(),
            },
        }
    }
}

/// The word of the command line that a value has.
fn word(value: impl ValueEnum) -> String {
    value.to_possible_value().map_or_else(String::new, |value| value.get_name().to_owned())
}
