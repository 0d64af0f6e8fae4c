//! A model without exponent goes the same way as the first one: into a file, out of it, and on to whatever reads documents.

use std::fs;

use serde_json::{Value, json};

use crate::documents::assert_valid;
use crate::program::{Workplace, measured};
use crate::render::workplace;

/// rho_d, rho_s, alpha, f0, f1 of three channels.
const SATIN: [[f64; 5]; 3] =
    [[0.05, 0.50, 0.15, 0.60, 0.20], [0.10, 0.45, 0.20, 0.50, 0.30], [0.20, 0.40, 0.30, 0.40, 0.20]];

/// A material of the model "ggx" and nothing else.
fn satin() -> Value {
    let channels = SATIN.map(|[rho_d, rho_s, alpha, f0, f1]| {
        json!({ "parameters": { "rho_d": rho_d, "rho_s": rho_s, "alpha": alpha, "f0": f0, "f1": f1 } })
    });
    json!({ "model": "ggx", "channels": channels })
}

#[test]
fn its_own_parameters_come_back() {
    let place = Workplace::new();
    place.put("satin.json", satin().to_string());
    place.succeed("synth satin.json -o satin.binary");
    place.succeed("fit satin.binary --model ggx -o fits");
    let document = place.json("fits/satin.json");
    assert_valid("fit", &document);
    assert_valid("summary", &place.json("fits/summary.json"));
    assert_eq!((&document["model"], &document["options"]["starts"][0]), (&json!("ggx"), &json!([0.1])));
    for (channel, truth) in document["channels"].as_array().unwrap().iter().zip(SATIN) {
        for (name, truth) in ["rho_d", "rho_s", "alpha", "f0", "f1"].iter().zip(truth) {
            let found = channel["parameters"][name].as_f64().unwrap();
            assert!((found / truth - 1.0).abs() < 1e-5, "{name}: {found} {truth}");
        }
        assert!(channel["parameters"].get("p").is_none() && channel["derived"].get("K").is_none());
    }
    for error in ["E", "L", "C"] {
        assert!(document["errors"][error][1].as_f64().unwrap() < 1e-6, "{}", document["errors"][error]);
    }
    // one distribution for channels of three widths costs more
    let joint: Value =
        serde_json::from_str(&place.succeed("fit satin.binary --model ggx --joint --start 0.3").stdout).unwrap();
    assert_eq!(joint["options"]["starts"], json!([[0.3]]));
    let alpha = |c: usize| &joint["channels"][c]["parameters"]["alpha"];
    assert!(alpha(0) == alpha(1) && joint["channels"][0]["steps"][0]["cost"].as_f64().unwrap() > 1e-6);
}

#[test]
fn the_table_has_the_columns_of_the_model() {
    let place = Workplace::new();
    place.link("rough.binary", &measured().rough);
    place.succeed("fit rough.binary --model ggx -o fits --picture");
    let table = fs::read_to_string(place.path("fits/summary.csv")).unwrap();
    let head = table.lines().next().unwrap();
    assert_eq!(head, "name,channel,rho_d,rho_s,alpha,f0,f1,cost_step1,cost_step2,E,L,C,flags,sha256");
    assert!(table.lines().all(|line| line.split(',').count() == 14));
    assert_eq!(place.json("fits/summary.json")["model"], "ggx");
    assert!(fs::read_to_string(place.path("fits/rough.svg")).unwrap().contains("two-step fit of the GGX model"));
    // a fit of another model is no result of this one
    let ran = place.succeed("fit rough.binary -o fits --resume");
    assert_eq!(ran.stderr, "1 fitted: fits/summary.json\n");
    assert!(place.json("fits/summary.json").get("model").is_none());
    assert_eq!(place.json("fits/rough.json")["model"], "sgd");
}

#[test]
fn fits_of_two_models_are_not_compared() {
    let place = Workplace::new();
    place.link("rough.binary", &measured().rough);
    place.succeed("fit rough.binary --model ggx -o ggx");
    place.succeed("fit rough.binary -o sgd");
    place.succeed("compare ggx ggx --two-sided");
    let ran = place.run("compare ggx sgd");
    assert_eq!(ran.code, Some(3));
    assert!(ran.stderr.contains("the model differs") && ran.stderr.contains("ggx, reference sgd"), "{}", ran.stderr);
}

#[test]
fn it_has_an_atlas_and_a_picture() {
    let place = workplace();
    place.put("satin.json", satin().to_string());
    place.succeed("atlas satin.json -o made --max-resolution 256 --formats ktx2");
    let atlas = place.json("made/satin.atlas.json");
    assert_valid("atlas", &atlas);
    assert_eq!((&atlas["source"]["kind"], &atlas["source"]["name"]), (&json!("fit"), &json!("satin")));
    let picture = |name: &str| fs::read(place.path(name)).unwrap();
    let render = |source: Value, options: &str| {
        let mut scene = place.json("scene.json");
        scene["materials"]["paint"] = json!({ "source": source, "atlas": "made/satin.atlas.ktx2" });
        place.put("one.json", scene.to_string());
        place.succeed(&format!("render one.json {options}"));
    };
    render(json!({ "fit": "satin.json" }), "-o satin.exr --spp 16");
    // without Fresnel's term a fit is what a scene describes by hand, where `m` is the old name of alpha
    let by_hand = |name: &str| json!({ "ggx": { "rho_d": [0.1, 0.1, 0.1], "rho_s": [0.5, 0.5, 0.5], name: 0.2 } });
    let channels =
        [0, 1, 2].map(|_| json!({ "parameters": { "rho_d": 0.1, "rho_s": 0.5, "alpha": 0.2, "f0": 1.0, "f1": 0.0 } }));
    place.put("white.json", json!({ "model": "ggx", "channels": channels }).to_string());
    render(by_hand("alpha"), "-o alpha.exr --mode reference --spp 256");
    render(by_hand("m"), "-o m.exr --mode reference --spp 256");
    let white = "-o white.exr --mode reference --spp 256 --seed 5 --reference alpha.exr --stats white.stats.json";
    render(json!({ "fit": "white.json" }), white);
    assert!(picture("alpha.exr") == picture("m.exr") && picture("satin.exr") != picture("alpha.exr"));
    let quality = &place.json("white.stats.json")["quality"];
    assert!(quality["relmse"].as_f64().unwrap() < 2e-3 && quality["psnr"].as_f64().unwrap() > 35.0, "{quality}");
}
