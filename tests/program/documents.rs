//! Every document against its published schema, and the published schemas against the program.

use std::fs;
use std::path::PathBuf;

use jsonschema::Validator;
use serde_json::Value;

use crate::program::{Workplace, measured};

/// Refreshes the stored files instead of comparing with them.
const UPDATE: &str = "BRDFIT_UPDATE";

fn published(name: &str) -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join(format!("docs/schema/{name}.schema.json"))
}

fn validator(name: &str) -> Validator {
    let schema: Value = serde_json::from_slice(&fs::read(published(name)).unwrap()).unwrap();
    jsonschema::draft202012::meta::validate(&schema).unwrap_or_else(|error| panic!("{name}: {error}"));
    jsonschema::draft202012::new(&schema).unwrap()
}

#[track_caller]
pub(crate) fn assert_valid(name: &str, document: &Value) {
    let errors: Vec<String> =
        validator(name).iter_errors(document).map(|e| format!("{}: {e}", e.instance_path())).collect();
    assert!(errors.is_empty(), "{name}: {errors:#?}");
}

#[test]
fn the_published_schemas_are_current() {
    let place = Workplace::new();
    for name in ["fit", "summary", "info", "atlas", "scene", "render"] {
        let printed = place.succeed(&format!("schema {name}")).stdout;
        let path = published(name);
        if std::env::var_os(UPDATE).is_some() {
            fs::create_dir_all(path.parent().unwrap()).unwrap();
            fs::write(&path, &printed).unwrap();
        }
        let stored = fs::read_to_string(&path).unwrap_or_default();
        assert!(stored == printed, "{}: out of date; run the tests with {UPDATE}=1", path.display());
    }
}

#[test]
fn every_document_follows_its_schema() {
    let place = Workplace::new();
    place.link("in/glossy.binary", &measured().glossy);
    place.link("in/rough.binary", &measured().rough);
    place.put("in/zero.binary", "");
    let options = [
        "",
        "--joint",
        "--no-panel",
        "--no-hash",
        "--constraint paper",
        "--constraint free --loss sqrt-cos",
        "--constraint non-negative --loss l2 --anchor distribution",
        "--sample-position centre --step2-solver lm",
        "--max-iterations 1 --start 1,2",
    ];
    for (n, options) in options.iter().enumerate() {
        let ran = place.run(&format!("fit in -o out{n} {options}"));
        assert_eq!(ran.code, Some(3), "{}", ran.stderr);
        for name in ["glossy", "rough"] {
            assert_valid("fit", &place.json(&format!("out{n}/{name}.json")));
        }
        assert_valid("summary", &place.json(&format!("out{n}/summary.json")));
    }
    let info = place.succeed("info in/glossy.binary in/rough.binary --format json").stdout;
    assert_valid("info", &serde_json::from_str(&info).unwrap());
}

#[test]
fn black_and_extreme_materials_follow_the_schema_too() {
    let place = Workplace::new();
    // zero everywhere: the smallest measurement that there can be
    let mut black = [90_i32, 90, 180].map(i32::to_le_bytes).concat();
    black.resize(34_992_012, 0);
    place.put("black.binary", &black);
    // a mirror: one bright row, nothing else
    for cell in 0..90 * 180 {
        for plane in 0..3 {
            black[12 + 8 * (plane * 1_458_000 + cell)..][..8].copy_from_slice(&1e6_f64.to_le_bytes());
        }
    }
    place.put("mirror.binary", &black);
    place.succeed("fit black.binary mirror.binary -o out");
    for name in ["black", "mirror"] {
        assert_valid("fit", &place.json(&format!("out/{name}.json")));
    }
    let info = place.succeed("info black.binary mirror.binary --format json").stdout;
    assert_valid("info", &serde_json::from_str(&info).unwrap());
}

#[test]
fn the_schema_refuses_what_is_not_a_document() {
    let place = Workplace::new();
    place.link("rough.binary", &measured().rough);
    let good: Value = serde_json::from_str(&place.succeed("fit rough.binary").stdout).unwrap();
    let fit = validator("fit");
    assert!(fit.is_valid(&good));
    for (pointer, value) in [
        ("/schema_version", Value::from("one")),
        ("/channels/0/parameters/alpha", Value::Null),
        ("/channels/1/flags", serde_json::json!(["unheard_of"])),
        ("/options/loss", Value::from("l3")),
        ("/slices/theta_h", Value::from(1)),
    ] {
        let mut bad = good.clone();
        *bad.pointer_mut(pointer).unwrap() = value;
        assert!(!fit.is_valid(&bad), "{pointer}");
    }
}
