//! `brdfit completions`: completion scripts for shells.

use clap::CommandFactory;

use crate::args::cli::Cli;
use crate::args::texts::CompletionsArgs;
use crate::results::output;
use crate::terminal::exit_code::Outcome;

pub(crate) fn run(args: &CompletionsArgs) -> anyhow::Result<Outcome> {
    let mut script = Vec::new();
    clap_complete::generate(args.shell, &mut Cli::command(), "brdfit", &mut script);
    output::deliver(None, &script)?;
    Ok(Outcome::Done)
}
