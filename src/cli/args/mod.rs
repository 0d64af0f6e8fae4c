//! The command line as it is typed. What it means is decided by `plan` and by the subcommands.

pub(crate) mod atlas;
pub(crate) mod compare;
pub(crate) mod demo;
pub(crate) mod embedded_materials;
pub(crate) mod fit;
pub(crate) mod render;
pub(crate) mod value_enums;

use std::ffi::OsString;
use std::path::PathBuf;

use clap::{ArgAction, Args, ColorChoice, Parser, Subcommand, ValueEnum};
use clap_complete::Shell;

pub(crate) use crate::args::value_enums::{Format, SchemaName};
use crate::args::value_enums::{LanguageArg, PositionArg};
pub(crate) use atlas::AtlasArgs;
pub(crate) use compare::CompareArgs;
pub(crate) use demo::DemoArgs;
pub(crate) use fit::FitArgs;
pub(crate) use render::RenderArgs;

/// Fit measured isotropic BRDFs (MERL, RGL) with the SGD microfacet model.
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
/// Headings that commands with many inputs share.
const OUTPUT: &str = "Output";
const BATCH: &str = "Batch";

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
  brdfit fit brdfs -o fits           fit every measured file in the folder brdfs
  brdfit info brdfs/*.binary         look at files before trusting them
  brdfit atlas fits -o atlases       the bandwidth of each lobe, for a GPU
  brdfit render scene.json -o scene.exr --png scene.png
                                     look at materials, shaded where it matters
  brdfit synth fits/x.json -o x.binary
                                     turn a fit back into a MERL file
`brdfit COMMAND --help` has the options and examples of each command.";

#[derive(Debug, Subcommand)]
pub(crate) enum Command {
    /// Fit measured files: one JSON document per material and a summary
    #[command(after_help = fit::EXAMPLES)]
    Fit(Box<FitArgs>),
    /// Precompute the angular bandwidth of every lobe, as a texture
    #[command(after_help = atlas::examples())]
    Atlas(Box<AtlasArgs>),
    /// Render a scene of fitted and measured materials adaptively
    #[command(after_help = render::EXAMPLES)]
    Render(Box<RenderArgs>),
    /// Print the functions that sample an atlas, for a shader
    #[command(after_help = EXPORT_EXAMPLES)]
    Export(ExportArgs),
    /// Show the state of measured files: validity, range, albedo, hash
    #[command(after_help = INFO_EXAMPLES)]
    Info(InfoArgs),
    /// Make a MERL file from a fit or from an embedded material
    #[command(after_help = synth_examples())]
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
    /// Try everything on an embedded material: fit, atlas, pictures
    #[command(after_help = demo::EXAMPLES)]
    Demo(DemoArgs),
    /// Print a completion script for a shell
    #[command(after_help = COMPLETIONS_EXAMPLES)]
    Completions(CompletionsArgs),
    /// Print the manual page of the program or of a command
    #[command(after_help = MAN_EXAMPLES)]
    Man(ManArgs),
}

/// Options of `brdfit export`.
#[derive(Debug, Args)]
pub(crate) struct ExportArgs {
    /// The shading language
    #[arg(value_name = "LANGUAGE")]
    pub(crate) language: LanguageArg,

    /// The file to write [default: standard output]
    #[arg(short, long, value_name = "FILE")]
    pub(crate) output: Option<PathBuf>,
}

const EXPORT_EXAMPLES: &str = "\
Examples:
  brdfit export wgsl -o bandwidth_atlas.wgsl
  cat <(brdfit export glsl) shade.frag > whole.frag
The comment at the head of the text says how to bind the texture.";

/// Options of `brdfit info`.
#[derive(Debug, Args)]
pub(crate) struct InfoArgs {
    /// Measured files: MERL (.binary) and RGL (.bsdf, isotropic, in colours)
    #[arg(value_name = "FILE", required = true)]
    pub(crate) files: Vec<PathBuf>,

    /// Text for people, or JSON: a list with one entry per file
    #[arg(long, value_name = "FORMAT", default_value = "text")]
    pub(crate) format: Format,

    /// Where in its cell a sample lies [default: edge; RGL: always centre]
    #[arg(long, value_name = "WHERE")]
    pub(crate) sample_position: Option<PositionArg>,
}

const INFO_EXAMPLES: &str = "\
Examples:
  brdfit info gold.binary
  brdfit info chm_mint_rgb.bsdf
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

/// What stands below the options in the help.
fn synth_examples() -> String {
    format!("{SYNTH_EXAMPLES}\n\n{}", embedded_materials::list())
}

const SYNTH_EXAMPLES: &str = "\
Examples:
  brdfit synth fits/gold.json -o gold.binary
  brdfit synth gold-metallic-paint -o gold.binary --noise 0.05 --seed 7";

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
}
