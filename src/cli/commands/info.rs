//! `brdfit info`: the state of measured files.

use std::path::Path;
use std::sync::OnceLock;

use brdfit_measured::{Dimensions, Health, HealthCheck, MerlError, MerlFile, SamplePosition};

use crate::args::measured::InfoArgs;
use crate::args::value_enums::Format;
use crate::jobs::batch;
use crate::results::json;
use crate::results::output;
use crate::terminal::console::Console;
use crate::terminal::exit_code::{Outcome, Problem};
use crate::terminal::info_text;

pub(crate) fn run(args: &InfoArgs, console: &Console) -> anyhow::Result<Outcome> {
    let checks = Checks::new(args.sample_position.into());
    let progress = console.progress(args.files.len(), "reading");
    let reports = batch::each(&args.files, usize::MAX, |file| {
        let report = checks.report(file);
        progress.tick();
        Ok::<_, Problem>(report)
    })?;
    drop(progress);

    let mut outcome = Outcome::Done;
    let mut healthy = Vec::new();
    for Report { health, error } in reports {
        if args.format == Format::Text
            && let Some(health) = &health
        {
            let gap = if healthy.is_empty() { "" } else { "\n" };
            output::print(&format!("{gap}{}", info_text::render(health, console)))?;
        }
        healthy.extend(health);
        if let Some(error) = error {
            let error = error.into();
            console.error(&error);
            outcome = outcome.max(Outcome::of(&error));
        }
    }
    if args.format == Format::Json {
        output::deliver(None, &json::to_vec(&healthy))?;
    }
    Ok(outcome)
}

/// What there is to say about one file. A file with wrong values is described and refused.
struct Report {
    health: Option<Health>,
    error: Option<MerlError>,
}

/// The checks of the two grids, each made when it is first needed.
struct Checks {
    position: SamplePosition,
    half_turn: OnceLock<HealthCheck>,
    full_turn: OnceLock<HealthCheck>,
}

impl Checks {
    fn new(position: SamplePosition) -> Self {
        Self { position, half_turn: OnceLock::new(), full_turn: OnceLock::new() }
    }

    fn report(&self, path: &Path) -> Report {
        match MerlFile::open(path) {
            Err(error) => Report { health: None, error: Some(error) },
            Ok(file) => {
                let scan = file.scan();
                let health = self.of(file.dimensions()).examine(&file, &scan);
                Report { health: Some(health), error: scan.check(path).err() }
            }
        }
    }

    fn of(&self, dimensions: Dimensions) -> &HealthCheck {
        let check = if dimensions.is_folded() { &self.half_turn } else { &self.full_turn };
        check.get_or_init(|| HealthCheck::new(dimensions, self.position))
    }
}
