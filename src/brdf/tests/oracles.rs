//! The model against vectors that mpmath computed from the printed definitions (`scripts/fixtures/make_*.py`). Each test prints the
//! largest error that it saw: those are the figures of docs/accuracy.md.

use brdfit_brdf::direction;
use brdfit_brdf::{
    Configuration, Ggx, HalfDifference, Masking, Microfacet, MicrofacetParameters, ModelName, NormalDistribution, Sgd,
    SgdParameters, ShiftedGamma, ln_upper_gamma, upper_gamma,
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
        let curve = sgd.distribution().masking();
        for row in rows(&set["G1"]) {
            exact_error = exact_error.max((sgd.distribution().g1(row[0]) / row[1] - 1.0).abs());
            curve_error = curve_error.max((curve.g1(row[0]) / row[1] - 1.0).abs());
            assert!(
                (sgd.distribution().g1(row[0]) / row[1] - 1.0).abs() < 1e-9,
                "{name} at {}: {} {}",
                row[0],
                sgd.distribution().g1(row[0]),
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
            let mut gradient = [0.0; 6];
            let value = sgd.value_and_gradient(&at, &mut gradient);
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
        let theta_i = row["theta_i_degrees"].as_f64().unwrap().to_radians();
        let value = sgd.directional_albedo(&sgd.distribution().masking(), theta_i);
        worst = worst.max((value - expected).abs() / expected.max(1.0));
    }
    println!("directional albedo: {worst:.1e}");
    assert!(worst < 1e-4);
}

#[test]
fn ggx() {
    let fixture = fixture("ggx.json");
    let [mut d_error, mut g1_error, mut value_error, mut slope_error, mut albedo_error] = [0.0_f64; 5];
    for set in fixture["sets"].as_array().unwrap() {
        let p = |name: &str| set["parameters"][name].as_f64().unwrap();
        let [rho_d, rho_s, alpha, f0, f1] = ["rho_d", "rho_s", "alpha", "f0", "f1"].map(p);
        let model = Microfacet::<Ggx, 1>::new(MicrofacetParameters { rho_d, rho_s, shape: [alpha], f0, f1 }).unwrap();
        let ggx = model.distribution();
        for row in rows(&set["D"]) {
            d_error = d_error.max((ggx.d_at(row[0]) / row[1] - 1.0).abs());
        }
        for row in rows(&set["G1"]) {
            let masking = Masking::g1(&ggx.masking(), row[0]);
            g1_error = g1_error.max((NormalDistribution::g1(ggx, row[0]) / row[1] - 1.0).abs());
            assert_eq!(masking, NormalDistribution::g1(ggx, row[0]));
        }
        for row in rows(&set["f"]) {
            let at = Configuration::from(HalfDifference { theta_h: row[0], theta_d: row[1], phi_d: row[2] });
            let mut gradient = [0.0; 5];
            let value = model.value_and_gradient(&at, &mut gradient);
            value_error = value_error.max((value / row[3] - 1.0).abs()).max((model.value(&at) / row[3] - 1.0).abs());
            for (found, expected) in gradient.iter().zip(&row[4..]) {
                slope_error = slope_error.max((found - expected).abs() / expected.abs().max(row[3]));
            }
        }
        for row in rows(&set["albedo"]) {
            let found = model.directional_albedo(&ggx.masking(), row[0].to_radians());
            albedo_error = albedo_error.max((found - row[1]).abs());
        }
    }
    println!(
        "GGX: D {d_error:.1e}, G1 {g1_error:.1e}, f {value_error:.1e}, df {slope_error:.1e}, albedo {albedo_error:.1e}"
    );
    assert!(d_error < 1e-13 && g1_error < 1e-13 && value_error < 1e-13 && slope_error < 1e-12 && albedo_error < 1e-4);
}

/// Every model's derivatives against central differences of its own values, through what callers see of a model.
#[test]
fn gradients_of_every_model_agree_with_central_differences() {
    let cells: Vec<Configuration> = [(0.02, 0.1, 1.0), (0.2, 0.9, 0.3), (0.6, 0.5, 2.5)]
        .map(|(theta_h, theta_d, phi_d)| HalfDifference { theta_h, theta_d, phi_d }.into())
        .into();
    for name in ModelName::ALL {
        let model = name.model();
        let values: Vec<f64> = model
            .parameters()
            .iter()
            .map(|parameter| match parameter.name {
                "f1" => -0.1,
                _ if parameter.range[1].is_finite() => parameter.range[1].min(1.0) * 0.3,
                _ => 0.4,
            })
            .collect();
        let count = values.len();
        let (mut f, mut gradients) = (vec![0.0; cells.len()], vec![0.0; cells.len() * count]);
        model.channel(&values).unwrap().values_and_gradients(&cells, &mut f, &mut gradients);
        for (n, parameter) in model.parameters().iter().enumerate() {
            let h = 1e-5 * values[n].abs();
            let moved = |by: f64| {
                let mut values = values.clone();
                values[n] += by;
                model.channel(&values).unwrap()
            };
            let (above, below) = (moved(h), moved(-h));
            for (c, at) in cells.iter().enumerate() {
                let expected = (above.value(at) - below.value(at)) / (2.0 * h);
                let found = gradients[c * count + n];
                assert!(
                    (found - expected).abs() < 1e-6 * (expected.abs() + f[c]),
                    "{name}, {} at {at:?}: {found} {expected}",
                    parameter.name
                );
            }
        }
    }
}
