//! Scenes and options that cannot work: one line with the file and the member, an exit code, nothing left.

use serde_json::{Value, json};

use crate::malformed::check;
use crate::openexr::plain;
use crate::program::{GLOSSY, Workplace, result};
use crate::render::workplace;

/// A square in a room without shadows: nothing that takes time.
fn good() -> Value {
    json!({
        "camera": { "eye": [0, -3, 2], "target": [0, 0, 0], "vertical_fov": 40, "width": 8, "height": 8 },
        "light": { "procedural": { "kind": "uniform" } },
        "materials": { "grey": { "source": { "lambert": [0.5, 0.5, 0.5] }, "atlas": "paint.atlas.ktx2" } },
        "objects": [{ "mesh": { "plane": {} }, "material": "grey" }]
    })
}

/// Puts another value in the place of a member of the good scene, renders each such scene, and expects an exit code and a message
/// that begins with the scene and goes on with the given text.
pub(crate) fn check_members(place: &Workplace, cases: &[(&str, Value, i32, &str)]) {
    let mut lines = Vec::new();
    for (n, (pointer, value, code, part)) in cases.iter().enumerate() {
        let mut scene = good();
        let (owner, name) = pointer.rsplit_once('/').unwrap();
        match scene.pointer_mut(owner).unwrap() {
            Value::Array(list) => list[name.parse::<usize>().unwrap()] = value.clone(),
            owner => owner[name] = value.clone(),
        }
        place.put(&format!("{n}.json"), scene.to_string());
        lines.push((
            format!("render {n}.json -o x.exr --png x.png --stats x.json"),
            *code,
            format!(": {n}.json: {part}"),
        ));
    }
    let lines: Vec<_> = lines.iter().map(|(line, code, part)| (line.as_str(), *code, part.as_str())).collect();
    check(place, &lines);
}

#[test]
fn documents() {
    let place = Workplace::new();
    let text = good().to_string();
    for (name, content) in [
        ("empty.json", String::new()),
        ("text.json", "a sphere".to_owned()),
        ("cut.json", text[..text.len() / 2].to_owned()),
        ("list.json", "[1, 2]".to_owned()),
        ("fit.json", result(&GLOSSY)),
        ("twice.json", format!("{text}{text}")),
        ("huge.json", text.replace("40", "1e999")),
    ] {
        place.put(name, content);
    }
    place.put("folder/x", "");
    let cases = [
        ("gone.json", 2, "gone.json: no such file; check the path"),
        ("folder", 2, "folder: is a folder"),
        ("empty.json", 3, "empty.json: the file is empty (0 bytes), not a scene"),
        ("text.json", 3, "text.json: is not valid JSON: expected value at line 1 column 1"),
        ("cut.json", 3, "is not valid JSON: EOF while parsing"),
        ("list.json", 3, "list.json: invalid type: integer `1`"),
        ("fit.json", 3, "fit.json: channels: unknown field `channels`, expected one of `$schema`, `camera`, `light`"),
        ("twice.json", 3, "twice.json: is not valid JSON: trailing characters"),
        ("huge.json", 3, "huge.json: camera.vertical_fov: number out of range"),
    ]
    .map(|(scene, code, part)| (format!("render {scene} -o x.exr"), code, part));
    check(&place, &cases.each_ref().map(|(line, code, part)| (line.as_str(), *code, *part)));
}

#[test]
fn members() {
    let place = workplace();
    check_members(
        &place,
        &[
            ("/camera", json!({}), 3, "camera: missing field `eye`"),
            ("/camera/fov", json!(40), 3, "camera.fov: unknown field `fov`, expected one of `eye`, `target`"),
            ("/camera/eye", json!([0, 1]), 3, "camera.eye: invalid length 2, expected an array of length 3"),
            ("/camera/eye", json!(["far", 0, 0]), 3, "camera.eye[0]: invalid type: string \"far\", expected a number"),
            ("/camera/eye", json!([1e10, 0, 0]), 3, "camera.eye[0]: 1e10 is not within -1e9 to 1e9"),
            ("/camera/target", json!([0, -3, 2]), 3, "camera.target: is where the eye is"),
            ("/camera/up", json!([0, 3, -2]), 3, "camera.up: is parallel to the view"),
            ("/camera/vertical_fov", json!(180), 3, "camera.vertical_fov: 180 is not in 0.01 to 170"),
            ("/camera/width", json!(0), 3, "camera.width: 0 is not in 1 to 16384"),
            ("/camera/height", json!(-8), 3, "camera.height: invalid value: integer `-8`, expected a whole number"),
            ("/light", json!({}), 3, "light: expected exactly one of the choices that the schema lists"),
            (
                "/light",
                json!({ "procedural": { "kind": "sky" }, "environment": { "file": "x.exr" } }),
                3,
                "light: expected exactly one of the choices",
            ),
            (
                "/light/procedural/kind",
                json!("dawn"),
                3,
                "light.procedural.kind: unknown variant `dawn`, expected one of",
            ),
            ("/light/procedural/scale", json!(0), 3, "light.procedural.scale: 0 is not at least 1e-9"),
            ("/materials", json!({}), 3, "objects[0].material: no material \"grey\"; there are no materials"),
            ("/materials/grey/source", json!({ "phong": 1 }), 3, "materials.grey.source: unknown variant `phong`"),
            (
                "/materials/grey/source",
                json!({ "lambert": [0, 2, 0] }),
                3,
                "materials.grey.source.lambert[1]: 2 is not in 0 to 1",
            ),
            (
                "/materials/grey/source",
                json!({ "ggx": { "rho_d": [0, 0, 0], "rho_s": [1, 1, 1], "alpha": 0 } }),
                3,
                "materials.grey.source.ggx.alpha: 0 is not in 0.0001 to 10",
            ),
            (
                "/materials/grey/source",
                json!({ "embedded": "red-satn" }),
                3,
                "materials.grey.source.embedded: no embedded material red-satn; choose one of gold-metallic-paint,",
            ),
            (
                "/materials/grey/source",
                json!({ "measured": { "file": "x.binary", "sample_position": "top" } }),
                3,
                "materials.grey.source.measured.sample_position: unknown variant `top`, expected `edge` or `centre`",
            ),
            (
                "/materials/grey/atlas",
                json!("x.png"),
                3,
                "materials.grey.atlas: \"x.png\" does not end in .ktx2 or .exr",
            ),
            (
                "/materials/grey/albedo",
                json!({ "constant": [0, 0, -1] }),
                3,
                "materials.grey.albedo.constant[2]: -1 is not in 0 to 1000000",
            ),
            ("/objects", json!([]), 3, "objects: there is nothing to see; add an object"),
            ("/objects/0", json!(3), 3, "objects[0]: invalid type: integer `3`, expected an object"),
            (
                "/objects/0/material",
                json!("red"),
                3,
                "objects[0].material: no material \"red\"; the only material is grey",
            ),
            ("/objects/0/scale", json!(-1), 3, "objects[0].scale: -1 is not at least 1e-9"),
            (
                "/objects/0/mesh",
                json!("plane"),
                3,
                "objects[0].mesh.plane: expected an object with that name as its one member",
            ),
            ("/objects/0/mesh", json!({ "cube": {} }), 3, "objects[0].mesh: unknown variant `cube`, expected one of"),
            ("/objects/0/mesh", json!({ "torus": { "tube": 2 } }), 3, "objects[0].mesh.torus.tube: 2 is not below 1"),
            (
                "/objects/0/mesh",
                json!({ "file": { "path": "x.stl" } }),
                3,
                "objects[0].mesh.file.path: \"x.stl\" does not end in .obj or .gltf or .glb",
            ),
        ],
    );
}

#[test]
fn lists_of_lights() {
    let place = workplace();
    let rect = |member: &str, value: Value| {
        let mut rect = json!({ "corner": [0, 0, 2], "edges": [[1, 0, 0], [0, 1, 0]], "radiance": [1, 1, 1] });
        rect[member] = value;
        json!([{ "rect": rect }])
    };
    let sky = json!({ "procedural": { "kind": "sky" } });
    let cases = [
        (json!([]), "lights: is empty; add a light"),
        (json!({}), "lights: invalid type: map, expected a sequence"),
        (json!([{}]), "lights[0]: expected exactly one of the choices that the schema lists"),
        (json!(["rect"]), "lights[0].rect: expected an object with that name as its one member"),
        (
            json!([{ "spot": {} }]),
            "lights[0]: unknown variant `spot`, expected one of `environment`, `procedural`, `rect`",
        ),
        (json!([sky, sky]), "lights[1]: is a second environment or procedural light; at most one can be used"),
        (
            json!([{ "environment": { "file": "x.png" } }]),
            "lights[0].environment.file: \"x.png\" does not end in .exr or .hdr",
        ),
        (json!([{ "rect": {} }]), "lights[0].rect: missing field `corner`"),
        (rect("colour", json!(1)), "lights[0].rect.colour: unknown field `colour`, expected one of `corner`"),
        (rect("corner", json!([0, 2e9, 0])), "lights[0].rect.corner[1]: 2e9 is not within -1e9 to 1e9"),
        (rect("edges", json!([[1, 0, 0]])), "lights[0].rect.edges: invalid length 1, expected an array of length 2"),
        (rect("edges", json!([[1, 0, 0], [0, 0, 0]])), "lights[0].rect.edges[1]: has no length"),
        (
            rect("edges", json!([[1, 0, 0], [1, 1, 0]])),
            "lights[0].rect.edges: make an angle of 45.000 degrees instead of 90",
        ),
        (
            rect("edges", json!([[1, 0, 0], [2, 0, 0]])),
            "lights[0].rect.edges: make an angle of 0.000 degrees instead of 90",
        ),
        (rect("radiance", json!([1, -1, 1])), "lights[0].rect.radiance[1]: -1 is not in 0 to 1000000000"),
        (
            rect("radiance", json!([1, 1, 1e15])),
            "lights[0].rect.radiance[2]: 1000000000000000 is not in 0 to 1000000000",
        ),
        (
            rect("radiance", json!("bright")),
            "lights[0].rect.radiance: invalid type: string \"bright\", expected an array",
        ),
    ];
    let mut lines = Vec::new();
    let mut put = |scene: Value, part: &str| {
        let name = format!("{}.json", lines.len());
        place.put(&name, scene.to_string());
        lines.push((format!("render {name} -o x.exr"), 3, format!(": {name}: {part}")));
    };
    for (lights, part) in cases {
        let mut scene = good();
        scene.as_object_mut().unwrap().remove("light");
        scene["lights"] = lights;
        put(scene, part);
    }
    let mut both = good();
    both["lights"] = json!([both["light"].clone()]);
    put(both, "lights: cannot stand beside light; put all lights into the list");
    let mut none = good();
    none.as_object_mut().unwrap().remove("light");
    put(none, "there is neither light nor lights; add one of the two");
    let infinite = good().to_string().replace(
        r#""light":{"procedural":{"kind":"uniform"}}"#,
        "\"lights\":[{\"rect\":{\"corner\":[0,0,2],\"edges\":[[1,0,0],[0,1,0]],\"radiance\":[1,1e999,1]}}]",
    );
    place.put("infinite.json", infinite);
    lines.push((
        "render infinite.json -o x.exr".to_owned(),
        3,
        ": infinite.json: lights[0].rect.radiance[1]: number out of range".to_owned(),
    ));
    let lines: Vec<_> = lines.iter().map(|(line, code, part)| (line.as_str(), *code, part.as_str())).collect();
    check(&place, &lines);
}

/// There is no map of a light that does not exist.
#[test]
fn a_light_map_needs_an_environment() {
    let place = workplace();
    let mut scene = good();
    scene.as_object_mut().unwrap().remove("light");
    let rect = json!({ "corner": [0, 0, 2], "edges": [[0, 1, 0], [1, 0, 0]], "radiance": [1, 1, 1] });
    scene["lights"] = json!([{ "rect": rect }]);
    place.put("lamp.json", scene.to_string());
    let message = ": lamp.json: lights: --light-map needs an environment or procedural light among them";
    check(&place, &[("render lamp.json -o x.exr --light-map map.exr", 3, message)]);
}

#[test]
fn references_and_targets() {
    let place = workplace();
    place.put("good.json", good().to_string());
    let image = plain(8, 8, |_, _| [1.0; 3]);
    place.put("small.exr", plain(8, 7, |_, _| [1.0; 3]));
    place.put("cut.exr", &image[..image.len() - 50]);
    place.put("text.exr", "an image");
    place.put("nan.exr", plain(8, 8, |x, _| [x as f32, f32::NAN, 0.0]));
    place.put("folder/x", "");
    let cases = [
        ("-o x.exr --reference gone.exr", 2, "gone.exr: no such file; check the path"),
        ("-o x.exr --reference small.exr", 3, "small.exr: 8 x 7 pixels where 8 x 8 are expected; render both images"),
        ("-o x.exr --reference cut.exr", 3, "cut.exr: unreadable OpenEXR image"),
        ("-o x.exr --reference text.exr", 3, "text.exr: unreadable OpenEXR image"),
        ("-o x.exr --reference nan.exr", 3, "nan.exr: channel G is NaN at column 0, row 0"),
        ("-o x.exr --materials gone", 2, "gone: no such folder; check --materials"),
        ("-o folder", 2, "folder: is a folder; name a file with -o"),
        ("-o gone/x.exr", 2, "gone/x.exr: its folder does not exist"),
        ("-o x.exr --png gone/x.png", 2, "gone/x.png: its folder does not exist"),
        ("-o x.exr --stats folder", 2, "folder: is a folder"),
        ("-o -", 1, "images cannot be written to standard output"),
        ("-o good.json", 1, "good.json: would be overwritten"),
        ("-o x.exr --png x.exr", 1, "x.exr: is named for two outputs"),
        ("-o small.exr --reference small.exr", 1, "small.exr: would be overwritten"),
        ("", 1, "--output <IMAGE.exr>"),
        ("-o x.exr --mode fast", 1, "invalid value 'fast' for '--mode"),
        ("-o x.exr --layers depth", 1, "invalid value 'depth' for '--layers"),
        ("-o x.exr --spp 0", 1, "--spp 0: must lie above 0"),
        ("-o x.exr --spp 4 --target-error 0.1", 1, "cannot be used with"),
        ("-o x.exr --mode reference --target-error 0.1", 1, "--target-error cannot be used with --mode reference"),
        ("-o x.exr --prefilter -1", 1, "--prefilter -1: must be never, always, or a number from 0"),
        ("-o x.exr --pilot-samples 3", 1, "3 is not in 4..=4096"),
        ("-o x.exr --frames 0", 1, "0 is not in 1..=1000000"),
        ("-o x.exr --exposure -1", 1, "--exposure -1: must be above 0"),
        ("-o x.exr --sampling-rate nan", 1, "--sampling-rate NaN: must lie from 0.01 to 100"),
    ]
    .map(|(options, code, part)| (format!("render good.json {options}"), code, part));
    check(&place, &cases.each_ref().map(|(line, code, part)| (line.as_str(), *code, *part)));
}

#[test]
fn files_of_materials_are_looked_for_in_two_places() {
    let place = workplace();
    place.put("fits/paint.json", result(&GLOSSY));
    place.put("there.json", {
        let mut scene = good();
        scene["materials"]["grey"]["source"] = json!({ "fit": "paint.json" });
        scene.to_string()
    });
    check(&place, &[("render there.json -o x.exr", 2, "materials.grey.source.fit: paint.json: no such file")]);
    // the fit is in the folder, its atlas beside the scene
    place.succeed("render there.json -o x.exr --materials fits --spp 1");
}
