//! `brdfit atlas` as it is typed.

use std::path::PathBuf;

use brdfit_bandwidth::LobeOptions;
use clap::Args;
use clap::builder::{PossibleValuesParser, TypedValueParser};

use crate::args::embedded_materials;
use crate::args::value_enums::Format;
use crate::args::value_enums::{ChannelsArg, ContainerArg, LayoutArg, PositionArg, SamplesArg};
use crate::args::{BATCH, OUTPUT};

/// Options of `brdfit atlas`.
#[derive(Debug, Args)]
pub(crate) struct AtlasArgs {
    /// Measured files (MERL .binary, RGL .bsdf), results of `brdfit fit`,
    /// folders (every measured file and every fit in them; other .json
    /// documents, such as summaries, are passed over), names of embedded materials, or @LIST: a text file with
    /// one path per line, as for `brdfit fit`
    #[arg(value_name = "INPUT", required = true)]
    pub(crate) inputs: Vec<PathBuf>,

    /// Look in the folders inside of folders too
    #[arg(long)]
    pub(crate) recursive: bool,

    /// Folder for the textures <name>.atlas.ktx2 and <name>.atlas.exr, and
    /// for <name>.atlas.json, which says how to use them
    #[arg(short, long, value_name = "DIR", help_heading = OUTPUT)]
    pub(crate) output: PathBuf,

    /// Which textures
    #[arg(long, value_name = "LIST", value_delimiter = ',', default_value = "ktx2,exr", help_heading = OUTPUT)]
    pub(crate) formats: Vec<ContainerArg>,

    /// Numbers in the OpenEXR file [default: half]
    #[arg(long, value_name = "TYPE", help_heading = OUTPUT)]
    pub(crate) exr_samples: Option<SamplesArg>,

    /// What a texel holds
    #[arg(long, value_name = "WHAT", default_value = "max", help_heading = OUTPUT)]
    pub(crate) channels: ChannelsArg,

    /// What the 256 tiles stand for
    #[arg(long, value_name = "WHAT", default_value = "isotropic", help_heading = OUTPUT)]
    pub(crate) layout: LayoutArg,

    /// Draw the atlas to <name>.atlas.png, to look at
    #[arg(long, help_heading = OUTPUT)]
    pub(crate) preview: bool,

    /// Print what was made: range and resolution of each atlas, or a list of
    /// the documents [default: nothing]
    #[arg(long, value_name = "FORMAT", help_heading = OUTPUT)]
    pub(crate) format: Option<Format>,

    /// Skip materials whose atlas is there, made by this version with the
    /// same options from a file with the same hash
    #[arg(long, help_heading = BATCH)]
    pub(crate) resume: bool,

    /// Take every N-th input only, starting with the I-th (from 1)
    #[arg(long, value_name = "I/N", help_heading = BATCH)]
    pub(crate) shard: Option<String>,

    /// Where in its cell a measured sample lies [default: edge; RGL: always
    /// centre]
    #[arg(long, value_name = "WHERE", help_heading = BATCH)]
    pub(crate) sample_position: Option<PositionArg>,

    /// Take NaN and infinite values for cells without a measurement instead
    /// of refusing the file
    #[arg(long, help_heading = BATCH)]
    pub(crate) accept_non_finite: bool,

    /// Bandwidth below which this share of the energy lies, percent
    #[arg(long, value_name = "P", default_value_t = 95.0, help_heading = ESTIMATION, allow_negative_numbers = true)]
    pub(crate) percentile: f64,

    /// Instead of the percentile, the published rule: the finest level whose
    /// coefficients reach E times the largest; reads about four times too
    /// high
    #[arg(long, value_name = "E", conflicts_with = "percentile", help_heading = ESTIMATION, allow_negative_numbers = true)]
    pub(crate) epsilon: Option<f64>,

    /// Drop bands with less than D^2 of the energy at a pixel
    #[arg(long, value_name = "D", default_value_t = LobeOptions::default().estimator.delta, help_heading = ESTIMATION,
          allow_negative_numbers = true)]
    pub(crate) delta: f64,

    /// Take the wavelet as it is instead of averaging over its reflections
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

/// What stands below the options in the help.
pub(super) fn examples() -> String {
    format!("{EXAMPLES}\n\n{}", embedded_materials::list())
}

const EXAMPLES: &str = "\
Examples:
  brdfit atlas fits -o atlases                 an atlas of each fit
  brdfit atlas brdfs -o atlases --resume       of each measured file
  brdfit atlas red-satin -o out --preview      of an embedded material
  brdfit atlas x.binary -o out --channels rgba --exr-samples float
  brdfit export wgsl                           how a shader samples it
A bad input is reported, and the rest is done.";
