//! The command line as it is typed. What it means is decided by `plan` and by the subcommands.

use std::ffi::OsString;
use std::path::PathBuf;

use clap::{ArgAction, Args, ColorChoice, Parser, Subcommand, ValueEnum};
use clap_complete::Shell;

use crate::compare::{self, CompareArgs};
use crate::demo::{self, DemoArgs};
use crate::synth;
use crate::words::{AnchorArg, ConstraintArg, LossArg, PositionArg, SolverArg};
pub(crate) use crate::words::{Format, SchemaName};

/// Fit measured isotropic BRDFs (MERL format) with the SGD microfacet model.
#[derive(Debug, Parser)]
#[command(name = "brdfit", version, max_term_width = 80, after_help = AFTER_HELP, disable_help_subcommand = true)]
#[command(subcommand_required = true, arg_required_else_help = false)]
pub(crate) struct Cli {
    /// Threads to compute with [default: one per core]; results do not
    /// depend on it
    #[arg(long, value_name = "N", global = true, help_heading = GLOBAL, value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub(crate) threads: Option<u16>,

    /// Print errors only
    #[arg(long, short, global = true, help_heading = GLOBAL, conflicts_with = "verbose")]
    pub(crate) quiet: bool,

    /// Say what is going on; twice for more
    #[arg(long, short, global = true, help_heading = GLOBAL, action = ArgAction::Count)]
    pub(crate) verbose: u8,

    /// When to use colour; NO_COLOR is honoured
    #[arg(long, value_name = "WHEN", global = true, help_heading = GLOBAL, default_value = "auto")]
    pub(crate) color: ColorChoice,

    #[command(subcommand)]
    pub(crate) command: Command,
}

/// Heading of the options that every subcommand takes.
const GLOBAL: &str = "Everywhere";

const AFTER_HELP: &str = "\
Exit codes:
  0    done
  1    the command line makes no sense
  2    a file could not be read or written
  3    an input is not what it should be
  4    a computation failed
  7    a comparison found a difference beyond its tolerance
  130  interrupted (Ctrl-C); nothing half-written is left
  A batch goes on past a bad file and ends with the largest code that occurred.

Examples:
  brdfit demo -o out                 fit an embedded material, draw its slices
  brdfit fit brdfs -o fits           fit every .binary file in the folder brdfs
  brdfit info brdfs/*.binary         look at files before trusting them
  brdfit synth fits/x.json -o x.binary
                                     turn a fit back into a MERL file
`brdfit COMMAND --help` has the options and examples of each command.";

#[derive(Debug, Subcommand)]
pub(crate) enum Command {
    /// Fit MERL files: one JSON document per material and a summary
    #[command(after_help = FIT_EXAMPLES)]
    Fit(Box<FitArgs>),
    /// Show the state of MERL files: validity, range, albedo, hash
    #[command(after_help = INFO_EXAMPLES)]
    Info(InfoArgs),
    /// Make a MERL file from a fit or from an embedded material
    #[command(after_help = synth::examples())]
    Synth(SynthArgs),
    /// Compare fits with reference fits, with tolerances
    #[command(after_help = compare::EXAMPLES)]
    Compare(CompareArgs),
    /// Join the summaries of a batch that was fitted in shards
    #[command(after_help = MERGE_EXAMPLES)]
    Merge(MergeArgs),
    /// Print the JSON Schema of a document
    #[command(after_help = SCHEMA_EXAMPLES)]
    Schema(SchemaArgs),
    /// Synthesise, fit and draw an embedded material
    #[command(after_help = demo::EXAMPLES)]
    Demo(DemoArgs),
    /// Print a completion script for a shell
    #[command(after_help = COMPLETIONS_EXAMPLES)]
    Completions(CompletionsArgs),
    /// Print the manual page of the program or of a command
    #[command(after_help = MAN_EXAMPLES)]
    Man(ManArgs),
}

/// Options of `brdfit fit`. Whatever is left out keeps the value of the preset.
#[derive(Debug, Args)]
pub(crate) struct FitArgs {
    /// MERL files, folders (every .binary file in them), or @LIST: a text
    /// file with one of these per line, relative to its own folder; empty
    /// lines and lines that start with # are skipped; @- reads it from
    /// standard input
    #[arg(value_name = "INPUT", required = true)]
    pub(crate) inputs: Vec<PathBuf>,

    /// Look for .binary files in the folders inside of folders too
    #[arg(long)]
    pub(crate) recursive: bool,

    /// Folder for <name>.json, summary.json and summary.csv; without it, the
    /// document of a single input goes to standard output
    #[arg(short, long, value_name = "DIR", help_heading = OUTPUT)]
    pub(crate) output: Option<PathBuf>,

    /// Leave out the errors over the whole grid
    #[arg(long, help_heading = OUTPUT)]
    pub(crate) no_panel: bool,

    /// Read only the two slices: no hash, no look at the other cells, no
    /// errors over the whole grid
    #[arg(long, help_heading = OUTPUT, conflicts_with = "resume")]
    pub(crate) no_hash: bool,

    /// Draw both slices, measured and fitted, to <name>.svg
    #[arg(long, help_heading = OUTPUT, requires = "output")]
    pub(crate) picture: bool,

    /// Skip materials whose document is there, made by this version with the
    /// same options from a file with the same hash
    #[arg(long, help_heading = BATCH, requires = "output")]
    pub(crate) resume: bool,

    /// Fit every N-th input only, starting with the I-th (from 1); `brdfit
    /// merge` joins the summaries
    #[arg(long, value_name = "I/N", help_heading = BATCH, requires = "output")]
    pub(crate) shard: Option<String>,

    /// Take NaN and infinite values for cells without a measurement instead
    /// of refusing the file
    #[arg(long, help_heading = BATCH)]
    pub(crate) accept_non_finite: bool,

    /// Where in its cell a sample lies [default: edge]
    #[arg(long, value_name = "WHERE", help_heading = MODEL)]
    pub(crate) sample_position: Option<PositionArg>,

    /// What both steps minimise [default: log1p-cos]
    #[arg(long, value_name = "LOSS", help_heading = MODEL)]
    pub(crate) loss: Option<LossArg>,

    /// What the Fresnel term must satisfy [default: physical, 0 <= F <= 1];
    /// paper is the preset of the published procedure: loss l2, constraint
    /// free, analytic anchor, solver lm, theta_d up to 70 degrees
    #[arg(long, value_name = "WHAT", help_heading = MODEL)]
    pub(crate) constraint: Option<ConstraintArg>,

    /// One distribution (alpha, p) for R, G and B instead of three
    #[arg(long, help_heading = MODEL)]
    pub(crate) joint: bool,

    /// Height of the peak in step 2: as measured or as fitted by step 1
    /// [default: peak]
    #[arg(long, value_name = "WHAT", help_heading = MODEL)]
    pub(crate) anchor: Option<AnchorArg>,

    /// How step 2 is solved [default: convex]
    #[arg(long, value_name = "HOW", help_heading = SOLVER)]
    pub(crate) step2_solver: Option<SolverArg>,

    /// Largest theta_h in step 1, degrees [default: 75]
    #[arg(long, value_name = "DEG", help_heading = SOLVER, allow_negative_numbers = true)]
    pub(crate) cutoff_theta_h: Option<f64>,

    /// Largest theta_d in step 2, degrees [default: 75]
    #[arg(long, value_name = "DEG", help_heading = SOLVER, allow_negative_numbers = true)]
    pub(crate) cutoff_theta_d: Option<f64>,

    /// A start of step 1, may be repeated; the best result wins
    /// [default: 1e-4,0.4 3e-3,0.4 0.1,0.4 0.9,0.1 1e-5,0.4]
    #[arg(long, value_name = "ALPHA,P", help_heading = SOLVER, value_parser = start, allow_hyphen_values = true)]
    pub(crate) start: Vec<[f64; 2]>,

    /// Limit of iterations of each search and each finish [default: 200]
    #[arg(long, value_name = "N", help_heading = SOLVER)]
    pub(crate) max_iterations: Option<u64>,
}

const OUTPUT: &str = "Output";
const BATCH: &str = "Batch";
const MODEL: &str = "Model";
const SOLVER: &str = "Solver";

const FIT_EXAMPLES: &str = "\
Examples:
  brdfit fit brdfs -o fits                     a folder, one JSON each
  brdfit fit brdfs -o fits --resume            go on where a run was stopped
  brdfit fit gold.binary --picture -o fits     one file, with a picture
  brdfit fit gold.binary | jq .channels[0]     one file, to standard output
  brdfit fit @todo.txt -o fits --shard 2/8     the second of eight parts
  brdfit fit brdfs -o fits --constraint paper  the published procedure
A bad file is reported, recorded in the summary, and the rest is fitted.";

/// Options of `brdfit info`.
#[derive(Debug, Args)]
pub(crate) struct InfoArgs {
    /// MERL files
    #[arg(value_name = "FILE", required = true)]
    pub(crate) files: Vec<PathBuf>,

    /// Text for people, or JSON: a list with one entry per file
    #[arg(long, value_name = "FORMAT", default_value = "text")]
    pub(crate) format: Format,

    /// Where in its cell a sample lies
    #[arg(long, value_name = "WHERE", default_value = "edge")]
    pub(crate) sample_position: PositionArg,
}

const INFO_EXAMPLES: &str = "\
Examples:
  brdfit info gold.binary
  brdfit info brdfs/*.binary --format json | jq '.[].zero_peaks'
A file that cannot be used is one line on standard error, and the exit code.";

/// Options of `brdfit synth`.
#[derive(Debug, Args)]
pub(crate) struct SynthArgs {
    /// A result of `brdfit fit` (or any JSON with the parameters of three
    /// channels in the same place), or the name of an embedded material
    #[arg(value_name = "RESULT.json|NAME")]
    pub(crate) source: PathBuf,

    /// The MERL file to write
    #[arg(short, long, value_name = "FILE.binary")]
    pub(crate) output: PathBuf,

    /// Where in its cell a sample lies [default: as in the result, or edge]
    #[arg(long, value_name = "WHERE")]
    pub(crate) sample_position: Option<PositionArg>,

    /// Bins of phi_d, 180 or 360 [default: as in the result, or 180]
    #[arg(long, value_name = "N")]
    pub(crate) phi_bins: Option<u16>,

    /// Multiply each value by exp(S x), x standard normal
    #[arg(long, value_name = "S", default_value_t = 0.0, allow_negative_numbers = true, help_heading = "Noise")]
    pub(crate) noise: f64,

    /// Seed of the noise; the same seed gives the same file
    #[arg(long, value_name = "N", default_value_t = 0, requires = "noise", help_heading = "Noise")]
    pub(crate) seed: u64,
}

/// Options of `brdfit merge`.
#[derive(Debug, Args)]
pub(crate) struct MergeArgs {
    /// Folder with summary.1-of-N.json .. summary.N-of-N.json
    #[arg(value_name = "DIR")]
    pub(crate) folder: PathBuf,
}

const MERGE_EXAMPLES: &str = "\
Examples:
  for i in 1 2 3; do brdfit fit brdfs -o fits --shard $i/3 & done; wait
  brdfit merge fits                  writes fits/summary.json and .csv";

/// Options of `brdfit schema`.
#[derive(Debug, Args)]
pub(crate) struct SchemaArgs {
    /// Which document
    #[arg(value_name = "DOCUMENT")]
    pub(crate) document: SchemaName,
}

const SCHEMA_EXAMPLES: &str = "\
Example:
  brdfit schema fit > fit.schema.json";

/// Options of `brdfit completions`.
#[derive(Debug, Args)]
pub(crate) struct CompletionsArgs {
    /// The shell
    #[arg(value_name = "SHELL")]
    pub(crate) shell: Shell,
}

const COMPLETIONS_EXAMPLES: &str = "\
Examples:
  brdfit completions bash > ~/.local/share/bash-completion/completions/brdfit
  brdfit completions fish > ~/.config/fish/completions/brdfit.fish";

/// Options of `brdfit man`.
#[derive(Debug, Args)]
pub(crate) struct ManArgs {
    /// The command, or nothing for the program as a whole
    #[arg(value_name = "COMMAND")]
    pub(crate) command: Option<String>,
}

const MAN_EXAMPLES: &str = "\
Examples:
  brdfit man | man -l -
  brdfit man fit > ~/.local/share/man/man1/brdfit-fit.1";

/// The wish for colour in arguments that have not been parsed yet, or cannot be.
pub(crate) fn color_of(arguments: impl Iterator<Item = OsString>) -> ColorChoice {
    let mut wish = ColorChoice::Auto;
    let mut follows = false;
    for argument in arguments.filter_map(|argument| argument.into_string().ok()).take_while(|text| text != "--") {
        let value = if follows { Some(argument.as_str()) } else { argument.strip_prefix("--color=") };
        if let Some(value) = value {
            wish = ColorChoice::from_str(value, false).unwrap_or(wish);
        }
        follows = !follows && argument == "--color";
    }
    wish
}

/// Reads `ALPHA,P`.
fn start(text: &str) -> Result<[f64; 2], String> {
    let wrong = || "a start is two numbers, for instance 1e-3,0.4".to_owned();
    let (alpha, p) = text.split_once(',').ok_or_else(wrong)?;
    let number = |text: &str| text.trim().parse::<f64>().map_err(|_| wrong());
    Ok([number(alpha)?, number(p)?])
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::CommandFactory;

    #[test]
    fn the_command_line_is_consistent() {
        Cli::command().debug_assert();
    }

    #[test]
    fn the_wish_for_colour_is_found_before_parsing() {
        let wish = |line: &str| color_of(line.split(' ').map(OsString::from));
        assert_eq!(wish("fit --colour"), ColorChoice::Auto);
        assert_eq!(wish("fit --color never --wrong"), ColorChoice::Never);
        assert_eq!(wish("--color=always fit"), ColorChoice::Always);
        assert_eq!(wish("fit -- --color=always"), ColorChoice::Auto);
    }

    #[test]
    fn the_help_names_the_default_starts() {
        let command = Cli::command();
        let fit = command.find_subcommand("fit").unwrap();
        let help =
            fit.get_arguments().find(|argument| argument.get_id() == "start").unwrap().get_help().unwrap().to_string();
        let (_, listed) = help.trim_end_matches(']').split_once("[default: ").unwrap();
        let listed: Vec<[f64; 2]> = listed.split_whitespace().map(|pair| start(pair).unwrap()).collect();
        assert_eq!(listed, brdfit_fit::FitOptions::default().starts);
    }

    #[test]
    fn a_start_is_two_numbers() {
        assert_eq!(start("1e-3, 0.4").unwrap(), [1e-3, 0.4]);
        for bad in ["", "1", "1;2", "a,b", "1,2,3", ","] {
            assert!(start(bad).is_err(), "{bad}");
        }
    }
}
