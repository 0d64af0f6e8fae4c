//! Images of scenes: the same bytes again, modes, layers, comparisons, documents.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::PathBuf;
use std::sync::OnceLock;

use brdfit_renderer::{Radiance, SceneDocument};
use serde_json::{Value, json};

use crate::documents::assert_valid;
use crate::openexr::{channels, plain};
use crate::program::Workplace;

/// A glossy ball over a chequered floor, both with one atlas.
pub(crate) fn scene() -> Value {
    json!({
        "camera": { "eye": [3.4, 0.4, 1.7], "target": [0, 0, -0.2], "vertical_fov": 40, "width": 48, "height": 40 },
        "light": { "procedural": { "kind": "studio", "rotation": 20 } },
        "materials": {
            "floor": {
                "source": { "lambert": [0.7, 0.7, 0.7] },
                "atlas": "paint.atlas.ktx2",
                "albedo": { "checker": { "colors": [[1, 0.9, 0.8], [0.2, 0.2, 0.3]], "scale": 8 } }
            },
            "paint": { "source": { "embedded": "red-satin" }, "atlas": "paint.atlas.ktx2" }
        },
        "objects": [
            { "mesh": { "plane": { "size": 4 } }, "material": "floor", "translate": [0, 0, -1] },
            { "mesh": { "sphere": { "radius": 0.9 } }, "material": "paint" }
        ]
    })
}

/// A folder with the scene and its atlas, which all tests share.
pub(crate) fn workplace() -> Workplace {
    static MADE: OnceLock<(Workplace, PathBuf)> = OnceLock::new();
    let (_, atlas) = MADE.get_or_init(|| {
        let place = Workplace::new();
        place.succeed("atlas red-satin -o made --max-resolution 256 --formats ktx2");
        let atlas = place.path("made/red-satin.atlas.ktx2");
        (place, atlas)
    });
    let place = Workplace::new();
    place.link("paint.atlas.ktx2", atlas);
    place.put("scene.json", scene().to_string());
    place
}

/// Statistics without the times, after a look at their schema.
fn statistics(place: &Workplace, name: &str) -> Value {
    let mut document = place.json(name);
    assert_valid("render", &document);
    document.as_object_mut().unwrap().remove("milliseconds").unwrap();
    document
}

fn radiance(place: &Workplace, name: &str) -> Radiance {
    Radiance::from_exr(&fs::read(place.path(name)).unwrap()).unwrap()
}

#[test]
fn the_same_bytes_for_every_number_of_threads_and_again() {
    let place = workplace();
    let files = "-o x.exr --layers all --png x.png --map map.png --stats x.json --frames 2 --spp 4";
    let run = |threads: u32| -> (Value, BTreeMap<String, Vec<u8>>) {
        place.succeed(&format!("render scene.json {files} --threads {threads}"));
        let mut written = place.files(".");
        written.retain(|name, _| ["x.exr", "x.png", "map.png"].contains(&name.as_str()));
        assert_eq!(written.len(), 3);
        (statistics(&place, "x.json"), written)
    };
    let first = run(1);
    for threads in [2, 5, 1] {
        assert!(run(threads) == first, "{threads} threads");
    }
    for (name, start) in [("x.png", b"\x89PNG"), ("map.png", b"\x89PNG")] {
        assert!(first.1[name].starts_with(start), "{name}");
    }
    place.succeed(&format!("render scene.json {files} --seed 1"));
    assert!(place.files(".")["x.exr"] != first.1["x.exr"], "another seed is another image");
}

#[test]
fn every_mode_comes_near_the_reference() {
    let place = workplace();
    place.succeed("render scene.json -o converged.exr --mode reference --spp 256 --seed 9 --stats converged.json");
    let reference = statistics(&place, "converged.json");
    assert_eq!(reference["samples"]["per_pixel"], 256.0);
    assert_eq!(reference["samples"]["pilot"], 0);
    assert_eq!(reference["quality"], Value::Null);
    let foreground = reference["foreground"].as_u64().unwrap();
    assert!(foreground > 300 && foreground < 48 * 40, "{foreground}");
    for mode in ["adaptive", "adaptive-pixels", "adaptive-counts", "reference"] {
        let line = format!("render scene.json -o {mode}.exr --mode {mode} --spp 16 --stats {mode}.json");
        place.succeed(&format!("{line} --reference converged.exr"));
        let statistics = statistics(&place, &format!("{mode}.json"));
        assert_eq!(statistics["options"]["mode"], mode);
        assert_eq!(statistics["foreground"], foreground);
        let shaded: u64 = statistics["shaded_per_level"].as_array().unwrap().iter().map(|n| n.as_u64().unwrap()).sum();
        let every_pixel = ["adaptive-counts", "reference"].contains(&mode);
        assert!(if every_pixel { shaded == foreground } else { shaded < foreground }, "{mode}: {shaded}");
        let per_pixel = statistics["samples"]["per_pixel"].as_f64().unwrap();
        let pilot = statistics["samples"]["pilot"].as_f64().unwrap() / foreground as f64;
        assert!((per_pixel - pilot - 16.0).abs() < 1.0, "{mode}: {per_pixel} samples per pixel, {pilot} of the pilot");
        let quality = &statistics["quality"];
        assert_eq!(quality["reference"], "converged.exr");
        assert!(quality["psnr"].as_f64().unwrap() > 24.0, "{mode}: {quality}");
        assert!(quality["relmse"].as_f64().unwrap() < 0.05, "{mode}: {quality}");
        let image = radiance(&place, &format!("{mode}.exr"));
        assert_eq!((image.width, image.height), (48, 40));
    }
}

#[test]
fn an_image_differs_in_nothing_from_itself() {
    let place = workplace();
    place.succeed("render scene.json -o x.exr");
    let foreground = |name: &str| statistics(&place, name)["quality"].clone();
    // what is behind the surfaces is not compared
    for background in ["light", "black"] {
        let line = format!("render scene.json -o y.exr --background {background} --reference x.exr --stats y.json");
        let ran = place.succeed(&line);
        let quality = foreground("y.json");
        assert_eq!(quality["psnr"], Value::Null);
        assert_eq!((quality["relmse"].as_f64(), quality["flip"].as_f64()), (Some(0.0), Some(0.0)), "{quality}");
        assert!(ran.stderr.ends_with(": y.exr\n") && ran.stderr.lines().count() == 1, "{}", ran.stderr);
    }
    let black = radiance(&place, "y.exr").pixels.iter().filter(|&&pixel| pixel == [0.0; 3]).count();
    let lit = radiance(&place, "x.exr").pixels.iter().filter(|&&pixel| pixel == [0.0; 3]).count();
    assert!(lit == 0 && black > 100, "{lit} {black}");
}

#[test]
fn layers_are_channels_of_the_image() {
    let place = workplace();
    let names = |options: &str| -> BTreeSet<String> {
        place.succeed(&format!("render scene.json -o x.exr --spp 1 {options}"));
        channels(&fs::read(place.path("x.exr")).unwrap()).into_iter().collect()
    };
    let set = |layers: &[(&str, &str)]| -> BTreeSet<String> {
        let named = |&(layer, channels): &(&str, &str)| -> Vec<String> {
            channels.split(' ').map(|channel| format!("{layer}.{channel}")).collect()
        };
        ["R", "G", "B"].map(str::to_owned).into_iter().chain(layers.iter().flat_map(named)).collect()
    };
    let gbuffer = [
        ("position", "X Y Z"),
        ("normal", "X Y Z"),
        ("view", "X Y Z"),
        ("albedo", "R G B"),
        ("uv", "U V"),
        ("depth", "Z"),
        ("material", "Y"),
        ("spread", "Y"),
        ("curvature", "Y"),
    ];
    let every_mode = [("light", "NU"), ("list", "LEVEL SAMPLES FILTERED"), ("upsampled", "R G B")];
    let predicted = [
        ("pilot", "MEAN VARIANCE NU EQ9"),
        ("bandwidth", "Y"),
        ("level", "Y"),
        ("decision", "L0 L1 L2 L3 L4 L5"),
        ("variance", "Y"),
    ];
    assert_eq!(names(""), set(&[]));
    assert_eq!(names("--layers gbuffer"), set(&gbuffer));
    assert_eq!(names("--layers list,light,upsampled"), set(&every_mode));
    assert_eq!(names("--layers all --mode reference"), set(&[&gbuffer[..], &every_mode].concat()));
    assert_eq!(names("--layers all --frames 2"), set(&[&gbuffer[..], &every_mode, &predicted].concat()));
    // the text that explains them names every one
    let formats = fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/docs/formats.md")).unwrap();
    let section = section(&formats, "Images");
    for (layer, channels) in gbuffer.iter().chain(&every_mode).chain(&predicted) {
        assert!(section.contains(&format!("| `{layer}` | {channels} |")), "{layer} is not in docs/formats.md");
    }
}

#[test]
fn the_light_is_a_map_with_its_bandwidth() {
    let place = workplace();
    let mut uniform = scene();
    uniform["light"] = json!({ "procedural": { "kind": "uniform", "scale": 3 } });
    place.put("uniform.json", uniform.to_string());
    place.succeed("render uniform.json -o x.exr --spp 1 --light-map light.exr");
    assert_eq!(channels(&fs::read(place.path("light.exr")).unwrap()), ["B", "G", "R", "bandwidth.Y"]);
    let map = radiance(&place, "light.exr");
    assert_eq!((map.width, map.height), (2048, 1024));
    assert!(map.pixels.iter().flatten().all(|&value| (value - 3.0).abs() < 1e-5));
    // a file with the same radiance is the same light
    place.put("file.exr", plain(32, 16, |_, _| [3.0; 3]));
    uniform["light"] = json!({ "environment": { "file": "file.exr" } });
    place.put("again.json", uniform.to_string());
    place.succeed("render again.json -o y.exr --spp 1 --reference x.exr --stats y.json");
    assert!(statistics(&place, "y.json")["quality"]["psnr"].as_f64().is_none_or(|psnr| psnr > 60.0));
}

/// A section of a document, from below its heading to the next.
fn section<'a>(document: &'a str, heading: &str) -> &'a str {
    let start = document.find(&format!(". {heading} (")).unwrap_or_else(|| panic!("no section {heading}"));
    let text = &document[start..];
    text.find("\n## ").map_or(text, |end| &text[..end])
}

#[test]
fn scenes_follow_their_schema() {
    assert_valid("scene", &scene());
    let formats = fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/docs/formats.md")).unwrap();
    let section = section(&formats, "Scenes");
    let example = section.split("```json\n").nth(1).and_then(|text| text.split("```").next()).unwrap();
    let mut scenes = vec![("docs/formats.md".to_owned(), example.to_owned())];
    for entry in fs::read_dir(concat!(env!("CARGO_MANIFEST_DIR"), "/scripts/pairs")).unwrap() {
        let path = entry.unwrap().path();
        scenes.push((path.display().to_string(), fs::read_to_string(path).unwrap()));
    }
    for (name, text) in &scenes {
        assert_valid("scene", &serde_json::from_str(text).unwrap_or_else(|error| panic!("{name}: {error}")));
        SceneDocument::read(text.as_bytes()).unwrap_or_else(|error| panic!("{name}: {error}"));
    }
    // every member of the schema is explained
    let schema = serde_json::to_value(SceneDocument::schema()).unwrap();
    let mut members = BTreeSet::new();
    members_of(&schema, &mut members);
    members.remove("$schema");
    assert!(members.len() > 40, "{members:?}");
    for member in members {
        let explained = section.contains(&format!(".{member}")) || section.contains(&format!("`{member}`"));
        assert!(explained || section.contains(&format!("| {member}")), "{member} is not in docs/formats.md");
    }
}

/// The names of all members that a schema knows.
fn members_of(schema: &Value, members: &mut BTreeSet<String>) {
    match schema {
        Value::Object(object) => {
            if let Some(Value::Object(properties)) = object.get("properties") {
                members.extend(properties.keys().cloned());
            }
            object.values().for_each(|value| members_of(value, members));
        }
        Value::Array(values) => values.iter().for_each(|value| members_of(value, members)),
        _ => {}
    }
}

#[test]
fn the_demo_ends_with_a_picture_of_its_fit() {
    let place = Workplace::new();
    let ran = place.succeed("demo -o out --material terracotta");
    let files = place.files("out");
    assert!(files["terracotta.render.png"].starts_with(b"\x89PNG"));
    for name in files.keys() {
        let told = ran.stdout.contains(name) || name == "terracotta.atlas.exr" || name == "terracotta.atlas.json";
        assert!(told, "{name} is not in {}", ran.stdout);
    }
    // the scene that it leaves is one for `brdfit render`, whose files lie beside it
    let scene = place.json("out/terracotta.scene.json");
    assert_valid("scene", &scene);
    assert_eq!(scene["materials"]["terracotta"]["source"]["fit"], "terracotta.json");
    place.succeed("render out/terracotta.scene.json -o x.exr --map x.png --spp 1");
}
