//! Command-line arguments of `brdfit atlas`.

use std::path::PathBuf;

use brdfit_bandwidth::LobeOptions;
use clap::Args;
use clap::builder::{PossibleValuesParser, TypedValueParser};

use crate::args::embedded_materials;
use crate::args::headings::{BATCH, OUTPUT};
use crate::args::value_enums::Format;
use crate::args::value_enums::{ChannelsArg, ContainerArg, LayoutArg, PositionArg, SamplesArg};

/// Options of `brdfit atlas`.
#[derive(Debug, Args)]
pub(crate) struct AtlasArgs {
    /// Measured files (MERL .binary, RGL .bsdf), results of `brdfit fit`,
    /// folders (every measured file and every fit in them; other .json files
    /// are ignored), names of embedded materials, or @LIST: a text file with
    /// one path per line, as for `brdfit fit`
    #[arg(value_name = "INPUT", required = true)]
    pub(crate) inputs: Vec<PathBuf>,

    /// Search folders recursively
    #[arg(long)]
    pub(crate) recursive: bool,

    /// Folder for the textures <name>.atlas.ktx2 and <name>.atlas.exr, and
    /// their sidecar <name>.atlas.json
    #[arg(short, long, value_name = "DIR", help_heading = OUTPUT)]
    pub(crate) output: PathBuf,

    /// Texture formats
    #[arg(long, value_name = "LIST", value_delimiter = ',', default_value = "ktx2,exr", help_heading = OUTPUT)]
    pub(crate) formats: Vec<ContainerArg>,

    /// Sample type of the OpenEXR file [default: half]
    #[arg(long, value_name = "TYPE", help_heading = OUTPUT)]
    pub(crate) exr_samples: Option<SamplesArg>,

    /// Channels of a texel
    #[arg(long, value_name = "WHAT", default_value = "max", help_heading = OUTPUT)]
    pub(crate) channels: ChannelsArg,

    /// Incident directions of the 256 tiles
    #[arg(long, value_name = "WHAT", default_value = "isotropic", help_heading = OUTPUT)]
    pub(crate) layout: LayoutArg,

    /// Write a false-colour preview, <name>.atlas.png
    #[arg(long, help_heading = OUTPUT)]
    pub(crate) preview: bool,

    /// Print a report: range and resolution of each atlas as text, or the
    /// list of sidecars as JSON [default: none]
    #[arg(long, value_name = "FORMAT", help_heading = OUTPUT)]
    pub(crate) format: Option<Format>,

    /// Keep existing results made by this version with the same options from
    /// the same input
    #[arg(long, help_heading = BATCH)]
    pub(crate) resume: bool,

    /// Process shard I of N: every N-th input, starting with the I-th
    #[arg(long, value_name = "I/N", help_heading = BATCH)]
    pub(crate) shard: Option<String>,

    /// Position of a measured sample within its cell [default: edge; RGL:
    /// always centre]
    #[arg(long, value_name = "WHERE", help_heading = BATCH)]
    pub(crate) sample_position: Option<PositionArg>,

    /// Treat NaN and infinite values as missing instead of rejecting the file
    #[arg(long, help_heading = BATCH)]
    pub(crate) accept_non_finite: bool,

    /// Percentile of the spectral energy that defines the bandwidth
    #[arg(long, value_name = "P", default_value_t = 95.0, help_heading = ESTIMATION, allow_negative_numbers = true)]
    pub(crate) percentile: f64,

    /// Use the published rule instead of the percentile: the finest level
    /// whose coefficients reach E times the largest (about four times too
    /// high)
    #[arg(long, value_name = "E", conflicts_with = "percentile", help_heading = ESTIMATION, allow_negative_numbers = true)]
    pub(crate) epsilon: Option<f64>,

    /// Ignore bands with less than D^2 of the energy at a pixel
    #[arg(long, value_name = "D", default_value_t = LobeOptions::default().estimator.delta, help_heading = ESTIMATION,
          allow_negative_numbers = true)]
    pub(crate) delta: f64,

    /// Do not average over the reflections of the wavelet
    #[arg(long, help_heading = ESTIMATION)]
    pub(crate) no_reflections: bool,

    /// Double the resolution of a lobe while its finest level holds more
    /// than this share of the energy
    #[arg(long, value_name = "S", default_value_t = LobeOptions::default().finest_share, help_heading = ESTIMATION,
          allow_negative_numbers = true)]
    pub(crate) finest_share: f64,

    /// Highest resolution of a lobe, samples along a side
    #[arg(long, value_name = "N", default_value = "1024", help_heading = ESTIMATION,
          value_parser = PossibleValuesParser::new(["256", "512", "1024"]).try_map(|text| text.parse::<usize>()))]
    pub(crate) max_resolution: usize,
}

const ESTIMATION: &str = "Estimation";

/// Text below the options in the help.
pub(super) fn examples() -> String {
    format!("{EXAMPLES}\n\n{}", embedded_materials::list())
}

const EXAMPLES: &str = "\
Examples:
  brdfit atlas fits -o atlases                 an atlas of each fit
  brdfit atlas brdfs -o atlases --resume       of each measured file
  brdfit atlas red-satin -o out --preview      of an embedded material
  brdfit atlas x.binary -o out --channels rgba --exr-samples float
  brdfit export wgsl                           shader functions that sample it
An invalid input is reported; the batch continues.";
