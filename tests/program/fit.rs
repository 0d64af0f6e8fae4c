//! Fits of synthesised files: what was put in comes out, and the options do what they say.

use serde_json::Value;

use crate::program::{GLOSSY, ROUGH, Workplace, measured};

const NAMES: [&str; 6] = ["rho_d", "rho_s", "alpha", "p", "f0", "f1"];

fn fitted(line: &str) -> Value {
    let place = Workplace::new();
    place.link("glossy.binary", &measured().glossy);
    place.link("rough.binary", &measured().rough);
    serde_json::from_str(&place.succeed(&format!("fit {line}")).stdout).unwrap()
}

/// Largest relative difference between the measured and the fitted curves.
fn curve_error(document: &Value) -> f64 {
    let slices = &document["slices"];
    let mut largest: f64 = 0.0;
    for (slice, cutoff) in [("theta_h", 75.0_f64), ("theta_d", 75.0)] {
        let angles = slices[slice].as_array().unwrap();
        for channel in 0..3 {
            let curve = |which: &str| slices[which][slice][channel].as_array().unwrap().clone();
            for ((angle, measured), fitted) in angles.iter().zip(curve("measured")).zip(curve("fitted")) {
                if let (Some(measured), true) = (measured.as_f64(), angle.as_f64().unwrap() <= cutoff.to_radians()) {
                    largest = largest.max((fitted.as_f64().unwrap() / measured - 1.0).abs());
                }
            }
        }
    }
    largest
}

#[test]
fn the_parameters_of_a_synthetic_file_come_back() {
    for (file, truth) in [("glossy.binary", GLOSSY), ("rough.binary", ROUGH)] {
        let document = fitted(&format!("{file} --constraint free"));
        let error = curve_error(&document);
        assert!(error < 1e-6, "{file}: the curves differ by {error:e}");
        for (channel, truth) in document["channels"].as_array().unwrap().iter().zip(truth) {
            let parameter = |n: usize| channel["parameters"][NAMES[n]].as_f64().unwrap();
            for n in [0, 2, 3] {
                assert!((parameter(n) / truth[n] - 1.0).abs() < 1e-5, "{file} {}: {channel}", NAMES[n]);
            }
            // of the Fresnel term its product with rho_s is determined best: at theta_d = 0 and 60 degrees
            for cos in [1.0, 0.5_f64] {
                let fifth = (1.0 - cos).powi(5);
                let product = |rho_s: f64, f0: f64, f1: f64| rho_s * (f0 - f1 * cos + (1.0 - f0) * fifth);
                let found = product(parameter(1), parameter(4), parameter(5));
                let expected = product(truth[1], truth[4], truth[5]);
                assert!((found / expected - 1.0).abs() < 1e-5, "{file} rho_s F: {found} {expected}");
            }
        }
        let panel = &document["errors"];
        for error in ["E", "L", "C"] {
            assert!(panel[error][1].as_f64().unwrap() < 1e-4, "{file} {error}: {}", panel[error]);
        }
    }
}

#[test]
fn a_document_says_where_it_comes_from() {
    let document = fitted("glossy.binary --joint --cutoff-theta-d 60 --start 0.01,0.3 --start 0.2,0.3");
    assert_eq!(document["program"], format!("brdfit {}", env!("CARGO_PKG_VERSION")));
    assert_eq!(document["input"]["name"], "glossy");
    assert_eq!(document["input"]["dimensions"], serde_json::json!([90, 90, 180]));
    assert_eq!(document["input"]["sha256"].as_str().unwrap().len(), 64);
    let options = &document["options"];
    assert_eq!(options["distribution"], "joint");
    assert_eq!(options["cutoff_theta_d_degrees"], 60.0);
    assert_eq!(options["starts"], serde_json::json!([[0.01, 0.3], [0.2, 0.3]]));
    let alpha: Vec<&Value> = (0..3).map(|c| &document["channels"][c]["parameters"]["alpha"]).collect();
    assert!(alpha[0] == alpha[1] && alpha[1] == alpha[2], "{alpha:?}");
}

#[test]
fn the_preset_is_the_published_procedure() {
    let options = fitted("glossy.binary --constraint paper --no-panel")["options"].clone();
    assert_eq!(options["loss"], "l2");
    assert_eq!(options["constraint"], "free");
    assert_eq!(options["anchor"], "distribution");
    assert_eq!(options["step2_solver"], "levenberg-marquardt");
    assert_eq!(options["cutoff_theta_d_degrees"], 70.0);
    let mixed = fitted("glossy.binary --constraint paper --anchor peak --no-panel")["options"].clone();
    assert_eq!((&mixed["anchor"], &mixed["loss"]), (&Value::from("peak"), &Value::from("l2")));
}

#[test]
fn parts_can_be_left_out() {
    let whole = fitted("rough.binary");
    let no_panel = fitted("rough.binary --no-panel");
    let slices_only = fitted("rough.binary --no-hash");
    assert!(whole["errors"].is_object() && no_panel.get("errors").is_none() && slices_only.get("errors").is_none());
    assert!(no_panel["input"]["sha256"].is_string() && slices_only["input"].get("sha256").is_none());
    assert!(slices_only["input"].get("valid_fraction").is_none());
    assert_eq!(whole["channels"], no_panel["channels"]);
    assert_eq!(whole["channels"], slices_only["channels"]);
}

#[test]
fn cells_that_are_no_numbers_are_refused_or_left_out() {
    let place = Workplace::new();
    let mut bytes = std::fs::read(&measured().rough).unwrap();
    bytes[12 + 8 * 1000..][..8].copy_from_slice(&f64::NAN.to_le_bytes());
    place.put("x.binary", &bytes);
    assert_eq!(place.run("fit x.binary").code, Some(3));
    let document: Value = serde_json::from_str(&place.succeed("fit x.binary --accept-non-finite").stdout).unwrap();
    bytes[12 + 8 * 1000..][..8].copy_from_slice(&(-1.0_f64).to_le_bytes());
    place.put("x.binary", &bytes);
    let unmeasured: Value = serde_json::from_str(&place.succeed("fit x.binary").stdout).unwrap();
    for member in ["channels", "errors", "slices"] {
        assert_eq!(document[member], unmeasured[member], "{member}");
    }
}
