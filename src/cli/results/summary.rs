//! The summary of a batch, as JSON and as a table for spreadsheets.

use std::ffi::OsStr;
use std::io;
use std::path::{Path, PathBuf};

use brdfit_brdf::ModelName;
use brdfit_fit::RecordedOptions;
use brdfit_fit::document::{Failure, Flag, SCHEMA_VERSION, SummaryDocument, SummaryRow};
use brdfit_measured::CHANNEL_NAMES;

use crate::results::folder::{PROGRAM, ResultFolder};
use crate::results::json;
use crate::results::output;
use crate::results::shard::Shard;
use crate::terminal::exit_code::Problem;

/// The document; this module knows its form, the batch its content.
pub(crate) type Summary = SummaryDocument;

/// An empty summary.
pub(crate) fn new(model: ModelName, options: RecordedOptions) -> Summary {
    Summary {
        schema_version: SCHEMA_VERSION,
        program: PROGRAM.to_owned(),
        options,
        model,
        materials: Vec::new(),
        failures: Vec::new(),
    }
}

/// Sort key of failures: the name that the result would have had, as the materials are.
pub(crate) fn order(failure: &Failure) -> (Option<&OsStr>, &str) {
    (Path::new(&failure.input).file_stem(), &failure.input)
}

/// Writes `summary.json` and `summary.csv`, or the `summary.I-of-N.json` of a shard; returns the path of the JSON file.
///
/// # Errors
/// As [`output::write`].
pub(crate) fn write(folder: &ResultFolder, shard: Option<Shard>, summary: &Summary) -> Result<PathBuf, Problem> {
    if shard.is_none() {
        output::write_with(&folder.summary_table(), |out| write_csv(out, summary))?;
    }
    let path = folder.summary(shard);
    output::write(&path, &json::to_vec(summary))?;
    Ok(path)
}

/// One row per channel: the parameters of the model between the names and what the fit says of them.
fn write_csv(out: &mut dyn io::Write, summary: &Summary) -> io::Result<()> {
    let parameters = summary.model.model().parameters().iter().map(|parameter| parameter.name);
    let tail = ["cost_step1", "cost_step2", "E", "L", "C", "flags", "sha256"];
    let mut table = csv::Writer::from_writer(out);
    // an empty table has no header
    if !summary.materials.is_empty() {
        table.write_record(["name", "channel"].into_iter().chain(parameters).chain(tail)).map_err(io::Error::from)?;
    }
    for material in &summary.materials {
        for (channel, name) in CHANNEL_NAMES.into_iter().enumerate() {
            table.write_record(csv_row(material, channel, name)).map_err(io::Error::from)?;
        }
    }
    table.flush()
}

fn csv_row(material: &SummaryRow, channel: usize, name: &str) -> Vec<String> {
    let errors = material.errors.as_ref().map(|panel| [panel.e[channel], panel.l[channel], panel.c[channel]]);
    let errors = errors.map_or([const { String::new() }; 3], |errors| errors.map(number));
    [material.name.clone(), name.to_owned()]
        .into_iter()
        .chain(material.parameters[channel].iter().map(|(_, value)| number(value)))
        .chain(material.costs[channel].map(number))
        .chain(errors)
        .chain([words(&material.flags[channel]), material.sha256.clone().unwrap_or_default()])
        .collect()
}

/// The shortest decimal that reads back as this number, as in JSON.
fn number(value: f64) -> String {
    serde_json::Number::from_f64(value).map_or_else(|| value.to_string(), |number| number.to_string())
}

/// The flags as the JSON writes them, with spaces between.
fn words(flags: &[Flag]) -> String {
    let word = |flag: &Flag| match serde_json::to_value(flag) {
        Ok(serde_json::Value::String(word)) => word,
        _ => format!("{flag:?}"),
    };
    flags.iter().map(word).collect::<Vec<_>>().join(" ")
}

#[cfg(test)]
mod tests {
    use super::*;
    use brdfit_brdf::{MaterialParameters, SgdParameters};

    fn lines(parameters: &MaterialParameters) -> Vec<String> {
        let material = SummaryRow {
            name: "a, b".to_owned(),
            sha256: None,
            parameters: [0, 1, 2].map(|c| parameters.named(c)),
            costs: [[1e-20, 0.5]; 3],
            errors: None,
            flags: [vec![], vec![Flag::NoPeak, Flag::RhoSWeak], vec![]],
        };
        let model = parameters.model();
        let options = RecordedOptions::new(&brdfit_fit::FitOptions::new(model), Default::default());
        let mut bytes = Vec::new();
        write_csv(&mut bytes, &Summary { materials: vec![material], ..new(model, options) }).unwrap();
        String::from_utf8(bytes).unwrap().lines().map(str::to_owned).collect()
    }

    #[test]
    fn the_table_has_one_row_per_channel() {
        let parameters = SgdParameters { rho_d: 0.25, rho_s: 1e-9, alpha: 0.001, p: 0.5, f0: -0.5, f1: 0.125 };
        let lines = lines(&[parameters; 3].try_into().unwrap());
        assert_eq!(lines.len(), 4);
        assert_eq!(lines[0], "name,channel,rho_d,rho_s,alpha,p,f0,f1,cost_step1,cost_step2,E,L,C,flags,sha256");
        assert_eq!(lines[2], "\"a, b\",G,0.25,1e-9,0.001,0.5,-0.5,0.125,1e-20,0.5,,,,no_peak rho_s_weak,");
    }

    #[test]
    fn columns_are_the_parameters_of_the_model() {
        let model: ModelName = "ggx".parse().unwrap();
        let values = vec![0.25, 0.5, 0.001, 0.75, 0.125];
        let lines = lines(&MaterialParameters::new(model, [values.clone(), values.clone(), values]).unwrap());
        assert_eq!(lines[0], "name,channel,rho_d,rho_s,alpha,f0,f1,cost_step1,cost_step2,E,L,C,flags,sha256");
        assert_eq!(lines[3], "\"a, b\",B,0.25,0.5,0.001,0.75,0.125,1e-20,0.5,,,,,");
    }
}
