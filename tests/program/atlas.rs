//! Bandwidth atlases: their files, their origin, batches, resuming.

use std::fs;

use brdfit_bandwidth::sidecar::{AtlasDocument, FileContent};
use brdfit_bandwidth::{Atlas, AtlasChannels, ShaderLanguage, exr, ktx2, shader};
use sha2::{Digest, Sha256};

use crate::documents::assert_valid;
use crate::program::{ROUGH, Workplace, measured, result};

/// Lobes without a sharp part are the same at every limit, and this one is the fastest.
const FAST: &str = "--max-resolution 256";

fn sha256(bytes: &[u8]) -> String {
    Sha256::digest(bytes).iter().map(|byte| format!("{byte:02x}")).collect()
}

/// Reads an atlas from all its files and holds them to each other and to the sidecar.
fn read_back(place: &Workplace, folder: &str, name: &str) -> (Atlas, AtlasDocument) {
    let files = place.files(folder);
    let sidecar = place.json(&format!("{folder}/{name}.atlas.json"));
    assert_valid("atlas", &sidecar);
    let document: AtlasDocument = serde_json::from_value(sidecar).unwrap();
    let (stored, provenance) = ktx2::from_bytes(&files[&format!("{name}.atlas.ktx2")]).unwrap();
    let (atlas, from_exr) = exr::from_bytes(&files[&format!("{name}.atlas.exr")]).unwrap();
    assert_eq!((&provenance.source, &provenance.program), (&document.source, &document.program));
    assert_eq!(provenance, from_exr);
    assert!(atlas.rounded_up() == stored);
    let (low, high) = stored.range();
    assert_eq!((document.range, document.layout, document.channels), ([low, high], stored.layout(), stored.channels()));
    for entry in &document.files {
        assert!(files.contains_key(&entry.name), "{}", entry.name);
    }
    (atlas, document)
}

#[test]
fn a_fit_and_its_atlas_belong_together() {
    let place = Workplace::new();
    place.link("rough.binary", &measured().rough);
    place.succeed("fit rough.binary -o fits --atlas --threads 3");
    let names =
        ["rough.atlas.exr", "rough.atlas.json", "rough.atlas.ktx2", "rough.json", "summary.csv", "summary.json"];
    assert_eq!(place.names("fits"), names);
    let fits = place.files("fits");
    let (atlas, document) = read_back(&place, "fits", "rough");
    assert_eq!((document.source.kind.as_str(), document.source.name.as_str()), ("fit", "rough"));
    assert_eq!(document.source.sha256, Some(sha256(&fits["rough.json"])));
    assert_eq!(atlas.channels(), AtlasChannels::Max);
    assert!(atlas.range().1 > 0.0);

    // the documents that are no fits are passed over, and another number of threads gives the same bytes
    let ran = place.succeed("atlas fits -o atlases --threads 1");
    assert_eq!((ran.stdout.as_str(), ran.stderr.as_str()), ("", "1 atlas: atlases\n"));
    let atlases = place.files("atlases");
    assert_eq!(atlases.len(), 3);
    assert!(atlases.iter().all(|(name, bytes)| fits[name] == *bytes));

    // resuming finds a texture that is gone, and nothing else to do
    fs::remove_file(place.path("fits/rough.atlas.ktx2")).unwrap();
    let ran = place.succeed("fit rough.binary -o fits --atlas --resume");
    assert_eq!(ran.stderr, "1 fitted (1 kept): fits/summary.json\n");
    assert!(place.files("fits") == fits);
    let modified = || fs::metadata(place.path("fits/rough.atlas.ktx2")).unwrap().modified().unwrap();
    let before = modified();
    place.succeed("fit rough.binary -o fits --atlas --resume");
    let ran = place.succeed("atlas fits/rough.json -o fits --resume");
    assert_eq!(ran.stderr, "1 atlas (1 kept): fits\n");
    assert_eq!(modified(), before);
}

#[test]
fn a_batch_goes_on_past_bad_inputs() {
    let place = Workplace::new();
    place.put("in/a-empty.json", "");
    place.put("in/b-later.json", result(&ROUGH).replacen('{', "{\"schema_version\": 99, ", 1));
    place.put("in/c-text.binary", "this is no measurement");
    place.link("in/deeper/rough.binary", &measured().rough);
    place.put("in/summary.json", "{}");
    let huge = ROUGH.map(|mut channel| {
        channel[1] = 1e308;
        channel
    });
    place.put("in/z-huge.json", result(&huge));
    let options = "--channels rgba --exr-samples float --preview --sample-position centre --format json";
    let line = format!("atlas in gone.json -o out --recursive {FAST} {options}");
    let ran = place.run(&line);
    assert_eq!(ran.code, Some(4), "{}", ran.stderr);
    let mut lines: Vec<&str> = ran.stderr.lines().collect();
    assert_eq!(lines.pop(), Some("1 atlas, 5 failed: out"));
    lines.sort_unstable();
    for (line, start) in lines.iter().zip([
        "error: gone.json: no such file",
        "error: in/a-empty.json: the file is empty (0 bytes), not a fit result",
        "error: in/b-later.json: has schema version 99",
        "error: in/c-text.binary: implausible dimensions",
        "error: in/z-huge.json: invalid texels",
    ]) {
        assert!(line.starts_with(start), "{line}");
    }

    let names = ["rough.atlas.exr", "rough.atlas.json", "rough.atlas.ktx2", "rough.atlas.png"];
    assert_eq!(place.names("out"), names);
    let (atlas, document) = read_back(&place, "out", "rough");
    assert_eq!(atlas.channels(), AtlasChannels::Rgba);
    assert_eq!(document.files[1].content, FileContent::ExrFloat);
    assert_eq!(document.source.kind, "merl");
    assert_eq!(document.source.sha256, Some(sha256(&fs::read(&measured().rough).unwrap())));
    assert_eq!(document.options.resolutions, [256]);
    let sidecar = place.json("out/rough.atlas.json");
    assert_eq!(sidecar["sample_position"], "centre");
    assert_eq!(serde_json::from_str::<serde_json::Value>(&ran.stdout).unwrap(), serde_json::json!([sidecar]));
    assert!(place.files("out")["rough.atlas.png"].starts_with(b"\x89PNG"));

    // of three parts the second has b-later and rough
    let ran = place.run(&format!("{line} --resume --shard 2/3"));
    assert_eq!(ran.code, Some(3), "{}", ran.stderr);
    assert!(ran.stderr.ends_with("\n1 atlas (1 kept), 1 failed: out\n"), "{}", ran.stderr);
    let text = format!("atlas in/deeper -o out --resume {FAST} {}", options.replace("json", "text"));
    let table = place.succeed(&text).stdout;
    assert!(table.lines().nth(2).is_some_and(|line| line.starts_with("rough           0 ")), "{table}");
}

#[test]
fn two_materials_of_one_name_are_refused() {
    let place = Workplace::new();
    place.put("in/x.json", result(&ROUGH));
    place.put("in/x.binary", "");
    place.put("red-satin.json", result(&ROUGH));
    for (line, part) in [
        ("atlas in -o out", "two inputs with the name x; rename one, or write their results to different folders"),
        ("atlas red-satin red-satin.json -o out", "red-satin and red-satin.json: two inputs with the name red-satin"),
    ] {
        let ran = place.run(line);
        assert_eq!((ran.code, ran.stderr.lines().count()), (Some(1), 1), "{}", ran.stderr);
        assert!(ran.stderr.contains(part), "{}", ran.stderr);
        assert!(!place.path("out").exists());
    }
}

#[test]
fn the_shader_functions_are_those_of_the_library() {
    let place = Workplace::new();
    for language in ShaderLanguage::ALL {
        let name = language.name();
        assert_eq!(place.succeed(&format!("export {name}")).stdout, shader(language));
        place.succeed(&format!("export {name} -o sampling.{name}"));
        assert_eq!(fs::read_to_string(place.path(&format!("sampling.{name}"))).unwrap(), shader(language));
    }
}
