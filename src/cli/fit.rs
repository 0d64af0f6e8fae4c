//! `brdfit fit`: a batch of measured files to documents and a summary.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;

use brdfit_fit::document::{Failure, FitDocument, SummaryRow};
use tracing::info;

use crate::args::FitArgs;
use crate::batch;
use crate::console::Console;
use crate::inputs::InputFile;
use crate::json;
use crate::material::Fitter;
use crate::outcome::{Outcome, Problem};
use crate::output;
use crate::picture;
use crate::plan::{FitPlan, Target};
use crate::resume;
use crate::summary;

pub(crate) fn run(args: &FitArgs, console: &Console) -> anyhow::Result<Outcome> {
    let plan = FitPlan::new(args)?;
    match &plan.target {
        Target::StandardOutput => print(&plan),
        Target::Folder(folder) => fill(folder, &plan, console),
    }
}

/// Fits the only input and prints its document.
fn print(plan: &FitPlan) -> anyhow::Result<Outcome> {
    let fitter = Fitter::new(plan.job.clone());
    for input in &plan.inputs {
        let opened = fitter.open(input)?;
        output::deliver(None, &json::to_vec(&fitter.fit(opened)?))?;
    }
    Ok(Outcome::Done)
}

/// Fits all inputs into a folder.
pub(crate) fn fill(folder: &Path, plan: &FitPlan, console: &Console) -> anyhow::Result<Outcome> {
    output::folder(folder)?;
    let fitter = Fitter::new(plan.job.clone());
    let progress = console.progress(plan.inputs.len(), "fitting");
    let results = batch::each(&plan.inputs, |input| {
        let result = survive(input, || fit(input, &fitter, folder, plan));
        if let Ok(Err(error)) = &result {
            progress.suspend(|| console.error(error));
        }
        progress.tick();
        result
    })?;
    drop(progress);

    let mut summary = summary::new(plan.job.options.clone());
    let (mut outcome, mut kept) = (Outcome::Done, 0);
    for (input, result) in plan.inputs.iter().zip(results) {
        match result {
            Ok(material) => {
                kept += usize::from(material.kept);
                summary.materials.push(material.row);
            }
            Err(error) => {
                let asked = Outcome::of(&error);
                outcome = outcome.max(asked);
                summary.failures.push(Failure {
                    input: input.path.display().to_string(),
                    message: format!("{error:#}"),
                    exit_code: asked.code(),
                });
            }
        }
    }
    let path = summary::write(folder, plan.shard, &summary)?;
    let skipped = if kept > 0 { format!(" ({kept} were there already)") } else { String::new() };
    let failed =
        if summary.failures.is_empty() { String::new() } else { format!(", {} failed", summary.failures.len()) };
    console.note(&format!("{} fitted{skipped}{failed}: {}", summary.materials.len(), path.display()));
    Ok(outcome)
}

/// A material that is done.
struct Material {
    row: SummaryRow,
    /// Whether its document was there already.
    kept: bool,
}

/// Fits one input. The outer error ends the batch: if one result cannot be written, the next cannot either.
fn fit(input: &InputFile, fitter: &Fitter, folder: &Path, plan: &FitPlan) -> Result<anyhow::Result<Material>, Problem> {
    let path = folder.join(format!("{}.json", input.name));
    let opened = match fitter.open(input) {
        Ok(opened) => opened,
        Err(error) => return Ok(Err(error.into())),
    };
    if plan.resume
        && let Some(document) = resume::reusable(&path, opened.input(), fitter.job())
    {
        info!(file = %path.display(), "kept");
        draw(&document, folder, plan)?;
        return Ok(Ok(Material { row: SummaryRow::from(&document), kept: true }));
    }
    let document = match fitter.fit(opened) {
        Ok(document) => document,
        Err(error) => return Ok(Err(error.into())),
    };
    draw(&document, folder, plan)?;
    output::write_recoverable(&path, &json::to_vec(&document))?;
    info!(file = %path.display(), "written");
    Ok(Ok(Material { row: SummaryRow::from(&document), kept: false }))
}

fn draw(document: &FitDocument, folder: &Path, plan: &FitPlan) -> Result<(), Problem> {
    if plan.picture {
        let path = folder.join(format!("{}.svg", document.input.name));
        output::write_recoverable(&path, picture::draw(document).as_bytes())?;
    }
    Ok(())
}

/// Turns a panic, which is a mistake of the program, into a failure of the one material.
fn survive<T>(
    input: &InputFile,
    work: impl FnOnce() -> Result<anyhow::Result<T>, Problem>,
) -> Result<anyhow::Result<T>, Problem> {
    catch_unwind(AssertUnwindSafe(work)).unwrap_or_else(|_| {
        let message = "the program made a mistake (see above); please report it with this file";
        Ok(Err(Problem::computation(format!("{}: {message}", input.path.display())).into()))
    })
}
