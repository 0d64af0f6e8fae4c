//! `brdfit man`: manual pages.

use clap::CommandFactory;

use crate::args::cli::Cli;
use crate::args::texts::ManArgs;
use crate::results::output;
use crate::terminal::exit_code::{Outcome, Problem};

pub(crate) fn run(args: &ManArgs) -> anyhow::Result<Outcome> {
    let mut program = Cli::command();
    program.build();
    let command = match &args.command {
        None => program,
        Some(name) => program.find_subcommand(name).cloned().ok_or_else(|| {
            let names: Vec<&str> = program.get_subcommands().map(clap::Command::get_name).collect();
            Problem::usage(format!("{name}: no such command; choose one of {}", names.join(", ")))
        })?,
    };
    let title = match &args.command {
        None => "brdfit".to_owned(),
        Some(name) => format!("brdfit-{name}"),
    };
    let mut page = Vec::new();
    clap_mangen::Man::new(command).title(title).render(&mut page)?;
    output::deliver(None, &page)?;
    Ok(Outcome::Done)
}
