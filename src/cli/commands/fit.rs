//! `brdfit fit`: fits a batch of measured files; writes results and a summary.

use brdfit_brdf::MaterialParameters;
use brdfit_fit::document::{Failure, FitDocument, SummaryRow};
use tracing::info;

use crate::args::fit::FitArgs;
use crate::jobs::atlas_job::{AtlasJob, AtlasMaker};
use crate::jobs::batch;
use crate::jobs::fit_job::Fitter;
use crate::jobs::fit_plan::{FitPlan, Target};
use crate::jobs::inputs::InputFile;
use crate::jobs::material_source::Origin;
use crate::report::slices;
use crate::results::documents;
use crate::results::folder::{ResultFile, ResultFolder};
use crate::results::json;
use crate::results::output;
use crate::results::summary;
use crate::terminal::console::Console;
use crate::terminal::exit_code::{Outcome, Problem};

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
pub(crate) fn fill(folder: &ResultFolder, plan: &FitPlan, console: &Console) -> anyhow::Result<Outcome> {
    folder.create()?;
    let fitter = Fitter::new(plan.job.clone());
    let atlases = plan.atlas.then(|| AtlasMaker::new(AtlasJob::default()));
    let label = |input: &InputFile| input.path.display().to_string();
    let work = |input: &InputFile| fit(input, &fitter, atlases.as_ref(), folder, plan);
    let results = batch::each_on_its_own(&plan.inputs, usize::MAX, "fitting", console, label, work)?;

    let mut summary = summary::new(plan.job.model, plan.job.recorded());
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
    let fitted = format!("{} fitted", summary.materials.len());
    console.note(&format!("{}: {}", batch::tally(&fitted, kept, summary.failures.len()), path.display()));
    Ok(outcome)
}

/// A material that is done.
struct Material {
    row: SummaryRow,
    /// Whether an existing document was kept.
    kept: bool,
}

/// Fits one input. The outer error ends the batch: if one result cannot be written, the next cannot either.
fn fit(
    input: &InputFile,
    fitter: &Fitter,
    atlases: Option<&AtlasMaker>,
    folder: &ResultFolder,
    plan: &FitPlan,
) -> Result<anyhow::Result<Material>, Problem> {
    let path = folder.file(ResultFile::Fit, &input.name);
    let opened = match fitter.open(input) {
        Ok(opened) => opened,
        Err(error) => return Ok(Err(error.into())),
    };
    let differs = |document: &FitDocument| fitter.differs(document, &opened);
    let there = if plan.resume { folder.kept(&input.name, differs) } else { None };
    let kept = there.is_some();
    let document = match there {
        Some(document) => document,
        None => match fitter.fit(opened) {
            Ok(document) => document,
            Err(error) => return Ok(Err(error.into())),
        },
    };
    draw(&document, folder, plan)?;
    let bytes = json::to_vec(&document);
    if !kept {
        output::write_recoverable(&path, &bytes)?;
        info!(file = %path.display(), "written");
    }
    let row = SummaryRow::from(&document);
    if let Some(maker) = atlases
        && let Err(error) = add_atlas(&row.name, &bytes, maker, folder, plan)?
    {
        return Ok(Err(error.into()));
    }
    Ok(Ok(Material { row, kept }))
}

/// Makes the atlas of a fit, as `brdfit atlas` does of its document, `bytes`. The errors are those of [`fit`].
fn add_atlas(
    name: &str,
    bytes: &[u8],
    maker: &AtlasMaker,
    folder: &ResultFolder,
    plan: &FitPlan,
) -> Result<Result<(), Problem>, Problem> {
    let origin = Origin::fit(name, Some(documents::sha256(bytes)));
    if plan.resume && maker.kept(folder, &origin).is_some() {
        return Ok(Ok(()));
    }
    let material = MaterialParameters::read(bytes).expect("the document of a fit holds a material").brdf();
    match maker.make(material.as_ref(), origin, name) {
        Ok(made) => made.write(folder).map(|_| Ok(())),
        Err(error) => Ok(Err(error)),
    }
}

fn draw(document: &FitDocument, folder: &ResultFolder, plan: &FitPlan) -> Result<(), Problem> {
    if plan.picture {
        let path = folder.file(ResultFile::Slices, &document.input.name);
        output::write_recoverable(&path, slices::draw(document).as_bytes())?;
    }
    Ok(())
}
