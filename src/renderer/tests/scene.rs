//! Scenes from outside: what is seen against closed forms, files that the tests write, and what wrong scenes are told.

use std::path::Path;

use brdfit_renderer::scene::LightDocument;
use brdfit_renderer::{BACKGROUND, GBuffer, Scene, SceneDocument, SceneError, Vec3};
use serde_json::{Value, json};

type Vec3d = nalgebra::Vector3<f64>;

/// A scene of `objects` of one material, seen from `eye`.
fn scene(eye: [f64; 3], objects: Value) -> Value {
    json!({
        "camera": { "eye": eye, "target": [0, 0, 0], "vertical_fov": 40, "width": 161, "height": 120 },
        "light": { "procedural": { "kind": "uniform" } },
        "materials": {
            "blue": { "source": { "lambert": [0.1, 0.1, 0.9] } },
            "red": { "source": { "ggx": { "rho_d": [0.5, 0, 0], "rho_s": [0.2, 0.2, 0.2], "alpha": 0.1 } } }
        },
        "objects": objects
    })
}

fn read(document: &Value) -> Result<SceneDocument, SceneError> {
    SceneDocument::read(document.to_string().as_bytes())
}

fn gbuffer(document: &Value) -> GBuffer {
    Scene::load(&read(document).unwrap(), Path::new(".")).unwrap().gbuffer()
}

/// The ray through the centre of a pixel by the textbook: the image plane one unit away.
fn ray(document: &Value, x: usize, y: usize) -> (Vec3d, Vec3d) {
    let numbers = |value: &Value| Vec3d::from_iterator(value.as_array().unwrap().iter().map(|x| x.as_f64().unwrap()));
    let camera = &document["camera"];
    let (w, h) = (camera["width"].as_f64().unwrap(), camera["height"].as_f64().unwrap());
    let half = (camera["vertical_fov"].as_f64().unwrap().to_radians() / 2.0).tan();
    let eye = numbers(&camera["eye"]);
    let forward = (numbers(&camera["target"]) - eye).normalize();
    let right = forward.cross(&Vec3d::z()).normalize();
    let up = right.cross(&forward);
    let (sx, sy) = ((2.0 * (x as f64 + 0.5) / w - 1.0) * half * w / h, (1.0 - 2.0 * (y as f64 + 0.5) / h) * half);
    (eye, (forward + right * sx + up * sy).normalize())
}

#[test]
fn a_sphere_is_seen_as_its_closed_form_says() {
    let objects = json!([{ "mesh": { "sphere": { "radius": 0.5 } }, "material": "red", "scale": 2.0, "translate": [0.2, 0.1, -0.1] }]);
    let document = scene([2.0, -3.5, 1.5], objects);
    let seen = gbuffer(&document);
    let centre = Vec3d::new(0.2, 0.1, -0.1);
    let mut inside = 0;
    for y in 0..120 {
        for x in 0..161 {
            let pixel = y * 161 + x;
            let (eye, d) = ray(&document, x, y);
            let along = d.dot(&(centre - eye));
            let beside = (eye + d * along - centre).norm();
            // the chords of the mesh lie up to 3e-5 radii inside
            if beside > 1.0 {
                assert_eq!((seen.material()[pixel], seen.depth()[pixel]), (BACKGROUND, f32::INFINITY));
                assert_eq!((seen.position()[pixel], seen.normal()[pixel]), (Vec3::zeros(), Vec3::zeros()));
                continue;
            } else if beside > 1.0 - 5e-5 {
                continue;
            }
            inside += 1;
            assert_eq!(seen.material()[pixel], 1);
            assert_eq!(seen.albedo()[pixel], [1.0; 3]);
            let t = along - (1.0 - beside * beside).sqrt();
            let position = eye + d * t;
            let normal = position - centre;
            let grazing = -normal.dot(&d);
            let tolerance = 4e-5 / grazing;
            assert!((seen.position()[pixel].cast() - position).norm() < tolerance, "{x} {y}");
            assert!((f64::from(seen.depth()[pixel]) - t).abs() < tolerance);
            assert!((seen.view()[pixel].cast() + d).norm() < 1e-6);
            if grazing > 0.02 {
                assert!((seen.normal()[pixel].cast() - normal).norm() < tolerance, "{x} {y}");
            }
            let facing = seen.normal()[pixel].dot(&seen.view()[pixel]);
            assert!(facing > 0.01 - 1e-6 && (seen.normal()[pixel].norm() - 1.0).abs() < 1e-6);
        }
    }
    assert!(inside > 3000, "{inside}");
    assert!((seen.pixel_angle() - 2.0 * 20f32.to_radians().tan() / 120.0).abs() < 1e-8);
}

#[test]
fn texture_coordinates_of_a_turned_plane_and_its_chequerboard() {
    // a quarter turn about x: what was y is z; the front looks to -y, where the eye is
    let mut document = scene(
        [0.3, -4.0, 0.2],
        json!([{
            "mesh": { "plane": { "size": 3.0 } }, "material": "blue", "rotate": [90, 0, 0], "translate": [0, 0.5, 0.25]
        }]),
    );
    document["materials"]["blue"]["albedo"] =
        json!({ "checker": { "colors": [[0, 0, 0], [1, 0.5, 0.25]], "scale": 3 } });
    let seen = gbuffer(&document);
    let mut dark = 0;
    for y in 0..120 {
        for x in 0..161 {
            let pixel = y * 161 + x;
            let (eye, d) = ray(&document, x, y);
            let p = eye + d * ((0.5 - eye.y) / d.y);
            let uv = [p.x / 3.0 + 0.5, (p.z - 0.25) / 3.0 + 0.5];
            if uv.iter().any(|x| !(1e-5..1.0 - 1e-5).contains(x)) {
                continue;
            }
            assert_eq!(seen.material()[pixel], 0);
            assert!((0..2).all(|k| (f64::from(seen.uv()[pixel][k]) - uv[k]).abs() < 1e-5));
            assert!((seen.normal()[pixel] + Vec3::y()).norm() < 1e-6);
            let [s, t] = uv.map(|x| 3.0 * x);
            if (s - s.round()).abs().min((t - t.round()).abs()) > 1e-4 {
                let odd = (s.floor() + t.floor()) as i64 % 2 != 0;
                assert_eq!(seen.albedo()[pixel], if odd { [1.0, 0.5, 0.25] } else { [0.0; 3] });
                dark += usize::from(!odd);
            }
        }
    }
    assert!(dark > 1000, "{dark}");
}

#[test]
fn normals_of_a_torus_agree_with_its_equation() {
    let seen = gbuffer(&scene(
        [1.0, -3.0, 2.0],
        json!([{ "mesh": { "torus": { "radius": 1.0, "tube": 0.4 } }, "material": "red" }]),
    ));
    let mut pixels = 0;
    for pixel in (0..seen.depth().len()).filter(|&pixel| seen.material()[pixel] == 1) {
        let p: Vec3d = seen.position()[pixel].cast();
        let ring = Vec3d::new(p.x, p.y, 0.0).normalize();
        let normal = p - ring;
        assert!((normal.norm() - 0.4).abs() < 2e-4);
        if seen.normal()[pixel].dot(&seen.view()[pixel]) > 0.02 {
            assert!((seen.normal()[pixel].cast() - normal.normalize()).norm() < 5e-4);
            pixels += 1;
        }
    }
    assert!(pixels > 3000, "{pixels}");
}

#[test]
fn meshes_and_textures_of_files_are_placed() {
    let folder = tempfile::tempdir().unwrap();
    // a square at height 1 over the ground of a file whose y points up
    let obj = "v -1 1 1\nv 1 1 1\nv 1 1 -1\nv -1 1 -1\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nf 1/1 2/2 3/3 4/4\n";
    std::fs::write(folder.path().join("square.obj"), obj).unwrap();
    let picture = image::RgbImage::from_fn(2, 2, |x, y| {
        image::Rgb([if x == 0 { 255 } else { 0 }, if y == 0 { 255 } else { 0 }, 0])
    });
    picture.save(folder.path().join("picture.png")).unwrap();
    let mut document =
        scene([0.0, -0.01, 5.0], json!([{ "mesh": { "file": { "path": "square.obj" } }, "material": "red" }]));
    document["materials"]["red"]["albedo"] = json!({ "texture": { "file": "picture.png" } });
    let seen = Scene::load(&read(&document).unwrap(), folder.path()).unwrap().gbuffer();
    let (_, d) = ray(&document, 80, 60);
    let centre = 60 * 161 + 80;
    assert!((f64::from(seen.depth()[centre]) - 4.0 / -d.z).abs() < 1e-5);
    assert!((seen.normal()[centre] - Vec3::z()).norm() < 1e-6);
    // right in the image is +x is +u, up is +y is -z of the file is +v: the upper left of the picture at the upper left
    let colours = [(55, 35), (105, 35), (55, 85), (105, 85)].map(|(x, y): (usize, usize)| seen.albedo()[y * 161 + x]);
    for (colour, expected) in colours.iter().zip([[1.0, 1.0], [0.0, 1.0], [1.0, 0.0], [0.0, 0.0]]) {
        assert!((colour[0] - expected[0]).abs() < 0.2 && (colour[1] - expected[1]).abs() < 0.2, "{colours:?}");
    }
}

#[test]
fn the_nearer_object_hides_the_other_for_every_number_of_threads() {
    let document = scene(
        [0.0, -5.0, 1.0],
        json!([
            { "mesh": { "torus_knot": {} }, "material": "red" },
            { "mesh": { "plane": { "size": 8 } }, "material": "blue", "translate": [0, 0, -0.8] },
            { "mesh": { "displaced_sphere": { "amplitude": 0.1 } }, "material": "blue", "scale": 0.4, "translate": [0.2, -1.5, 0] }
        ]),
    );
    let document = read(&document).unwrap();
    let with = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| Scene::load(&document, Path::new(".")).unwrap().gbuffer())
    };
    let one = with(1);
    assert_eq!(one, with(2));
    assert!(one.material().contains(&0) && one.material().contains(&1));
    assert!(one.depth()[60 * 161 + 85] < 4.0, "the small sphere is in front");
}

/// The message for the scene that `change` makes of a good one.
fn message(change: impl Fn(&mut Value)) -> String {
    let mut document = scene([0.0, -3.0, 0.0], json!([{ "mesh": { "sphere": {} }, "material": "red" }]));
    change(&mut document);
    let scene = read(&document).and_then(|document| Scene::load(&document, Path::new("no such folder")));
    let error = scene.map(|_| ()).unwrap_err();
    let text = error.to_string();
    assert!(!text.contains('\n'), "{text}");
    assert_eq!(error.is_invalid_input(), !matches!(error, SceneError::Io { .. }));
    text
}

#[test]
fn wrong_values_are_named_with_their_path() {
    type Change = fn(&mut Value);
    let cases: &[(Change, &str)] = &[
        (
            |d| d["objects"][0]["material"] = json!("gold"),
            "objects[0].material: no material \"gold\"; the materials are blue, red",
        ),
        (|d| d["camera"]["target"] = json!([0, -3, 0]), "camera.target: is where the eye is; the camera looks nowhere"),
        (|d| d["camera"]["up"] = json!([0, 2, 0]), "camera.up: is parallel to the view from eye to target"),
        (|d| d["camera"]["up"] = json!([0, 0, 0]), "camera.up: has no length"),
        (|d| d["camera"]["eye"] = json!([0, 1e300, 0]), "camera.eye[1]: 1e300 is not within -1e9 to 1e9"),
        (|d| d["camera"]["vertical_fov"] = json!(180), "camera.vertical_fov: 180 is not in 0.01 to 170"),
        (|d| d["camera"]["width"] = json!(0), "camera.width: 0 is not in 1 to 16384"),
        (|d| d["camera"]["height"] = json!(16385), "camera.height: 16385 is not in 1 to 16384"),
        (
            |d| d["light"] = json!({ "environment": { "file": "a.jpg" } }),
            "light.environment.file: \"a.jpg\" does not end in .exr or .hdr",
        ),
        (|d| d["light"]["procedural"]["scale"] = json!(0), "light.procedural.scale: 0 is not at least 1e-9"),
        (
            |d| d["materials"]["red"]["source"] = json!({ "lambert": [0, 2, 0] }),
            "materials.red.source.lambert[1]: 2 is not in 0 to 1",
        ),
        (
            |d| d["materials"]["red"]["source"]["ggx"]["alpha"] = json!(0),
            "materials.red.source.ggx.alpha: 0 is not in 0.0001 to 10",
        ),
        (
            |d| d["materials"]["red"]["source"] = json!({ "measured": { "file": "" } }),
            "materials.red.source.measured.file: is empty",
        ),
        (
            |d| d["materials"]["red"]["albedo"] = json!({ "checker": { "colors": [[0, 0, 0], [1, -1, 1]] } }),
            "materials.red.albedo.checker.colors[1][1]: -1 is not in 0 to 1000000",
        ),
        (|d| d["objects"] = json!([]), "objects: there is nothing to see; add an object"),
        (
            |d| d["objects"][0]["mesh"] = json!({ "sphere": { "radius": 0 } }),
            "objects[0].mesh.sphere.radius: 0 is not at least 1e-9",
        ),
        (
            |d| d["objects"][0]["mesh"] = json!({ "torus": { "tube": 1.5 } }),
            "objects[0].mesh.torus.tube: 1.5 is not below 1; the surface would meet itself",
        ),
        (
            |d| d["objects"][0]["mesh"] = json!({ "torus_knot": { "p": 4, "q": 6 } }),
            "objects[0].mesh.torus_knot.q: p and q have the common divisor 2; the knot would meet itself",
        ),
        (
            |d| d["objects"][0]["mesh"] = json!({ "torus_knot": { "p": 0 } }),
            "objects[0].mesh.torus_knot.p: 0 is not in 1 to 16",
        ),
        (
            |d| d["objects"][0]["mesh"] = json!({ "displaced_sphere": { "frequency": 5, "octaves": 4 } }),
            "objects[0].mesh.displaced_sphere.frequency: the finest octave has 40, more than 32",
        ),
        (|d| d["objects"][0]["scale"] = json!(-1), "objects[0].scale: -1 is not at least 1e-9"),
        (
            |d| d["objects"][0]["mesh"] = json!({ "file": { "path": "a.stl" } }),
            "objects[0].mesh.file.path: \"a.stl\" does not end in .obj or .gltf or .glb",
        ),
        (
            |d| {
                d["objects"][0]["mesh"]["sphere"]["radius"] = json!(2);
                d["objects"][0]["scale"] = json!(1e9);
            },
            "objects[0].mesh: has vertices farther than 1e9 from the origin",
        ),
    ];
    for (change, expected) in cases {
        assert_eq!(message(change), *expected);
    }
}

#[test]
fn wrong_types_and_members_are_named_with_their_path() {
    type Change = fn(&mut Value);
    let cases: &[(Change, &str)] = &[
        (
            |d| d["objects"][0]["mesh"]["sphere"]["radius"] = json!("big"),
            "objects[0].mesh.sphere.radius: invalid type: string \"big\", expected a number at line 1",
        ),
        (
            |d| d["objects"][0]["mesh"] = json!({ "cube": {} }),
            "objects[0].mesh: unknown variant `cube`, expected one of `sphere`",
        ),
        (|d| d["camera"]["fov"] = json!(40), "camera.fov: unknown field `fov`, expected one of `eye`"),
        (|d| d["camera"]["eye"] = json!([0, 1]), "camera.eye: invalid length 2, expected an array of length 3"),
        (
            |d| d["camera"]["width"] = json!(1.5),
            "camera.width: invalid type: floating point `1.5`, expected a whole number from 0",
        ),
        (|d| d["light"]["procedural"]["kind"] = json!("moon"), "light.procedural.kind: unknown variant `moon`"),
        (
            |d| d["materials"]["red"]["source"]["ggx"]["rho_s"][2] = json!(null),
            "materials.red.source.ggx.rho_s[2]: invalid type: null, expected a number",
        ),
        (
            |d| {
                d.as_object_mut().unwrap().remove("camera");
            },
            "missing field `camera`",
        ),
    ];
    for (change, expected) in cases {
        let message = message(change);
        assert!(message.starts_with(expected), "{message}");
    }
    let twice = format!("{} {{}}", scene([0.0, -3.0, 0.0], json!([{ "mesh": { "sphere": {} }, "material": "red" }])));
    assert!(SceneDocument::read(twice.as_bytes()).unwrap_err().to_string().starts_with("is not valid JSON: trailing"));
}

#[test]
fn missing_and_damaged_files_are_named_with_the_member_that_names_them() {
    let missing = message(|d| d["objects"][0]["mesh"] = json!({ "file": { "path": "bunny.obj" } }));
    let file = Path::new("no such folder").join("bunny.obj").display().to_string();
    assert!(
        missing.starts_with(&format!("objects[0].mesh.file.path: {file}: ")) && missing.ends_with("check the path"),
        "{missing}"
    );

    let folder = tempfile::tempdir().unwrap();
    for (name, bytes, why) in [
        ("a.obj", &b"v 0 0 0\nf 1 2 3\n"[..], "not a valid OBJ file: face vertex index out of bounds"),
        ("a.glb", b"not a glb", "not a valid glTF file: "),
        ("empty.obj", b"# nothing\n", "holds no triangles"),
    ] {
        std::fs::write(folder.path().join(name), bytes).unwrap();
        let document =
            read(&scene([0.0, -3.0, 0.0], json!([{ "mesh": { "file": { "path": name } }, "material": "red" }])))
                .unwrap();
        let error = Scene::load(&document, folder.path()).unwrap_err();
        assert!(error.is_invalid_input());
        let start = format!("objects[0].mesh.file.path: {}: {why}", folder.path().join(name).display());
        assert!(error.to_string().starts_with(&start), "{error}");
    }
    std::fs::write(folder.path().join("a.png"), b"GIF").unwrap();
    let mut document = scene([0.0, -3.0, 0.0], json!([{ "mesh": { "sphere": {} }, "material": "red" }]));
    document["materials"]["blue"]["albedo"] = json!({ "texture": { "file": "a.png" } });
    let error = Scene::load(&read(&document).unwrap(), folder.path()).unwrap_err().to_string();
    assert!(
        error.starts_with("materials.blue.albedo.texture.file: ") && error.contains("a.png: not a usable PNG file: "),
        "{error}"
    );
}

#[test]
fn documents_are_written_as_they_are_read() {
    let mut document = scene([0.0, -3.0, 0.0], json!([{ "mesh": { "torus_knot": { "p": 5 } }, "material": "red" }]));
    document["$schema"] = json!("scene.schema.json");
    document["light"] = json!({ "environment": { "file": "sky.hdr", "rotation": 30 } });
    let once = read(&document).unwrap();
    assert!(
        matches!(&once.light, Some(LightDocument::Environment { rotation, scale, .. }) if *rotation == 30.0 && *scale == 1.0)
    );
    let written = serde_json::to_vec(&once).unwrap();
    assert_eq!(SceneDocument::read(&written).unwrap(), once);
    let schema = serde_json::to_value(SceneDocument::schema()).unwrap();
    assert_eq!(schema["required"], json!(["camera", "materials", "objects"]));
    assert_eq!(schema["oneOf"], json!([{ "required": ["light"] }, { "required": ["lights"] }]));
    assert_eq!(schema["additionalProperties"], json!(false));
}
