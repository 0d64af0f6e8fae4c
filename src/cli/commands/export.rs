//! `brdfit export`: source text for another program.

use crate::args::texts::ExportArgs;
use crate::exporters::formats;
use crate::results::output;
use crate::terminal::exit_code::{Outcome, Problem};

pub(crate) fn run(args: &ExportArgs) -> anyhow::Result<Outcome> {
    let format = formats::find(&args.language)
        .ok_or_else(|| Problem::usage(format!("{}: no such format; see brdfit export --help", args.language)))?;
    output::deliver(args.output.as_deref(), &format.exporter.export())?;
    Ok(Outcome::Done)
}
