//! The index maps and sample positions against golden values made with 40 digits by an independent reader
//! (`scripts/fixtures/make_index.py`).

use std::path::Path;

use brdfit_measured::{CHANNEL_SCALE, Dimensions, Grid, SamplePosition, cosines};
use serde_json::Value;

fn golden() -> Value {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../data-fixtures/index.json");
    let text = std::fs::read_to_string(&path).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
    serde_json::from_str(&text).unwrap()
}

fn rows<'a>(golden: &'a Value, name: &str) -> &'a [Value] {
    let rows = golden[name].as_array().unwrap();
    assert!(!rows.is_empty());
    rows
}

fn integer(value: &Value) -> usize {
    usize::try_from(value.as_u64().unwrap()).unwrap()
}

#[test]
fn queries_fall_into_the_golden_cells() {
    let golden = golden();
    let rows = rows(&golden, "queries");
    assert!(rows.len() >= 100);
    for row in rows {
        let [theta_h, theta_d, phi_d] = [0, 1, 2].map(|n| row[n].as_f64().unwrap());
        for (dimensions, at) in [(Dimensions::HALF_TURN, 5), (Dimensions::FULL_TURN, 7)] {
            let bins = (dimensions.theta_h_bin(theta_h), dimensions.theta_d_bin(theta_d), dimensions.phi_d_bin(phi_d));
            assert_eq!(bins, (integer(&row[3]), integer(&row[4]), integer(&row[at])), "{row}");
            let cell = dimensions.index(bins.0, bins.1, bins.2);
            assert_eq!(cell, integer(&row[at + 1]), "{row}");
            assert_eq!(dimensions.bins(cell), bins);
        }
    }
}

#[test]
fn samples_lie_where_the_golden_values_say() {
    let golden = golden();
    for row in rows(&golden, "samples") {
        let position: SamplePosition = serde_json::from_value(row[0].clone()).unwrap();
        let [h, d, p] = [1, 2, 3].map(|n| integer(&row[n]));
        let [theta_h, theta_d, phi_d, cos_i, cos_o] = [4, 5, 6, 7, 8].map(|n| row[n].as_f64().unwrap());
        let grid = Dimensions::HALF_TURN;
        let ours = [grid.theta_h_sample(h, position), grid.theta_d_sample(d, position), grid.phi_d_sample(p, position)];
        for (ours, exact) in ours.iter().zip([theta_h, theta_d, phi_d]) {
            assert!((ours - exact).abs() <= 4.0 * f64::EPSILON * exact, "{row}: {ours}");
        }
        let from_cells = Grid::new(grid, position).cosines(grid.index(h, d, p));
        for (i, o) in [cosines(ours[0], ours[1], ours[2]), from_cells] {
            assert!((i - cos_i).abs() < 1e-15 && (o - cos_o).abs() < 1e-15, "{row}: {i} {o}");
        }
    }
}

#[test]
fn channel_scales_are_the_golden_ones() {
    let golden = golden();
    let scales: Vec<f64> = rows(&golden, "channel_scales").iter().map(|v| v.as_f64().unwrap()).collect();
    assert_eq!(scales, CHANNEL_SCALE);
}
