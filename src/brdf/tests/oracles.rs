//! The model against vectors that mpmath computed from the printed definitions (`scripts/fixtures/make_*.py`). Each test prints the
//! largest error that it saw: those are the figures of docs/accuracy.md.

use brdfit_brdf::direction;
use brdfit_brdf::{
    Configuration, G1Curve, HalfDifference, Sgd, SgdParameters, ShiftedGamma, directional_albedo, ln_upper_gamma,
    upper_gamma,
};
use serde_json::Value;

fn fixture(name: &str) -> Value {
    let path = format!("{}/../../data-fixtures/{name}", env!("CARGO_MANIFEST_DIR"));
    let text = std::fs::read_to_string(&path).unwrap_or_else(|error| panic!("{path}: {error}"));
    serde_json::from_str(&text).unwrap()
}

fn numbers(row: &Value) -> Vec<f64> {
    row.as_array().unwrap().iter().map(|number| number.as_f64().unwrap()).collect()
}

fn rows(value: &Value) -> Vec<Vec<f64>> {
    value.as_array().unwrap().iter().map(numbers).collect()
}

#[test]
fn upper_incomplete_gamma() {
    let fixture = fixture("gamma.json");
    let (mut value_error, mut log_error, mut slope_error): (f64, f64, f64) = (0.0, 0.0, 0.0);
    let vectors = rows(&fixture["rows"]);
    assert!(vectors.len() > 1000);
    for row in vectors {
        let [s, x, value, slope] = row[..] else { panic!("row of {} numbers", row.len()) };
        let (ln, by_s) = ln_upper_gamma(s, x);
        value_error = value_error.max((upper_gamma(s, x) / value - 1.0).abs());
        log_error = log_error.max((ln - value.ln()).abs() / value.ln().abs().max(1.0));
        slope_error = slope_error.max((by_s - slope).abs() / slope.abs().max(1.0));
    }
    println!("Gamma(s, x): relative error {value_error:.1e}, of ln {log_error:.1e}, of d ln/ds {slope_error:.1e}");
    assert!(value_error < 1e-13 && log_error < 1e-13 && slope_error < 1e-12);
    for row in rows(&fixture["large_rows"]) {
        let [s, x, ln] = row[..] else { panic!() };
        assert!((ln_upper_gamma(s, x).0 - ln).abs() < 1e-13 * ln.abs().max(1.0), "s {s} x {x}");
    }
}

fn parameters(object: &Value) -> SgdParameters {
    let p = |name: &str| object[name].as_f64().unwrap();
    SgdParameters { rho_d: p("rho_d"), rho_s: p("rho_s"), alpha: p("alpha"), p: p("p"), f0: p("f0"), f1: p("f1") }
}

fn sets() -> Vec<(String, SgdParameters, Value)> {
    let fixture = fixture("sgd.json");
    let sets = fixture["sets"].as_array().unwrap();
    assert!(sets.len() >= 20);
    sets.iter()
        .map(|set| (set["name"].as_str().unwrap().to_owned(), parameters(&set["parameters"]), set.clone()))
        .collect()
}

#[test]
fn distribution_and_fresnel() {
    let (mut k_error, mut d_error, mut f_error): (f64, f64, f64) = (0.0, 0.0, 0.0);
    for (name, parameters, set) in sets() {
        let distribution = ShiftedGamma::new(parameters.alpha, parameters.p).unwrap();
        k_error = k_error.max((distribution.k() / set["K"].as_f64().unwrap() - 1.0).abs());
        for row in rows(&set["D"]) {
            let (value, expected) = (distribution.d_at(row[0]), row[1]);
            if expected > 1e-290 {
                // a relative error of e^-a grows with a: measure it in units of the exponent
                let scale = 1.0 + expected.ln().abs();
                d_error = d_error.max((value / expected - 1.0).abs() / scale);
            } else {
                assert!(value < 1e-280, "{name}");
            }
        }
        for row in rows(&set["F"]) {
            f_error = f_error.max((parameters.fresnel().value(row[0].cos()) - row[1]).abs() / (1.0 + row[1].abs()));
        }
    }
    println!("K: {k_error:.1e}, D: {d_error:.1e} per unit of its logarithm, F: {f_error:.1e}");
    assert!(k_error < 1e-13 && d_error < 1e-13 && f_error < 1e-14);
}

#[test]
fn smith_masking() {
    let (mut exact_error, mut curve_error): (f64, f64) = (0.0, 0.0);
    for (name, parameters, set) in sets() {
        let sgd = Sgd::new(parameters).unwrap();
        let curve = G1Curve::new(sgd.distribution());
        for row in rows(&set["G1"]) {
            exact_error = exact_error.max((sgd.smith().g1(row[0]) / row[1] - 1.0).abs());
            curve_error = curve_error.max((curve.g1(row[0]) / row[1] - 1.0).abs());
            assert!(
                (sgd.smith().g1(row[0]) / row[1] - 1.0).abs() < 1e-9,
                "{name} at {}: {} {}",
                row[0],
                sgd.smith().g1(row[0]),
                row[1]
            );
        }
    }
    println!("G1: relative error of the quadrature {exact_error:.1e}, of the tabulated curve {curve_error:.1e}");
    assert!(exact_error < 1e-11 && curve_error < 5e-8);
}

#[test]
fn values_and_derivatives() {
    let mut value_error: f64 = 0.0;
    let mut slope_errors = [0.0_f64; 6];
    for (_, parameters, set) in sets() {
        let sgd = Sgd::new(parameters).unwrap();
        for row in rows(&set["f"]) {
            let at = Configuration::from(HalfDifference { theta_h: row[0], theta_d: row[1], phi_d: row[2] });
            let (value, gradient) = sgd.value_and_gradient(&at);
            value_error = value_error.max((value / row[3] - 1.0).abs());
            value_error = value_error.max((sgd.value(&at) / row[3] - 1.0).abs());
            // d/d alpha vanishes at the knee of the lobe: measured against f / alpha there
            let floors = [0.0, 0.0, row[3] / parameters.alpha, 0.0, 0.0, 0.0];
            for n in 0..6 {
                let expected = row[4 + n];
                let scale = expected.abs().max(floors[n]);
                if scale > 1e-200 {
                    slope_errors[n] = slope_errors[n].max((gradient[n] - expected).abs() / scale);
                }
            }
        }
    }
    println!(
        "f: {value_error:.1e}, df/d(rho_d, rho_s, alpha, p, f0, f1): {:?}",
        slope_errors.map(|error| format!("{error:.1e}"))
    );
    assert!(value_error < 1e-10 && slope_errors.iter().all(|&error| error < 1e-9));
}

#[test]
fn half_and_difference_angles() {
    let fixture = fixture("index.json");
    let vectors = fixture["directions"].as_array().unwrap();
    assert!(vectors.len() >= 40);
    let mut worst: f64 = 0.0;
    for vector in vectors {
        let at = |n: usize| vector[n].as_f64();
        let polar = |n: usize| direction(at(n).unwrap(), at(n + 1).unwrap());
        let angles = HalfDifference::from_directions(&polar(0), &polar(2));
        let phi_d = at(6).map_or(0.0, |expected| libm::remainder(angles.phi_d - expected, std::f64::consts::TAU).abs());
        // an angle is as well determined as the circle that it turns on is wide
        let width = libm::sin(angles.theta_d);
        worst = worst.max((angles.theta_h - at(4).unwrap()).abs());
        worst = worst.max((angles.theta_d - at(5).unwrap()).abs());
        worst = worst.max(phi_d * width);
    }
    println!("half and difference angles: {worst:.1e} rad");
    assert!(worst < 1e-13);
}

#[test]
fn albedo() {
    let fixture = fixture("albedo.json");
    let mut worst: f64 = 0.0;
    for row in fixture["rows"].as_array().unwrap() {
        let sgd = Sgd::new(parameters(&row["parameters"])).unwrap();
        let expected = row["albedo"].as_f64().unwrap();
        let value = directional_albedo(
            &sgd,
            &G1Curve::new(sgd.distribution()),
            row["theta_i_degrees"].as_f64().unwrap().to_radians(),
        );
        worst = worst.max((value - expected).abs() / expected.max(1.0));
    }
    println!("directional albedo: {worst:.1e}");
    assert!(worst < 1e-4);
}
