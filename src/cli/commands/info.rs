//! `brdfit info`: reports on measured files.

use std::path::Path;

use brdfit_measured::{Described, HealthChecks, Info, MeasurementError, SamplePosition};

use crate::args::measured::InfoArgs;
use crate::args::value_enums::Format;
use crate::jobs::batch;
use crate::results::json;
use crate::results::output;
use crate::terminal::console::Console;
use crate::terminal::exit_code::{Outcome, Problem};
use crate::terminal::info_text;

pub(crate) fn run(args: &InfoArgs, console: &Console) -> anyhow::Result<Outcome> {
    let checks = HealthChecks::default();
    let position = args.sample_position.map(Into::into);
    let progress = console.progress(args.files.len(), "reading");
    let reports = batch::each(&args.files, usize::MAX, |file| {
        let report = report(file, position, &checks);
        progress.tick();
        Ok::<_, Problem>(report)
    })?;
    drop(progress);

    let mut outcome = Outcome::Done;
    let mut described = Vec::new();
    for Report { info, error } in reports {
        if args.format == Format::Text
            && let Some(info) = &info
        {
            let gap = if described.is_empty() { "" } else { "\n" };
            output::print(&format!("{gap}{}", info_text::render(info, console)))?;
        }
        described.extend(info);
        if let Some(error) = error {
            let error = error.into();
            console.error(&error);
            outcome = outcome.max(Outcome::of(&error));
        }
    }
    if args.format == Format::Json {
        output::deliver(None, &json::to_vec(&described))?;
    }
    Ok(outcome)
}

/// The report on one file. A file with invalid values is reported and rejected.
struct Report {
    info: Option<Info>,
    error: Option<MeasurementError>,
}

fn report(path: &Path, position: Option<SamplePosition>, checks: &HealthChecks) -> Report {
    match brdfit_measured::open(path, position) {
        Err(error) => Report { info: None, error: Some(error) },
        Ok(measurement) => {
            let Described { info, fault } = measurement.info(checks);
            Report { info: Some(info), error: fault }
        }
    }
}
