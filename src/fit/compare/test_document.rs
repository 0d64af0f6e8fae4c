//! A small document, written as another program would write it.

use crate::compare::ComparableFit;

/// Four rows per slice, the last one of theta_d beyond the cut-off; one row without a measurement.
pub(crate) const DOCUMENT: &str = r#"{
    "schema_version": 1,
    "program": "by hand",
    "input": { "name": "x", "sha256": "00ff", "dimensions": [90, 90, 180], "sample_position": "edge" },
    "options": { "loss": "log1p-cos", "constraint": "physical", "cutoff_theta_h": 75.0, "cutoff_theta_d": 70.0, "solver": "x" },
    "model": "sgd",
    "channels": [
        { "name": "R", "steps": [{ "name": "theta_h", "cost": 1e-3 }, { "name": "theta_d", "cost": 2e-2, "rows": 3 }] },
        { "name": "G", "steps": [{ "name": "theta_h", "cost": 2e-3 }, { "name": "theta_d", "cost": 3e-2 }] },
        { "name": "B", "steps": [{ "name": "theta_h", "cost": 3e-3 }, { "name": "theta_d", "cost": 4e-2 }] }
    ],
    "errors": { "E": [0.1, 0.2, 0.3], "L": [0.01, 0.02, 0.03], "C": [0.04, 0.05, 0.06], "samples": 9 },
    "slices": {
        "theta_h": [0.0, 0.1, 0.5, 1.0],
        "theta_d": [0.0, 0.5, 1.0, 1.3],
        "measured": {
            "theta_h": [[10, 5, null, 0.1], [10, 5, null, 0.1], [10, 5, null, 0.1]],
            "theta_d": [[10, 11, 12, 40], [10, 11, 12, 40], [10, 11, 12, 40]]
        },
        "fitted": {
            "theta_h": [[9.5, 5.5, null, 0.11], [9.5, 5.5, 0.3, 0.11], [9.5, 5.5, 0.3, 0.11]],
            "theta_d": [[10, 11, 12, 50], [10, 11, 12, 50], [10, 11, 12, 50]]
        }
    }
}"#;

pub(crate) fn fit() -> ComparableFit {
    ComparableFit::from_json(DOCUMENT).unwrap()
}
