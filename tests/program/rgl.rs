//! RGL files through every command that takes measurements.

use std::fs;
use std::path::PathBuf;

use serde_json::{Value, json};

use crate::documents::assert_valid;
use crate::program::Workplace;
use crate::render;

/// A folder with an RGL file of an analytic GGX material.
fn workplace() -> Workplace {
    let place = Workplace::new();
    let file = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("data-fixtures/ggx_rgb.bsdf");
    place.put("in/ggx_rgb.bsdf", fs::read(file).unwrap());
    place
}

#[test]
fn info_describes_the_tables() {
    let place = workplace();
    let printed = place.succeed("info in/ggx_rgb.bsdf --format json").stdout;
    let documents: Value = serde_json::from_str(&printed).unwrap();
    assert_valid("info", &documents);
    assert_eq!((&documents[0]["format"], &documents[0]["name"]), (&json!("rgl"), &json!("ggx_rgb.bsdf")));
    assert_eq!(documents[0]["measured_theta_i_deg"].as_array().unwrap().len(), 16);
    let text = place.succeed("info in/ggx_rgb.bsdf").stdout;
    assert!(text.lines().all(|line| line.chars().count() <= 120), "{text}");
    for part in ["format rgl, ", "16 theta_i measured: 0.0, ", "non-reciprocity 0.0", "1 x 16 x 32 x 32", "80 deg"] {
        assert!(text.contains(part), "no {part:?} in {text}");
    }
}

#[test]
fn fits_say_where_their_samples_lie() {
    let place = workplace();
    place.succeed("fit in -o out --max-iterations 30");
    let document = place.json("out/ggx_rgb.json");
    assert_valid("fit", &document);
    assert_eq!(document["input"]["sample_position"], "centre");
    assert_eq!(document["options"]["sample_position"], "centre");
    assert_eq!(document["input"]["dimensions"], json!([90, 90, 180]));
    assert!(document["errors"]["samples"].as_u64().unwrap() > 900_000);
    let first = place.files("out");
    let again = place.succeed("fit in -o out --max-iterations 30 --resume");
    assert!(again.stderr.contains("(1 kept)"), "{}", again.stderr);
    assert_eq!(place.files("out"), first);
}

#[test]
fn another_sample_position_is_refused() {
    let place = workplace();
    let part = "in/ggx_rgb.bsdf: RGL files have their samples at the centre, not at the edge";
    for line in ["fit in/ggx_rgb.bsdf", "info in/ggx_rgb.bsdf", "atlas in -o out"] {
        let ran = place.run(&format!("{line} --sample-position edge"));
        assert!(ran.code == Some(3) && ran.stderr.contains(part), "{line}: {:?} {}", ran.code, ran.stderr);
    }
    place.succeed("info in/ggx_rgb.bsdf --sample-position centre");
}

#[test]
fn atlases_and_pictures_come_from_the_table() {
    let place = workplace();
    place.succeed("atlas in -o out --max-resolution 256 --formats ktx2");
    let sidecar = place.json("out/ggx_rgb.atlas.json");
    assert_valid("atlas", &sidecar);
    assert_eq!((&sidecar["source"]["kind"], &sidecar["sample_position"]), (&json!("rgl"), &json!("centre")));
    let mut scene = render::scene();
    let file = json!({ "file": "in/ggx_rgb.bsdf" });
    scene["materials"]["paint"] = json!({ "source": { "measured": file }, "atlas": "out/ggx_rgb.atlas.ktx2" });
    scene["materials"]["floor"]["atlas"] = json!("out/ggx_rgb.atlas.ktx2");
    assert_valid("scene", &scene);
    place.put("scene.json", scene.to_string());
    place.succeed("render scene.json -o image.exr --spp 4");
    assert!(fs::metadata(place.path("image.exr")).unwrap().len() > 1000);
    scene["materials"]["paint"]["source"]["measured"]["sample_position"] = json!("edge");
    place.put("scene.json", scene.to_string());
    let ran = place.run("render scene.json -o other.exr");
    let part = "materials.paint.source.measured.file: in/ggx_rgb.bsdf: RGL files have their samples at the centre";
    assert!(ran.code == Some(3) && ran.stderr.contains(part), "{:?} {}", ran.code, ran.stderr);
}

#[test]
fn malformed_files_are_one_line_each() {
    let place = workplace();
    let sound = fs::read(place.path("in/ggx_rgb.bsdf")).unwrap();
    place.put("cut.bsdf", &sound[..sound.len() / 2]);
    place.put("text.bsdf", "this is no measurement");
    let cases = [
        ("fit cut.bsdf", 3, "cut.bsdf: field "),
        ("info text.bsdf", 3, "text.bsdf: is a file of another kind, not an RGL file; check that it is the right one"),
        ("fit gone.bsdf", 2, "gone.bsdf: no such file"),
    ];
    crate::malformed::check(&place, &cases);
}
