//! The plot of a fit: both slices, measured and fitted, with the parameters beneath. SVG, self-contained.
//!
//! Drawn by hand rather than by a plotting library: the square root axis of theta_h, the shared logarithmic axis and the
//! table that is at the same time the legend are what makes the picture readable, and the same document gives the same
//! bytes whatever else the process has drawn.

mod panel;

use std::fmt::Write;

use brdfit_figures::axis::{AngleAxis, LogAxis};
use brdfit_figures::svg::{escape, indexed, number};
use brdfit_fit::document::{ErrorPanel, FitDocument};
use brdfit_measured::CHANNEL_NAMES;
use panel::{BOTTOM, COLOURS, LINE_WIDTHS, Panel, below_axis_marker, marker};

/// Appends a formatted line. Writing to a string cannot fail.
macro_rules! put {
    ($out:expr, $($text:tt)*) => {{ let _ = writeln!($out, $($text)*); }};
}
use put;

const WIDTH: f64 = 900.0;
const HEIGHT: f64 = 604.0;
const MARGIN: f64 = 28.0;
/// Left edges of the two panels.
const LEFT: [f64; 2] = [78.0, 492.0];

/// Draws the slices of a fit. The same document gives the same bytes.
pub(crate) fn draw(document: &FitDocument) -> String {
    let slices = &document.slices;
    let options = &document.options;
    let panels = [
        Panel {
            left: LEFT[0],
            axis: AngleAxis::SquareRoot,
            title: indexed("Retro-reflection, θ", "d", "= 0: the shape of the peak"),
            axis_title: indexed("θ", "h", "in degrees, on a square root axis"),
            cutoff_degrees: options.cutoff_theta_h_degrees,
            angles: &slices.theta_h,
            measured: &slices.measured.theta_h,
            fitted: &slices.fitted.theta_h,
        },
        Panel {
            left: LEFT[1],
            axis: AngleAxis::Linear,
            title: indexed("Mirror direction, θ", "h", "= 0: the Fresnel term"),
            axis_title: indexed("θ", "d", "in degrees"),
            cutoff_degrees: options.cutoff_theta_d_degrees,
            angles: &slices.theta_d,
            measured: &slices.measured.theta_d,
            fitted: &slices.fitted.theta_d,
        },
    ];
    let [least, most] = value_range(&panels);
    let values = LogAxis::new(least, most);
    let mut out = String::with_capacity(48 << 10);
    head(&mut out, document);
    for (number, panel) in panels.iter().enumerate() {
        panel.draw(&mut out, &values, number == 0);
    }
    legend(&mut out, panels.iter().any(|panel| panel.has_values_below(&values)));
    table(&mut out, document, document.errors.as_ref());
    out.push_str("</svg>\n");
    out
}

/// Smallest and largest value on the axis. Everything up to the cut-offs is on it, but for measured values below a thirtieth
/// of the smallest fitted one (zeros and noise in the dark); beyond the cut-offs values count up to ten times the largest.
fn value_range(panels: &[Panel<'_>; 2]) -> [f64; 2] {
    fn range(values: impl Iterator<Item = f64>) -> [f64; 2] {
        values.fold([f64::INFINITY, 0.0_f64], |[least, most], value| [least.min(value), most.max(value)])
    }
    let fitted = range(panels.iter().flat_map(|panel| panel.fitted_values(panel.cutoff_degrees)));
    let measured = range(panels.iter().flat_map(|panel| panel.measured_values(panel.cutoff_degrees)));
    let anywhere = range(panels.iter().flat_map(|panel| panel.fitted_values(90.0).chain(panel.measured_values(90.0))));
    let most = anywhere[1].min(10.0 * fitted[1].max(measured[1]));
    let least = fitted[0].min(measured[0].max(fitted[0] / 30.0));
    if most > 0.0 && least.is_finite() { [(least / 1.3).max(most * 1e-12), most * 1.3] } else { [0.1, 1.0] }
}

fn head(out: &mut String, document: &FitDocument) {
    let name = escape(&document.input.name);
    put!(
        out,
        r#"<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {HEIGHT}" width="{WIDTH}" height="{HEIGHT}" role="img" font-family="'Helvetica Neue', Helvetica, Arial, 'Liberation Sans', 'DejaVu Sans', sans-serif" font-size="12" fill="{}">"#,
        "#333"
    );
    put!(out, "<title>{name}: measured and fitted slices</title>");
    put!(out, r##"<rect width="{WIDTH}" height="{HEIGHT}" fill="#fff"/>"##);
    put!(out, r##"<text x="{MARGIN}" y="42" font-size="22" font-weight="700" fill="#111">{name}</text>"##);
    put!(
        out,
        r##"<text x="{:.1}" y="42" text-anchor="end" fill="#666">two-step fit of the {} model, samples at the bin's {}</text>"##,
        WIDTH - MARGIN,
        document.model.model().title(),
        document.input.sample_position
    );
}

fn legend(out: &mut String, below: bool) {
    let y = BOTTOM + 68.0;
    let mut x = LEFT[0];
    let mut entry = |out: &mut String, symbol: &dyn Fn(f64) -> String, symbol_width: f64, text: &str, width: f64| {
        put!(out, r#"{}<text x="{:.1}" y="{:.1}">{text}</text>"#, symbol(x), x + symbol_width + 7.0, y + 4.0);
        x += symbol_width + width;
    };
    let dots = |x: f64| {
        let mut all = String::new();
        for channel in 0..3 {
            let mut path = String::new();
            marker(&mut path, channel, x + 3.0 + 8.0 * channel as f64, y);
            let _ = write!(all, r#"<path d="{path}" fill="{}" fill-opacity=".6"/>"#, COLOURS[channel]);
        }
        all
    };
    let line = |x: f64| format!(r##"<path d="M{x:.1} {y:.1}h24" stroke="#444" stroke-width="2.4"/>"##);
    let shade = |x: f64| {
        format!(r##"<rect x="{x:.1}" y="{:.1}" width="20" height="12" fill="#ececec" stroke="#bbb"/>"##, y - 6.0)
    };
    let arrow = |x: f64| {
        let mut path = String::new();
        below_axis_marker(&mut path, x + 4.0, y + 2.0);
        format!(r##"<path d="{path}" fill="none" stroke="#444"/>"##)
    };
    entry(out, &dots, 22.0, &indexed("measured, mean over φ", "d", ""), 190.0);
    entry(out, &line, 24.0, "fitted", 75.0);
    entry(out, &shade, 20.0, "beyond the cut-off, not fitted", 215.0);
    if below {
        entry(out, &arrow, 8.0, "zero, or too dark for the axis", 200.0);
    }
}

/// The parameters of the channels; their symbols and colours make it the legend, too.
fn table(out: &mut String, document: &FitDocument, errors: Option<&ErrorPanel>) {
    let channels = &document.channels;
    let top = BOTTOM + 98.0;
    let of_model = document.model.model().parameters().iter().map(|parameter| {
        let (symbol, index) = parameter.symbol;
        let title = if index.is_empty() { symbol.to_owned() } else { indexed(symbol, index, "") };
        let value = |name: &str, n: usize| channels[n].parameters.get(name).unwrap_or(f64::NAN);
        (title, (0..channels.len()).map(|n| value(parameter.name, n)).collect())
    });
    let mut columns: Vec<(String, Vec<f64>)> = of_model.collect();
    if let Some(errors) = errors {
        columns.extend([
            ("E".to_owned(), errors.e.to_vec()),
            ("L".to_owned(), errors.l.to_vec()),
            ("C".to_owned(), errors.c.to_vec()),
        ]);
    }
    let first = LEFT[0] + 70.0;
    let pitch = (WIDTH - MARGIN - first) / columns.len() as f64;
    for (row, name) in CHANNEL_NAMES.iter().enumerate().take(channels.len()) {
        let y = top + 21.0 * (row + 1) as f64;
        let (x, colour) = (LEFT[0], COLOURS[row]);
        let mut path = String::new();
        marker(&mut path, row, x + 11.0, y - 4.0);
        put!(
            out,
            r#"<path d="M{x:.1} {:.1}h22" stroke="{colour}" stroke-width="{}"/><path d="{path}" fill="{colour}"/><text x="{:.1}" y="{y:.1}" font-weight="600" fill="{colour}">{name}</text>"#,
            y - 4.0,
            LINE_WIDTHS[row],
            x + 32.0
        );
    }
    put!(out, r##"<path d="M{:.1} {:.1}H{:.1}" stroke="#bbb" fill="none"/>"##, LEFT[0], top + 6.0, WIDTH - MARGIN);
    for (column, (title, values)) in columns.iter().enumerate() {
        let x = first + pitch * (column + 1) as f64;
        put!(out, r##"<text x="{:.1}" y="{top:.1}" fill="#666">{title}</text>"##, x - 13.0);
        for (row, value) in values.iter().enumerate() {
            let y = top + 21.0 * (row + 1) as f64;
            put!(out, r#"<text x="{x:.1}" y="{y:.1}" text-anchor="end">{}</text>"#, number(*value));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::{Value, json};

    /// A document with the given name and curves over three angles in each slice.
    fn document(name: &str, measured: Value, fitted: Value) -> FitDocument {
        let step = |name: &str| {
            json!({
                "name": name, "solver": "convex", "rows": 3, "cost": 0.0, "residual_norm": 0.0, "iterations": 0,
                "termination": "gtol", "start": 0, "active_bounds": [], "condition_number": 1.0
            })
        };
        let channel = |name: &str| {
            json!({
                "name": name,
                "parameters": { "rho_d": 0.1, "rho_s": 0.5, "alpha": 0.01, "p": 0.5, "f0": 0.1, "f1": 0.0 },
                "derived": {
                    "K": 1.0, "fr": 0.05, "anchor": 1.0, "albedo": [0.1, 0.1, 0.1, 0.1], "fresnel_range": [0.1, 1.0],
                    "g1": { "lambda": 1.0, "theta0": 0.5, "k": 3.0, "log10_c": 0.0, "max_error": 0.0, "rms_error": 0.0 }
                },
                "standard_errors": {}, "steps": [step("theta_h"), step("theta_d")], "flags": []
            })
        };
        let both = |curve: Value| {
            let three = json!([curve.clone(), curve.clone(), curve]);
            json!({ "theta_h": three.clone(), "theta_d": three })
        };
        let value = json!({
            "schema_version": 1, "program": "test", "model": "sgd",
            "input": { "name": name, "dimensions": [90, 90, 180], "sample_position": "edge" },
            "options": brdfit_fit::RecordedOptions::new(&Default::default(), Default::default()),
            "channels": [channel("R"), channel("G"), channel("B")],
            "slices": {
                "theta_h": [0.0, 0.5, 1.5], "theta_d": [0.0, 0.5, 1.5], "measured": both(measured), "fitted": both(fitted)
            }
        });
        serde_json::from_value(value).unwrap()
    }

    /// The elements of a drawing, which must be well-formed and hold finite numbers only.
    fn elements(svg: &str, name: &str) -> usize {
        let parsed = roxmltree::Document::parse(svg).unwrap();
        assert!(!svg.contains("NaN") && !svg.contains("inf"), "{svg}");
        parsed.descendants().filter(|node| node.has_tag_name(("http://www.w3.org/2000/svg", name))).count()
    }

    #[test]
    fn the_same_document_gives_the_same_bytes() {
        let one = document("x", json!([10.0, 1.0, 0.5]), json!([9.0, 1.1, 0.5]));
        let other = document("y", json!([1.0, 1.0, 1.0]), json!([1.0, 1.0, 1.0]));
        let first = draw(&one);
        let _ = draw(&other);
        assert_eq!(first, draw(&one));
        assert!(elements(&first, "text") > 40);
        assert!(!first.contains("id="), "identifiers would collide where several pictures stand on one page");
    }

    #[test]
    fn names_cannot_break_the_drawing() {
        let svg = draw(&document("a<b>&\"'\u{1}", json!([1.0, 1.0, 1.0]), json!([1.0, 1.0, 1.0])));
        let parsed = roxmltree::Document::parse(&svg).unwrap();
        let title = parsed.descendants().find(|node| node.has_tag_name("title")).and_then(|node| node.text());
        assert_eq!(title, Some("a<b>&\"': measured and fitted slices"));
    }

    #[test]
    fn odd_curves_are_drawn() {
        for (measured, fitted) in [
            (json!([null, null, null]), json!([0.1, 0.1, 0.1])),
            (json!([0.0, 0.0, 0.0]), json!([0.0, 0.0, 0.0])),
            (json!([1.0, 0.0, 1e-30]), json!([-1.0, 1.0, 1e300])),
            (json!([1e7, 1.0, null]), json!([1e-300, 1e7, 1.0])),
        ] {
            let svg = draw(&document("x", measured.clone(), fitted));
            elements(&svg, "path");
            let has_zeros = measured.as_array().unwrap().iter().any(|value| value.as_f64() == Some(0.0));
            assert_eq!(svg.contains("too dark for the axis"), has_zeros, "{measured}");
        }
    }
}
