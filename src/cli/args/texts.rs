//! Command-line arguments of the commands that print a text: `brdfit export`, `schema`, `completions` and `man`.

use std::path::PathBuf;

use clap::Args;
use clap::builder::{PossibleValue, PossibleValuesParser};
use clap_complete::Shell;

use crate::args::value_enums::SchemaName;
use crate::exporters::formats::{FORMATS, Format};

/// Options of `brdfit export`.
#[derive(Debug, Args)]
pub(crate) struct ExportArgs {
    /// Shading language
    #[arg(value_name = "LANGUAGE", value_parser = PossibleValuesParser::new(FORMATS.iter().map(possible_value)))]
    pub(crate) language: String,

    /// Output file [default: standard output]
    #[arg(short, long, value_name = "FILE")]
    pub(crate) output: Option<PathBuf>,
}

fn possible_value(format: &Format) -> PossibleValue {
    PossibleValue::new(format.name).help(format.help)
}

pub(super) const EXPORT_EXAMPLES: &str = "\
Examples:
  brdfit export wgsl -o bandwidth_atlas.wgsl
  cat <(brdfit export glsl) shade.frag > whole.frag
The header comment of the text explains how to bind the texture.";

/// Options of `brdfit schema`.
#[derive(Debug, Args)]
pub(crate) struct SchemaArgs {
    /// Document
    #[arg(value_name = "DOCUMENT")]
    pub(crate) document: SchemaName,
}

pub(super) const SCHEMA_EXAMPLES: &str = "\
Example:
  brdfit schema fit > fit.schema.json";

/// Options of `brdfit completions`.
#[derive(Debug, Args)]
pub(crate) struct CompletionsArgs {
    /// Shell
    #[arg(value_name = "SHELL")]
    pub(crate) shell: Shell,
}

pub(super) const COMPLETIONS_EXAMPLES: &str = "\
Examples:
  brdfit completions bash > ~/.local/share/bash-completion/completions/brdfit
  brdfit completions fish > ~/.config/fish/completions/brdfit.fish";

/// Options of `brdfit man`.
#[derive(Debug, Args)]
pub(crate) struct ManArgs {
    /// Subcommand [default: the whole program]
    #[arg(value_name = "COMMAND")]
    pub(crate) command: Option<String>,
}

pub(super) const MAN_EXAMPLES: &str = "\
Examples:
  brdfit man | man -l -
  brdfit man fit > ~/.local/share/man/man1/brdfit-fit.1";
