//! Materials of the test data.

use std::path::Path;

use brdfit_brdf::{SgdMaterial, SgdParameters};

#[allow(dead_code)] // no test program needs all of it
#[path = "../../../measured/tests/data/mod.rs"]
pub(crate) mod data;

/// A material with the parameters that were published for a measured one.
pub(crate) fn published(data: &Path, name: &str) -> SgdMaterial {
    let table = std::fs::read(data.join("tables/sgd_published.json")).unwrap();
    let table: serde_json::Value = serde_json::from_slice(&table).unwrap();
    let parameters = [0, 1, 2].map(|c| {
        let p = |key: &str| table[name][key][c].as_f64().unwrap_or_else(|| panic!("{key} of {name}"));
        SgdParameters { rho_d: p("rho_d"), rho_s: p("rho_s"), alpha: p("alpha"), p: p("p"), f0: p("F0"), f1: p("F1") }
    });
    SgdMaterial::new(parameters).unwrap()
}
