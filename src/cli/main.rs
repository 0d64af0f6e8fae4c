//! `brdfit`: fits models to measured isotropic BRDFs, computes bandwidth atlases and renders. Arguments (`args`) are validated
//! into plans (`jobs`); each subcommand is one file of `commands`. Only this crate knows colour, progress and exit codes.
#![forbid(unsafe_code)]
// doc comments of arguments are help text, where <name> is a name
#![allow(rustdoc::invalid_html_tags)]

mod args;
mod commands;
mod exporters;
mod jobs;
mod report;
mod results;
mod terminal;

use std::process::ExitCode;

use args::cli::{Cli, Command};
use clap::{CommandFactory, FromArgMatches};
use commands::{atlas, compare, completions, demo, export, fit, info, man, merge, render, schema, synth};
use results::output;
use terminal::console::Console;
use terminal::diagnostics;
use terminal::exit_code::Outcome;

fn main() -> ExitCode {
    let cli = match parse() {
        Ok(cli) => cli,
        Err(error) => return tell(&error).into(),
    };
    let console = Console::new(cli.quiet, cli.color);
    let outcome = run(&cli, &console).unwrap_or_else(|error| {
        console.error(&error);
        Outcome::of(&error)
    });
    outcome.into()
}

fn run(cli: &Cli, console: &Console) -> anyhow::Result<Outcome> {
    ctrlc::set_handler(|| output::end(Outcome::INTERRUPTED))?;
    diagnostics::start(cli.verbose, console);
    rayon::ThreadPoolBuilder::new().num_threads(cli.threads.unwrap_or(0).into()).build_global()?;
    match &cli.command {
        Command::Fit(args) => fit::run(args, console),
        Command::Atlas(args) => atlas::run(args, console),
        Command::Render(args) => render::run(args, console),
        Command::Export(args) => export::run(args),
        Command::Info(args) => info::run(args, console),
        Command::Synth(args) => synth::run(args, console),
        Command::Compare(args) => compare::run(args, console),
        Command::Merge(args) => merge::run(args, console),
        Command::Schema(args) => schema::run(args),
        Command::Demo(args) => demo::run(args, console),
        Command::Completions(args) => completions::run(args),
        Command::Man(args) => man::run(args),
    }
}

/// Reads the command line. `--color` counts for the help and the errors of this step too.
fn parse() -> Result<Cli, clap::Error> {
    let color = args::cli::color_of(std::env::args_os().skip(1));
    Cli::from_arg_matches(&Cli::command().color(color).try_get_matches()?)
}

/// Prints help, version, or what is wrong with the command line.
fn tell(message: &clap::Error) -> Outcome {
    match (message.print(), message.use_stderr()) {
        (_, true) => Outcome::Usage,
        (Err(error), _) if error.kind() != std::io::ErrorKind::BrokenPipe => Outcome::InputOutput,
        _ => Outcome::Done,
    }
}
