//! The published parameters of 300 channels: their normalisation, and the closed form of G1 for their distributions.

use brdfit_brdf::{G1ClosedForm, G1Curve, SgdParameters, ShiftedGamma};
use brdfit_fit::fit_g1;

#[path = "../../measured/tests/data/folder.rs"]
mod data;

struct Published {
    name: String,
    parameters: SgdParameters,
    k: f64,
    masking: [f64; 3],
}

fn published() -> Option<Vec<Published>> {
    let path = data::genuine()?.join("tables/sgd_published.json");
    let table: serde_json::Value = serde_json::from_slice(&std::fs::read(path).unwrap()).unwrap();
    let mut channels = Vec::new();
    for (name, material) in table.as_object().unwrap() {
        for c in 0..3 {
            let p = |key: &str| material[key][c].as_f64().unwrap();
            channels.push(Published {
                name: format!("{name} {}", ["R", "G", "B"][c]),
                parameters: SgdParameters {
                    rho_d: p("rho_d"),
                    rho_s: p("rho_s"),
                    alpha: p("alpha"),
                    p: p("p"),
                    f0: p("F0"),
                    f1: p("F1"),
                },
                k: p("K"),
                masking: [p("lambda"), p("c"), p("k")],
            });
        }
    }
    assert_eq!(channels.len(), 300);
    Some(channels)
}

#[test]
fn normalisation() {
    let Some(channels) = published() else { return };
    let mut worst: f64 = 0.0;
    for channel in channels {
        let distribution = ShiftedGamma::new(channel.parameters.alpha, channel.parameters.p).unwrap();
        worst = worst.max((distribution.k() / channel.k - 1.0).abs());
    }
    println!("largest relative difference from the published K: {worst:.2e}");
    assert!(worst < 5e-6);
}

#[test]
fn closed_form_of_g1() {
    let Some(channels) = published() else { return };
    let (mut rms, mut largest, mut published_errors): (f64, f64, Vec<f64>) = (0.0, 0.0, Vec::new());
    for channel in channels {
        let curve = G1Curve::new(&ShiftedGamma::new(channel.parameters.alpha, channel.parameters.p).unwrap());
        let fit = fit_g1(&curve).unwrap();
        assert!(fit.rms_error < 4e-4 && fit.max_error < 1e-2, "{}: {fit:?}", channel.name);
        (rms, largest) = (rms.max(fit.rms_error), largest.max(fit.max_error));
        let [lambda, c, k] = channel.masking;
        let theirs = G1ClosedForm::from_published(lambda, c, k);
        let error = |n: u32| {
            let theta = f64::from(n).to_radians();
            (theirs.g1(theta) - curve.g1(theta)).abs()
        };
        published_errors.push((1..90).map(error).fold(0.0, f64::max));
    }
    published_errors.sort_by(f64::total_cmp);
    println!("closed form of G1: largest RMS error {rms:.2e}, largest error {largest:.2e}");
    println!(
        "published closed form, 1 to 89 degrees: median {:.1e}, worst {:.1e}",
        published_errors[150], published_errors[299]
    );
    // theirs is an approximation of the same integral: it can only be this close if ours is right
    assert!(published_errors[150] < 1e-3 && published_errors[299] < 5e-3);
}
