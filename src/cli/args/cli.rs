//! The program and its subcommands.

use std::ffi::OsString;

use clap::{ArgAction, ColorChoice, Parser, Subcommand, ValueEnum};

use crate::args::atlas::{self, AtlasArgs};
use crate::args::compare::{self, CompareArgs};
use crate::args::demo::{self, DemoArgs};
use crate::args::fit::{self, FitArgs, MergeArgs};
use crate::args::headings::GLOBAL;
use crate::args::measured::{self, InfoArgs, SynthArgs};
use crate::args::render::{self, RenderArgs};
use crate::args::texts::{self, CompletionsArgs, ExportArgs, ManArgs, SchemaArgs};

/// Fit microfacet models to measured isotropic BRDFs (MERL, RGL), precompute
/// bandwidth atlases and render adaptively.
#[derive(Debug, Parser)]
#[command(name = "brdfit", version, max_term_width = 80, after_help = AFTER_HELP, disable_help_subcommand = true)]
#[command(subcommand_required = true, arg_required_else_help = false)]
pub(crate) struct Cli {
    /// Number of threads [default: one per core]; does not affect results
    #[arg(long, value_name = "N", global = true, help_heading = GLOBAL, value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub(crate) threads: Option<u16>,

    /// Print only errors
    #[arg(long, short, global = true, help_heading = GLOBAL, conflicts_with = "verbose")]
    pub(crate) quiet: bool,

    /// Verbose output; -vv for debug
    #[arg(long, short, global = true, help_heading = GLOBAL, action = ArgAction::Count)]
    pub(crate) verbose: u8,

    /// When to use colour; respects NO_COLOR
    #[arg(long, value_name = "WHEN", global = true, help_heading = GLOBAL, default_value = "auto")]
    pub(crate) color: ColorChoice,

    #[command(subcommand)]
    pub(crate) command: Command,
}

const AFTER_HELP: &str = "\
Exit codes:
  0    success
  1    invalid usage
  2    a file could not be read or written
  3    an input is invalid
  4    a computation failed
  7    a comparison found a difference beyond its tolerance
  130  interrupted (Ctrl-C); no partial file is left
  A batch continues after an invalid input; its exit code is the largest one.

Examples:
  brdfit demo -o out                 fit an embedded material, draw its slices
  brdfit fit brdfs -o fits           fit every measured file in the folder brdfs
  brdfit info brdfs/*.binary         check files before fitting them
  brdfit atlas fits -o atlases       a bandwidth atlas of each fit
  brdfit render scene.json -o scene.exr --png scene.png
                                     render materials adaptively
  brdfit synth fits/x.json -o x.binary
                                     write a fit as a MERL file
Run `brdfit COMMAND --help` for the options and examples of a command.";

#[derive(Debug, Subcommand)]
pub(crate) enum Command {
    /// Fit measured files: one JSON document per material and a summary
    #[command(after_help = fit::EXAMPLES)]
    Fit(Box<FitArgs>),
    /// Precompute bandwidth atlases of fits and measurements
    #[command(after_help = atlas::examples())]
    Atlas(Box<AtlasArgs>),
    /// Render a scene of fitted and measured materials adaptively
    #[command(after_help = render::EXAMPLES)]
    Render(Box<RenderArgs>),
    /// Print shader functions that sample a bandwidth atlas
    #[command(after_help = texts::EXPORT_EXAMPLES)]
    Export(ExportArgs),
    /// Report on measured files: validity, range, albedo, hash
    #[command(after_help = measured::INFO_EXAMPLES)]
    Info(InfoArgs),
    /// Write a fit or an embedded material as a MERL file
    #[command(after_help = measured::synth_examples())]
    Synth(SynthArgs),
    /// Compare fits with reference fits within tolerances
    #[command(after_help = compare::EXAMPLES)]
    Compare(CompareArgs),
    /// Join the summaries of a batch that was fitted in shards
    #[command(after_help = fit::MERGE_EXAMPLES)]
    Merge(MergeArgs),
    /// Print the JSON Schema of a document
    #[command(after_help = texts::SCHEMA_EXAMPLES)]
    Schema(SchemaArgs),
    /// Run the whole pipeline on an embedded material
    #[command(after_help = demo::EXAMPLES)]
    Demo(DemoArgs),
    /// Print a completion script for a shell
    #[command(after_help = texts::COMPLETIONS_EXAMPLES)]
    Completions(CompletionsArgs),
    /// Print the manual page of the program or of a command
    #[command(after_help = texts::MAN_EXAMPLES)]
    Man(ManArgs),
}

/// The value of `--color` in arguments that have not been parsed yet, or cannot be.
pub(crate) fn color_of(arguments: impl Iterator<Item = OsString>) -> ColorChoice {
    let mut choice = ColorChoice::Auto;
    let mut follows = false;
    for argument in arguments.filter_map(|argument| argument.into_string().ok()).take_while(|text| text != "--") {
        let value = if follows { Some(argument.as_str()) } else { argument.strip_prefix("--color=") };
        if let Some(value) = value {
            choice = ColorChoice::from_str(value, false).unwrap_or(choice);
        }
        follows = !follows && argument == "--color";
    }
    choice
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
    fn the_choice_of_colour_is_found_before_parsing() {
        let wish = |line: &str| color_of(line.split(' ').map(OsString::from));
        assert_eq!(wish("fit --colour"), ColorChoice::Auto);
        assert_eq!(wish("fit --color never --wrong"), ColorChoice::Never);
        assert_eq!(wish("--color=always fit"), ColorChoice::Always);
        assert_eq!(wish("fit -- --color=always"), ColorChoice::Auto);
    }
}
