//! Command-line arguments of `brdfit fit`, and of `brdfit merge` for its shards.

use std::path::PathBuf;

use brdfit_brdf::ModelName;
use clap::Args;
use clap::builder::{PossibleValuesParser, TypedValueParser};

use crate::args::headings::{BATCH, OUTPUT};
use crate::args::value_enums::{AnchorArg, ConstraintArg, LossArg, PositionArg, SolverArg};

/// Options of `brdfit fit`. An option that is absent keeps the value of the preset.
#[derive(Debug, Args)]
pub(crate) struct FitArgs {
    /// Measured files: MERL (.binary) and RGL (.bsdf, isotropic, RGB), folders
    /// (every such file in them), or @LIST: a text file with one of these per
    /// line, relative to its own folder; empty lines and lines that start
    /// with # are ignored; @- reads the list from standard input
    #[arg(value_name = "INPUT", required = true)]
    pub(crate) inputs: Vec<PathBuf>,

    /// Search folders recursively
    #[arg(long)]
    pub(crate) recursive: bool,

    /// Folder for <name>.json, summary.json and summary.csv; without it,
    /// the result of a single input is printed
    #[arg(short, long, value_name = "DIR", help_heading = OUTPUT)]
    pub(crate) output: Option<PathBuf>,

    /// Do not compute the error panel (errors over the whole grid)
    #[arg(long, help_heading = OUTPUT)]
    pub(crate) no_panel: bool,

    /// Read only the two slices: no hash, no validity check of the other
    /// cells, no error panel
    #[arg(long, help_heading = OUTPUT, conflicts_with = "resume")]
    pub(crate) no_hash: bool,

    /// Plot both slices, measured and fitted, to <name>.svg
    #[arg(long, help_heading = OUTPUT, requires = "output")]
    pub(crate) picture: bool,

    /// Also write the bandwidth atlas of each fit, with the default options
    /// of `brdfit atlas`: <name>.atlas.ktx2, .exr and .json
    #[arg(long, help_heading = OUTPUT, requires = "output")]
    pub(crate) atlas: bool,

    /// Keep existing results made by this version with the same options from
    /// the same input
    #[arg(long, help_heading = BATCH, requires = "output")]
    pub(crate) resume: bool,

    /// Process shard I of N: every N-th input, starting with the I-th; join
    /// the summaries with `brdfit merge`
    #[arg(long, value_name = "I/N", help_heading = BATCH, requires = "output")]
    pub(crate) shard: Option<String>,

    /// Treat NaN and infinite values as missing instead of rejecting the file
    #[arg(long, help_heading = BATCH)]
    pub(crate) accept_non_finite: bool,

    /// Microfacet model, named after its distribution of normals
    #[arg(long, value_name = "NAME", help_heading = MODEL, value_parser = models(), default_value_t)]
    pub(crate) model: ModelName,

    /// Position of a sample within its cell [default: edge; RGL: always
    /// centre]
    #[arg(long, value_name = "WHERE", help_heading = MODEL)]
    pub(crate) sample_position: Option<PositionArg>,

    /// Loss that both steps minimise [default: log1p-cos]
    #[arg(long, value_name = "LOSS", help_heading = MODEL)]
    pub(crate) loss: Option<LossArg>,

    /// Constraint on the Fresnel term [default: physical]; paper selects the
    /// published procedure: loss l2, constraint free, anchor distribution,
    /// solver lm, theta_d up to 70 degrees
    #[arg(long, value_name = "WHAT", help_heading = MODEL)]
    pub(crate) constraint: Option<ConstraintArg>,

    /// One distribution for R, G and B instead of three
    #[arg(long, help_heading = MODEL)]
    pub(crate) joint: bool,

    /// Peak height in step 2: as measured, or as fitted in step 1
    /// [default: peak]
    #[arg(long, value_name = "WHAT", help_heading = MODEL)]
    pub(crate) anchor: Option<AnchorArg>,

    /// Solver of step 2 [default: convex]
    #[arg(long, value_name = "HOW", help_heading = SOLVER)]
    pub(crate) step2_solver: Option<SolverArg>,

    /// Largest theta_h in step 1, degrees [default: 75]
    #[arg(long, value_name = "DEG", help_heading = SOLVER, allow_negative_numbers = true)]
    pub(crate) cutoff_theta_h: Option<f64>,

    /// Largest theta_d in step 2, degrees [default: 75]
    #[arg(long, value_name = "DEG", help_heading = SOLVER, allow_negative_numbers = true)]
    pub(crate) cutoff_theta_d: Option<f64>,

    /// Starting point of step 1, the shape parameters of the model (alpha,
    /// and p for sgd); may be repeated, the best result is kept
    /// [default for sgd: 1e-4,0.4 3e-3,0.4 0.1,0.4 0.9,0.1 1e-5,0.4]
    #[arg(long, value_name = "ALPHA[,P]", help_heading = SOLVER, value_parser = start, allow_hyphen_values = true)]
    pub(crate) start: Vec<Start>,

    /// Iteration limit of each solver run [default: 200]
    #[arg(long, value_name = "N", help_heading = SOLVER)]
    pub(crate) max_iterations: Option<u64>,
}

const MODEL: &str = "Model";
const SOLVER: &str = "Solver";

pub(super) const EXAMPLES: &str = "\
Examples:
  brdfit fit brdfs -o fits                     a folder, one JSON each
  brdfit fit brdfs -o fits --resume            resume an interrupted run
  brdfit fit gold.binary --picture -o fits     one file, with a plot
  brdfit fit brdfs -o fits --atlas             fits and bandwidth atlases
  brdfit fit gold.binary | jq .channels[0]     one file, printed
  brdfit fit @todo.txt -o fits --shard 2/8     the second of eight shards
  brdfit fit brdfs -o fits --constraint paper  the published procedure
An invalid file is reported and recorded in the summary; the batch continues.";

/// The names of the models.
fn models() -> impl TypedValueParser<Value = ModelName> {
    let names = ModelName::ALL.iter().map(|model| model.as_str());
    PossibleValuesParser::new(names).try_map(|name| name.parse::<ModelName>())
}

/// Shape parameters; how many there must be depends on the model.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Start(pub(crate) Vec<f64>);

/// Reads numbers that are separated by commas.
fn start(text: &str) -> Result<Start, String> {
    let number = |text: &str| text.trim().parse::<f64>();
    let numbers: Result<Vec<f64>, _> = text.split(',').map(number).collect();
    numbers
        .map(Start)
        .map_err(|_| "a starting point is one number per shape parameter, for instance 1e-3,0.4".to_owned())
}

/// Options of `brdfit merge`.
#[derive(Debug, Args)]
pub(crate) struct MergeArgs {
    /// Folder with summary.1-of-N.json .. summary.N-of-N.json
    #[arg(value_name = "DIR")]
    pub(crate) folder: PathBuf,
}

pub(super) const MERGE_EXAMPLES: &str = "\
Examples:
  for i in 1 2 3; do brdfit fit brdfs -o fits --shard $i/3 & done; wait
  brdfit merge fits                  writes fits/summary.json and .csv";

#[cfg(test)]
mod tests {
    use super::*;
    use crate::args::cli::Cli;
    use clap::CommandFactory;

    #[test]
    fn the_help_names_the_default_starts() {
        let command = Cli::command();
        let fit = command.find_subcommand("fit").unwrap();
        let help =
            fit.get_arguments().find(|argument| argument.get_id() == "start").unwrap().get_help().unwrap().to_string();
        let (_, listed) = help.trim_end_matches(']').split_once("[default for sgd: ").unwrap();
        let listed: Vec<Vec<f64>> = listed.split_whitespace().map(|pair| start(pair).unwrap().0).collect();
        assert_eq!(listed, brdfit_fit::FitOptions::default().starts);
    }

    #[test]
    fn a_start_is_numbers() {
        assert_eq!(start("1e-3, 0.4").unwrap().0, [1e-3, 0.4]);
        assert_eq!(start("0.2").unwrap().0, [0.2]);
        for bad in ["", "1;2", "a,b", "1,", ","] {
            assert!(start(bad).is_err(), "{bad}");
        }
    }
}
