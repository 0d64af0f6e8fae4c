//! `brdfit schema`: the JSON Schema (draft 2020-12) of each document, made from the types that write it.

use brdfit_fit::document::{FitDocument, SummaryDocument};
use brdfit_measured::Info;
use brdfit_renderer::SceneDocument;
use schemars::Schema;
use schemars::generate::SchemaSettings;

use crate::args::texts::SchemaArgs;
use crate::args::value_enums::SchemaName;
use crate::jobs::atlas_job::Sidecar;
use crate::jobs::render::stats::RenderDocument;
use crate::results::json;
use crate::results::output;
use crate::terminal::exit_code::Outcome;

pub(crate) fn run(args: &SchemaArgs) -> anyhow::Result<Outcome> {
    output::deliver(None, &json::to_vec(&schema(args.document)))?;
    Ok(Outcome::Done)
}

fn schema(document: SchemaName) -> Schema {
    let generator = SchemaSettings::draft2020_12().for_serialize().into_generator();
    match document {
        SchemaName::Fit => generator.into_root_schema_for::<FitDocument>(),
        SchemaName::Summary => generator.into_root_schema_for::<SummaryDocument>(),
        SchemaName::Atlas => generator.into_root_schema_for::<Sidecar>(),
        SchemaName::Scene => SceneDocument::schema(),
        SchemaName::Render => generator.into_root_schema_for::<RenderDocument>(),
        SchemaName::Info => generator.into_root_schema_for::<Vec<Info>>(),
    }
}
