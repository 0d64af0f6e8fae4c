//! `brdfit export`: the functions that sample an atlas, as text for a shader.

use crate::args::ExportArgs;
use crate::results::output;
use crate::terminal::exit_code::Outcome;

pub(crate) fn run(args: &ExportArgs) -> anyhow::Result<Outcome> {
    let text = brdfit_bandwidth::shader(args.language.into());
    output::deliver(args.output.as_deref(), text.as_bytes())?;
    Ok(Outcome::Done)
}
