//! Our fits against the published parameters of 100 materials: one JSON line per channel, which
//! `scripts/reference/published_table.py` turns into docs/published_comparison.md.
//!
//! `published_comparison TABLE.json reconstruction POSITION FILE.binary...` fits the files (named after their materials) and
//! judges both parameter sets on them. `published_comparison TABLE.json recovery POSITION` makes files from the published
//! parameters, fits them with the constraint `free` and tells how closely the curves come back.

use brdfit_brdf::{MaterialParameters, ModelName, SgdParameters};
use brdfit_fit::document::SliceCurves;
use brdfit_fit::{Constraint, FitOptions, PanelGeometry, error_panel, fit_slices, step_costs, synthesise};
use brdfit_measured::{CHANNEL_NAMES, Dimensions, MerlFile, SamplePosition};
use serde_json::{Value, json};
use std::error::Error;
use std::path::Path;

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [table, task, position, files @ ..] = &arguments[..] else {
        return Err(
            "usage: published_comparison TABLE.json reconstruction|recovery edge|centre [FILE.binary...]".into()
        );
    };
    let table: Value = serde_json::from_slice(&std::fs::read(table)?)?;
    let position: SamplePosition = serde_json::from_value(json!(position))?;
    let geometry = PanelGeometry::new(Dimensions::HALF_TURN, position);
    match task.as_str() {
        "reconstruction" => {
            files.iter().try_for_each(|file| reconstruction(&table, position, &geometry, Path::new(file)))
        }
        "recovery" => {
            let table = table.as_object().ok_or("the table is not an object")?;
            table.iter().try_for_each(|(name, material)| recovery(name, material, position))
        }
        other => Err(format!("no task `{other}`: reconstruction or recovery").into()),
    }
}

fn published(material: &Value) -> Result<MaterialParameters, Box<dyn Error>> {
    let channel = |c: usize| -> Result<SgdParameters, Box<dyn Error>> {
        let p = |key: &str| material[key][c].as_f64().ok_or(format!("no number `{key}` for channel {c}"));
        Ok(SgdParameters {
            rho_d: p("rho_d")?,
            rho_s: p("rho_s")?,
            alpha: p("alpha")?,
            p: p("p")?,
            f0: p("F0")?,
            f1: p("F1")?,
        })
    };
    Ok([channel(0)?, channel(1)?, channel(2)?].try_into()?)
}

fn reconstruction(
    table: &Value,
    position: SamplePosition,
    geometry: &PanelGeometry,
    path: &Path,
) -> Result<(), Box<dyn Error>> {
    let name = path.file_stem().and_then(|stem| stem.to_str()).ok_or("a file without a name")?;
    let theirs = published(&table[name])?;
    let options = FitOptions::default();
    let file = MerlFile::open(path)?;
    let scan = file.scan();
    if let Some(fault) = scan.fault() {
        return Err(format!("{}: {fault}", path.display()).into());
    }
    let slices = file.slices(position);
    let fit = fit_slices(&slices, ModelName::Sgd, &options)?;
    let ggx = fit_slices(&slices, ModelName::Ggx, &FitOptions::new(ModelName::Ggx))?;
    let ggx_panel = error_panel(&file.cells(), scan.valid(), geometry, &ggx.parameters);
    let (our_panel, their_panel) = (
        error_panel(&file.cells(), scan.valid(), geometry, &fit.parameters),
        error_panel(&file.cells(), scan.valid(), geometry, &theirs),
    );
    let their_costs = step_costs(&slices, &options, &theirs)?;
    for c in 0..3 {
        let steps = &fit.channels[c].steps;
        println!(
            "{}",
            json!({
                "material": name, "channel": CHANNEL_NAMES[c],
                "ours": { "costs": [steps[0].cost, steps[1].cost], "E": our_panel.e[c], "L": our_panel.l[c], "C": our_panel.c[c] },
                "ggx": { "E": ggx_panel.e[c], "L": ggx_panel.l[c], "C": ggx_panel.c[c] },
                "published": { "costs": their_costs[c], "E": their_panel.e[c], "L": their_panel.l[c], "C": their_panel.c[c] },
                "flags": fit.channels[c].flags,
            })
        );
    }
    Ok(())
}

fn recovery(name: &str, material: &Value, position: SamplePosition) -> Result<(), Box<dyn Error>> {
    let truth = published(material)?;
    let dimensions = Dimensions::HALF_TURN;
    let planes = synthesise(&truth, dimensions, position);
    let file = MerlFile::from_fn(name, dimensions, |c, h, d, p| planes[c][dimensions.index(h, d, p)])?;
    let options = FitOptions { constraint: Constraint::Free, ..FitOptions::default() };
    let fit = fit_slices(&file.slices(position), ModelName::Sgd, &options)?;
    for c in 0..3 {
        let value = |parameters: &MaterialParameters, name| parameters.get(c, name).unwrap_or(f64::NAN);
        println!(
            "{}",
            json!({
                "material": name, "channel": CHANNEL_NAMES[c], "flags": fit.channels[c].flags,
                "curves": largest_deviations(&fit.slices, c, &options),
                "alpha": value(&fit.parameters, "alpha") / value(&truth, "alpha") - 1.0,
                "p": value(&fit.parameters, "p") - value(&truth, "p"),
            })
        );
    }
    Ok(())
}

/// Largest relative deviation of the fitted curves from the slices inside the cut-offs.
fn largest_deviations(slices: &SliceCurves, c: usize, options: &FitOptions) -> [f64; 2] {
    let largest = |angles: &[f64], measured: &[Option<f64>], fitted: &[f64], cutoff: f64| {
        let inside = angles.iter().zip(measured).zip(fitted).filter(|((angle, _), _)| angle.to_degrees() <= cutoff);
        inside.filter_map(|((_, m), f)| m.map(|m| (f / m - 1.0).abs())).fold(0.0, f64::max)
    };
    [
        largest(
            &slices.theta_h,
            &slices.measured.theta_h[c],
            &slices.fitted.theta_h[c],
            options.cutoff_theta_h_degrees,
        ),
        largest(
            &slices.theta_d,
            &slices.measured.theta_d[c],
            &slices.fitted.theta_d[c],
            options.cutoff_theta_d_degrees,
        ),
    ]
}
