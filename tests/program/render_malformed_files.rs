//! Files that a scene names and that cannot be used: one line with the scene, the member and the file.

use std::fs;

use brdfit_renderer::Film;
use serde_json::{Value, json};

use crate::openexr::plain;
use crate::program::{GLOSSY, Workplace, result};
use crate::render::workplace;
use crate::render_malformed::check_members;

/// Expects an exit code and a message for each file: `wrap` makes the value of the member at `pointer` from the name of a file, which is at `member` then.
fn check_files(
    place: &Workplace,
    pointer: &str,
    member: &str,
    wrap: impl Fn(&str) -> Value,
    cases: &[(&str, i32, &str)],
) {
    let parts: Vec<String> = cases.iter().map(|(file, _, why)| format!("{member}: {file}: {why}")).collect();
    let cases: Vec<_> =
        cases.iter().zip(&parts).map(|((file, code, _), part)| (pointer, wrap(file), *code, part.as_str())).collect();
    check_members(place, &cases);
}

#[test]
fn materials() {
    let place = workplace();
    let good = result(&GLOSSY);
    place.put("empty.json", "");
    place.put("text.json", "alpha: 0.1");
    place.put("two.json", r#"{"channels": [{}, {}]}"#);
    place.put("word.json", good.replace("0.05", "\"0.05\""));
    place.put("domain.json", good.replace("0.05", "-0.05"));
    place.put("later.json", good.replacen('{', "{\"schema_version\": 99, ", 1));
    place.put("folder.json/x", "");
    check_files(
        &place,
        "/materials/grey/source",
        "materials.grey.source.fit",
        |file| json!({ "fit": file }),
        &[
            ("gone.json", 2, "no such file; check the path"),
            ("folder.json", 2, "is a folder; name a file"),
            ("empty.json", 3, "the file is empty (0 bytes), not a fit result"),
            ("text.json", 3, "is not JSON, and thus not a fit result"),
            ("two.json", 3, "is not a fit result (channels[0]: missing field `parameters`"),
            ("word.json", 3, "is not a fit result (channels[0].parameters.rho_d: invalid type: string"),
            ("domain.json", 3, "channels[0].parameters.rho_d = -0.05 is outside of the model's domain"),
            ("later.json", 3, "has schema version 99"),
        ],
    );
    place.put("empty.binary", "");
    place.put("cut.binary", [[90, 90, 180].map(i32::to_le_bytes).concat(), vec![0; 1000]].concat());
    place.put("folder.binary/x", "");
    check_files(
        &place,
        "/materials/grey/source",
        "materials.grey.source.measured.file",
        |file| json!({ "measured": { "file": file } }),
        &[
            ("gone.binary", 2, "no such file; check the path"),
            ("folder.binary", 2, "is a folder, not a measured file"),
            ("empty.binary", 3, "the file is empty (0 bytes)"),
            ("cut.binary", 3, "truncated: 1012 of 34992012 bytes"),
        ],
    );
}

#[test]
fn atlases() {
    let place = workplace();
    let atlas = fs::read(place.path("paint.atlas.ktx2")).unwrap();
    place.put("cut.ktx2", &atlas[..atlas.len() / 2]);
    place.put("text.ktx2", "a texture");
    place.put("EMPTY.KTX2", "");
    place.put("folder.ktx2/x", "");
    place.put("image.exr", plain(4, 4, |_, _| [1.0; 3]));
    place.put("text.EXR", "an image");
    check_files(
        &place,
        "/materials/grey/atlas",
        "materials.grey.atlas",
        |file| json!(file),
        &[
            ("gone.ktx2", 2, "no such file; check the path"),
            ("folder.ktx2", 2, "is a folder; name a file"),
            ("EMPTY.KTX2", 3, "not a KTX2 file (0 bytes"),
            ("text.ktx2", 3, "not a KTX2 file (9 bytes"),
            ("cut.ktx2", 3, "the file is damaged: "),
            ("image.exr", 3, "cannot be used as a bandwidth atlas: 1 parts instead of 7"),
            ("text.EXR", 3, "not an OpenEXR file"),
        ],
    );
}

#[test]
fn albedo_textures() {
    let place = workplace();
    place.put("empty.png", "");
    place.put("text.png", "a picture");
    place.put("folder.png/x", "");
    place.put("cut.png", b"\x89PNG\r\n\x1a\n\0\0\0\rIHDR");
    check_files(
        &place,
        "/materials/grey/albedo",
        "materials.grey.albedo.texture.file",
        |file| json!({ "texture": { "file": file } }),
        &[
            ("gone.png", 2, "no such file; check the path"),
            ("folder.png", 2, "is a folder; check the path"),
            ("empty.png", 3, "not a usable PNG file: "),
            ("text.png", 3, "not a usable PNG file: "),
            ("cut.png", 3, "not a usable PNG file: "),
        ],
    );
}

#[test]
fn lights() {
    let place = workplace();
    let map = plain(16, 8, |_, _| [1.0; 3]);
    place.put("cut.exr", &map[..map.len() - 100]);
    place.put("text.exr", "an image");
    place.put("empty.hdr", "");
    place.put("picture.exr", b"\x89PNG\r\n\x1a\n\0\0\0\rIHDR");
    place.put("folder.exr/x", "");
    place.put("square.exr", plain(8, 8, |_, _| [1.0; 3]));
    let spoilt = |value: f32| plain(16, 8, move |x, y| if (x, y) == (3, 2) { [1.0, value, 1.0] } else { [1.0; 3] });
    place.put("nan.exr", spoilt(f32::NAN));
    place.put("infinite.exr", spoilt(f32::INFINITY));
    place.put("negative.exr", spoilt(-1.0));
    place.put("depth.exr", Film::new(16, 8).scalar("depth", [1.0; 128].into_iter()).to_exr().unwrap());
    place.put("cut.hdr", "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 8 +X 16\n");
    place.put("head.hdr", "#?RADIANCE\n");
    check_files(
        &place,
        "/light",
        "light.environment.file",
        |file| json!({ "environment": { "file": file } }),
        &[
            ("gone.exr", 2, "no such file; check the path"),
            ("folder.exr", 2, "is a folder; check the path"),
            ("text.exr", 3, "neither an OpenEXR nor a Radiance HDR file (its first bytes are other ones)"),
            ("picture.exr", 3, "neither an OpenEXR nor a Radiance HDR file"),
            ("empty.hdr", 3, "neither an OpenEXR nor a Radiance HDR file (it is empty)"),
            ("cut.exr", 3, "the file is damaged: "),
            ("cut.hdr", 3, "the file is damaged: "),
            ("head.hdr", 3, "the file is damaged: "),
            ("square.exr", 3, "cannot be used as an environment map: 8 x 8 pixels"),
            ("depth.exr", 3, "cannot be used as an environment map: it has no channels R, G and B"),
            (
                "nan.exr",
                3,
                "cannot be used as an environment map: invalid radiance: [1.0, NaN, 1.0] at column 3, row 2",
            ),
            ("infinite.exr", 3, "cannot be used as an environment map: invalid radiance: [1.0, inf, 1.0]"),
            ("negative.exr", 3, "cannot be used as an environment map: invalid radiance: [1.0, -1.0, 1.0]"),
        ],
    );
}

#[test]
fn meshes() {
    let place = workplace();
    let triangle = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";
    place.put("empty.obj", "");
    place.put("text.obj", "a cube");
    place.put("index.obj", format!("{triangle}f 1 2 9\n"));
    place.put("word.obj", "v 0 zero 0\n");
    place.put("nan.obj", format!("{}f 1 2 3\n", triangle.replacen('1', "nan", 1)));
    place.put("points.obj", triangle);
    place.put("folder.obj/x", "");
    let mesh = json!({
        "asset": { "version": "2.0" },
        "scenes": [{ "nodes": [0] }],
        "nodes": [{ "mesh": 0 }],
        "meshes": [{ "primitives": [{ "attributes": { "POSITION": 0 } }] }],
        "accessors": [
            { "bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3", "min": [0, 0, 0], "max": [1, 1, 0] }
        ],
        "bufferViews": [{ "buffer": 0, "byteLength": 36 }],
        "buffers": [{ "byteLength": 36, "uri": "triangle.bin" }]
    });
    place.put("triangle.bin", [0; 36]);
    for (name, pointer, value) in [
        ("buffer.gltf", "/buffers/0/uri", json!("gone.bin")),
        ("network.gltf", "/buffers/0/uri", json!("https://example.org/triangle.bin")),
        ("short.gltf", "/buffers/0/uri", json!("data:application/octet-stream;base64,AAAA")),
        ("later.gltf", "/asset/version", json!("3.0")),
        ("scene.gltf", "/scenes", json!([])),
        ("accessor.gltf", "/meshes/0/primitives/0/attributes/POSITION", json!(7)),
        ("beyond.gltf", "/accessors/0/count", json!(300)),
        ("word.gltf", "/nodes/0/mesh", json!("first")),
    ] {
        let mut wrong = mesh.clone();
        *wrong.pointer_mut(pointer).unwrap() = value;
        place.put(name, wrong.to_string());
    }
    place.put("empty.gltf", "");
    place.put("text.gltf", "a cube");
    place.put("head.glb", "glTF");
    place.put("cut.glb", [&b"glTF"[..], &2_u32.to_le_bytes(), &5000_u32.to_le_bytes(), &[0; 30]].concat());
    check_files(
        &place,
        "/objects/0/mesh",
        "objects[0].mesh.file.path",
        |file| json!({ "file": { "path": file } }),
        &[
            ("gone.obj", 2, "no such file; check the path"),
            ("folder.obj", 2, "is a folder; check the path"),
            ("empty.obj", 3, "holds no triangles"),
            ("text.obj", 3, "holds no triangles"),
            ("points.obj", 3, "holds no triangles"),
            ("index.obj", 3, "not a valid OBJ file: face vertex index out of bounds"),
            ("word.obj", 3, "not a valid OBJ file: position parse error"),
            ("nan.obj", 3, "the position of vertex 1 is not finite"),
            ("gone.gltf", 2, "no such file; check the path"),
            ("buffer.gltf", 2, "buffer \"gone.bin\": no such file; check the path"),
            ("network.gltf", 3, "buffer \"https://example.org/triangle.bin\" is not a file beside this one"),
            ("short.gltf", 3, "buffer 0 has 3 of 36 bytes"),
            ("later.gltf", 3, "not a valid glTF file: version \"3.0\" of the format"),
            ("scene.gltf", 3, "holds no scene"),
            ("accessor.gltf", 3, "not a valid glTF file: there is no accessor 7"),
            ("beyond.gltf", 3, "accessor 0 reaches beyond its buffer"),
            ("word.gltf", 3, "not a valid glTF file: invalid type: string \"first\""),
            ("empty.gltf", 3, "not a valid glTF file: EOF"),
            ("text.gltf", 3, "not a valid glTF file: expected"),
            ("head.glb", 3, "not a valid glTF file: its header is cut off"),
            ("cut.glb", 3, "not a valid glTF file: "),
        ],
    );
}
