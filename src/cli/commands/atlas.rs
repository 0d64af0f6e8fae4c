//! `brdfit atlas`: bandwidth atlases of a batch of materials.

use crate::args::atlas::AtlasArgs;
use crate::args::value_enums::Format;
use crate::jobs::atlas_job::{AtlasMaker, Sidecar};
use crate::jobs::atlas_plan::AtlasPlan;
use crate::jobs::batch;
use crate::jobs::material_source::MaterialInput;
use crate::results::json;
use crate::results::output;
use crate::terminal::console::Console;
use crate::terminal::exit_code::{Outcome, Problem};
use crate::terminal::table::{Align, Table};

/// While one atlas is computed, the material before it is written and the next one is read.
const AT_ONCE: usize = 2;

pub(crate) fn run(args: &AtlasArgs, console: &Console) -> anyhow::Result<Outcome> {
    let plan = AtlasPlan::new(args)?;
    plan.folder.create()?;
    let maker = AtlasMaker::new(plan.job.clone());
    let work = |input: &MaterialInput| make(input, &maker, &plan);
    let results = batch::each_on_its_own(&plan.inputs, AT_ONCE, "atlases", console, MaterialInput::label, work)?;

    let (mut outcome, mut kept, mut failed, mut sidecars) = (Outcome::Done, 0, 0, Vec::new());
    for result in results {
        match result {
            Ok(done) => {
                kept += usize::from(done.kept);
                sidecars.push(done.sidecar);
            }
            Err(error) => {
                failed += 1;
                outcome = outcome.max(Outcome::of(&error));
            }
        }
    }
    match plan.report {
        Some(Format::Json) => output::deliver(None, &json::to_vec(&sidecars))?,
        Some(Format::Text) => output::print(&table(&sidecars).to_string())?,
        None => {}
    }
    let done = if sidecars.len() == 1 { "1 atlas".to_owned() } else { format!("{} atlases", sidecars.len()) };
    console.note(&format!("{}: {}", batch::tally(&done, kept, failed), plan.folder.path().display()));
    Ok(outcome)
}

/// A material that is done.
struct Done {
    sidecar: Sidecar,
    /// Whether an existing result was kept.
    kept: bool,
}

/// Makes the atlas of one input. The outer error ends the batch.
fn make(input: &MaterialInput, maker: &AtlasMaker, plan: &AtlasPlan) -> Result<anyhow::Result<Done>, Problem> {
    let opened = match input.open(plan.reading) {
        Ok(opened) => opened,
        Err(error) => return Ok(Err(error)),
    };
    if plan.resume
        && let Some(sidecar) = maker.kept(&plan.folder, &opened.origin)
    {
        return Ok(Ok(Done { sidecar, kept: true }));
    }
    let origin = opened.origin.clone();
    let made = opened.brdf().and_then(|brdf| Ok(maker.make(brdf.as_ref(), origin, &input.label())?));
    match made {
        Ok(made) => Ok(Ok(Done { sidecar: made.write(&plan.folder)?, kept: false })),
        Err(error) => Ok(Err(error)),
    }
}

/// Range and sharpness of each atlas.
fn table(sidecars: &[Sidecar]) -> Table {
    let mut table = Table::new([
        ("", Align::Left),
        ("lowest/rad", Align::Right),
        ("highest/rad", Align::Right),
        ("256", Align::Right),
        ("512", Align::Right),
        ("1024", Align::Right),
        ("saturated", Align::Right),
    ]);
    for Sidecar { atlas, .. } in sidecars {
        let [low, high] = atlas.range;
        let tiles = atlas.statistics.tiles_per_resolution.iter().map(|count| count.tiles.to_string());
        let saturated = atlas.statistics.saturated_tiles.len().to_string();
        table.row(
            [atlas.source.name.clone(), low.to_string(), high.to_string()].into_iter().chain(tiles).chain([saturated]),
        );
    }
    table
}
