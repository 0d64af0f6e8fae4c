//! Command-line arguments of `brdfit info` and `brdfit synth`, which read and write measured files.

use std::path::PathBuf;

use clap::Args;

use crate::args::embedded_materials;
use crate::args::value_enums::{Format, PositionArg};

/// Options of `brdfit info`.
#[derive(Debug, Args)]
pub(crate) struct InfoArgs {
    /// Measured files: MERL (.binary) and RGL (.bsdf, isotropic, RGB)
    #[arg(value_name = "FILE", required = true)]
    pub(crate) files: Vec<PathBuf>,

    /// Output format
    #[arg(long, value_name = "FORMAT", default_value = "text")]
    pub(crate) format: Format,

    /// Position of a sample within its cell [default: edge; RGL: always
    /// centre]
    #[arg(long, value_name = "WHERE")]
    pub(crate) sample_position: Option<PositionArg>,
}

pub(super) const INFO_EXAMPLES: &str = "\
Examples:
  brdfit info gold.binary
  brdfit info chm_mint_rgb.bsdf
  brdfit info brdfs/*.binary --format json | jq '.[].zero_peaks'
JSON output is a list with one entry per file. An unusable file is reported on
standard error and in the exit code.";

/// Options of `brdfit synth`.
#[derive(Debug, Args)]
pub(crate) struct SynthArgs {
    /// Result of `brdfit fit` (or any JSON document with the parameters of
    /// three channels in the same place), or the name of an embedded material
    #[arg(value_name = "RESULT.json|NAME")]
    pub(crate) source: PathBuf,

    /// MERL file to write
    #[arg(short, long, value_name = "FILE.binary")]
    pub(crate) output: PathBuf,

    /// Position of a sample within its cell [default: as in the result, or
    /// edge]
    #[arg(long, value_name = "WHERE")]
    pub(crate) sample_position: Option<PositionArg>,

    /// Number of bins of phi_d, 180 or 360 [default: as in the result, or 180]
    #[arg(long, value_name = "N")]
    pub(crate) phi_bins: Option<u16>,

    /// Multiplicative log-normal noise with standard deviation S of the
    /// logarithm
    #[arg(long, value_name = "S", default_value_t = 0.0, allow_negative_numbers = true, help_heading = "Noise")]
    pub(crate) noise: f64,

    /// Random seed of the noise; the same seed gives the same file
    #[arg(long, value_name = "N", default_value_t = 0, requires = "noise", help_heading = "Noise")]
    pub(crate) seed: u64,
}

/// Text below the options in the help.
pub(super) fn synth_examples() -> String {
    format!("{SYNTH_EXAMPLES}\n\n{}", embedded_materials::list())
}

pub(super) const SYNTH_EXAMPLES: &str = "\
Examples:
  brdfit synth fits/gold.json -o gold.binary
  brdfit synth gold-metallic-paint -o gold.binary --noise 0.05 --seed 7";
