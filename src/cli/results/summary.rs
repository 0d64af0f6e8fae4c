//! The summary of a batch, as JSON and as a table for spreadsheets.

use std::ffi::OsStr;
use std::io;
use std::path::{Path, PathBuf};

use brdfit_fit::FitOptions;
use brdfit_fit::document::{CHANNELS, Failure, Flag, SCHEMA_VERSION, SummaryDocument, SummaryRow};
use serde::Serialize;

use crate::results::folder::{PROGRAM, ResultFolder};
use crate::results::json;
use crate::results::output;
use crate::results::shard::Shard;
use crate::terminal::exit_code::Problem;

/// The document; this module knows its form, the batch its content.
pub(crate) type Summary = SummaryDocument;

/// An empty summary.
pub(crate) fn new(options: FitOptions) -> Summary {
    Summary {
        schema_version: SCHEMA_VERSION,
        program: PROGRAM.to_owned(),
        options,
        materials: Vec::new(),
        failures: Vec::new(),
    }
}

/// What failures are sorted by: the name that the result would have had, as the materials are.
pub(crate) fn order(failure: &Failure) -> (Option<&OsStr>, &str) {
    (Path::new(&failure.input).file_stem(), &failure.input)
}

/// Writes `summary.json` and `summary.csv`, or the `summary.I-of-N.json` of a shard; returns the path of the JSON file.
///
/// # Errors
/// As [`output::write`].
pub(crate) fn write(folder: &ResultFolder, shard: Option<Shard>, summary: &Summary) -> Result<PathBuf, Problem> {
    if shard.is_none() {
        output::write_with(&folder.summary_table(), |out| write_csv(out, &summary.materials))?;
    }
    let path = folder.summary(shard);
    output::write(&path, &json::to_vec(summary))?;
    Ok(path)
}

/// One channel of one material.
#[derive(Serialize)]
struct CsvRow<'a> {
    name: &'a str,
    channel: &'a str,
    rho_d: f64,
    rho_s: f64,
    alpha: f64,
    p: f64,
    f0: f64,
    f1: f64,
    cost_step1: f64,
    cost_step2: f64,
    #[serde(rename = "E")]
    e: Option<f64>,
    #[serde(rename = "L")]
    l: Option<f64>,
    #[serde(rename = "C")]
    c: Option<f64>,
    flags: String,
    sha256: Option<&'a str>,
}

fn write_csv(out: &mut dyn io::Write, materials: &[SummaryRow]) -> io::Result<()> {
    let mut table = csv::Writer::from_writer(out);
    for material in materials {
        for channel in 0..CHANNELS.len() {
            table.serialize(CsvRow::new(material, channel)).map_err(io::Error::from)?;
        }
    }
    table.flush()
}

impl<'a> CsvRow<'a> {
    fn new(material: &'a SummaryRow, channel: usize) -> Self {
        let parameters = &material.parameters[channel];
        let errors = material.errors.as_ref();
        Self {
            name: &material.name,
            channel: CHANNELS[channel],
            rho_d: parameters.rho_d,
            rho_s: parameters.rho_s,
            alpha: parameters.alpha,
            p: parameters.p,
            f0: parameters.f0,
            f1: parameters.f1,
            cost_step1: material.costs[channel][0],
            cost_step2: material.costs[channel][1],
            e: errors.map(|panel| panel.e[channel]),
            l: errors.map(|panel| panel.l[channel]),
            c: errors.map(|panel| panel.c[channel]),
            flags: words(&material.flags[channel]),
            sha256: material.sha256.as_deref(),
        }
    }
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
    use brdfit_brdf::SgdParameters;

    #[test]
    fn the_table_has_one_row_per_channel() {
        let parameters = SgdParameters { rho_d: 0.25, rho_s: 1e-9, alpha: 0.001, p: 0.5, f0: -0.5, f1: 0.125 };
        let material = SummaryRow {
            name: "a, b".to_owned(),
            sha256: None,
            parameters: [parameters; 3],
            costs: [[1e-20, 0.5]; 3],
            errors: None,
            flags: [vec![], vec![Flag::NoPeak, Flag::RhoSWeak], vec![]],
        };
        let mut bytes = Vec::new();
        write_csv(&mut bytes, &[material]).unwrap();
        let text = String::from_utf8(bytes).unwrap();
        let lines: Vec<&str> = text.lines().collect();
        assert_eq!(lines.len(), 4);
        assert_eq!(lines[0], "name,channel,rho_d,rho_s,alpha,p,f0,f1,cost_step1,cost_step2,E,L,C,flags,sha256");
        assert_eq!(lines[2], "\"a, b\",G,0.25,1e-9,0.001,0.5,-0.5,0.125,1e-20,0.5,,,,no_peak rho_s_weak,");
    }
}
