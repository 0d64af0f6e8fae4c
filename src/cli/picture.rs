//! The picture of a fit: both slices, measured and fitted, with the parameters beneath. SVG, self-contained.
//!
//! Drawn by hand rather than by a plotting library: the square root axis of theta_h, the shared logarithmic axis and the
//! table that is at the same time the legend are what makes the picture readable, and the same document gives the same
//! bytes whatever else the process has drawn.

mod axis;
mod svg;

use std::fmt::Write;

use axis::{AngleAxis, LogAxis, Tick};
use brdfit_fit::document::{CHANNELS, ChannelFit, ErrorPanel, FitDocument};
use svg::{escape, indexed, label, label_width, number};

const WIDTH: f64 = 900.0;
const HEIGHT: f64 = 604.0;
const MARGIN: f64 = 28.0;
const TOP: f64 = 100.0;
const BOTTOM: f64 = 424.0;
/// Left edges of the two panels.
const LEFT: [f64; 2] = [78.0, 492.0];
const PANEL_WIDTH: f64 = 380.0;
/// Space between the frame of a panel and the first and last angle.
const INSET: f64 = 8.0;

/// Vermilion, bluish green and blue: still apart for colour-blind readers (Okabe & Ito 2008).
const COLOURS: [&str; 3] = ["#d55e00", "#009e73", "#0072b2"];
/// The lines of R, G and B lie in this order on each other; where they coincide all three remain visible.
const LINE_WIDTHS: [f64; 3] = [2.9, 2.2, 1.5];

/// Draws the slices of a fit. The same document gives the same bytes.
pub(crate) fn draw(document: &FitDocument) -> String {
    let slices = &document.slices;
    let options = &document.options;
    let panels = [
        Panel {
            left: LEFT[0],
            axis: AngleAxis::SquareRoot,
            title: indexed("Retro-reflection, θ", "d", " = 0: the shape of the peak"),
            axis_title: indexed("θ", "h", " in degrees, on a square root axis"),
            cutoff_degrees: options.cutoff_theta_h_degrees,
            angles: &slices.theta_h,
            measured: &slices.measured.theta_h,
            fitted: &slices.fitted.theta_h,
        },
        Panel {
            left: LEFT[1],
            axis: AngleAxis::Linear,
            title: indexed("Mirror direction, θ", "h", " = 0: the Fresnel term"),
            axis_title: indexed("θ", "d", " in degrees"),
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
    table(&mut out, &document.channels, document.errors.as_ref());
    out.push_str("</svg>\n");
    out
}

/// Appends formatted text. Writing to a string cannot fail.
macro_rules! put {
    ($out:expr, $($text:tt)*) => {{ let _ = writeln!($out, $($text)*); }};
}

/// One slice: its data and its place.
struct Panel<'a> {
    left: f64,
    axis: AngleAxis,
    title: String,
    axis_title: String,
    cutoff_degrees: f64,
    angles: &'a [f64],
    measured: &'a [Vec<Option<f64>>; 3],
    fitted: &'a [Vec<f64>; 3],
}

impl Panel<'_> {
    fn x(&self, degrees: f64) -> f64 {
        self.left + INSET + self.axis.position(degrees) * (PANEL_WIDTH - 2.0 * INSET)
    }

    fn y(at: f64) -> f64 {
        BOTTOM - at * (BOTTOM - TOP)
    }

    /// Measured values above zero up to an angle.
    fn measured_values(&self, up_to_degrees: f64) -> impl Iterator<Item = f64> + '_ {
        let rows = self.rows(up_to_degrees);
        self.measured.iter().flat_map(move |curve| curve.iter().take(rows).flatten()).copied().filter(|&f| f > 0.0)
    }

    /// Fitted values above zero up to an angle.
    fn fitted_values(&self, up_to_degrees: f64) -> impl Iterator<Item = f64> + '_ {
        let rows = self.rows(up_to_degrees);
        self.fitted.iter().flat_map(move |curve| curve.iter().take(rows)).copied().filter(|&f| f > 0.0)
    }

    fn rows(&self, up_to_degrees: f64) -> usize {
        self.angles.partition_point(|angle| angle.to_degrees() <= up_to_degrees)
    }

    fn has_values_below(&self, values: &LogAxis) -> bool {
        self.measured.iter().flatten().flatten().any(|&value| values.position(value) < 0.0)
    }

    fn draw(&self, out: &mut String, values: &LogAxis, with_labels: bool) {
        put!(out, "<g>");
        self.frame(out, values, with_labels);
        for channel in 0..3 {
            self.points(out, values, channel);
        }
        for channel in 0..3 {
            self.line(out, values, channel);
        }
        put!(out, "</g>");
    }

    fn frame(&self, out: &mut String, values: &LogAxis, with_labels: bool) {
        let (left, right) = (self.left, self.left + PANEL_WIDTH);
        put!(
            out,
            r##"<text x="{left:.1}" y="{:.1}" font-size="13" font-weight="600" fill="#222">{}</text>"##,
            TOP - 14.0,
            self.title
        );
        let cutoff = self.x(self.cutoff_degrees);
        put!(
            out,
            r##"<rect x="{cutoff:.1}" y="{TOP}" width="{:.1}" height="{}" fill="#ececec"/>"##,
            right - cutoff,
            BOTTOM - TOP
        );
        let mut grid = String::new();
        let mut marks = String::new();
        for Tick { at, label: text } in self.axis.ticks() {
            let x = self.left + INSET + at * (PANEL_WIDTH - 2.0 * INSET);
            let _ = write!(grid, "M{x:.1} {TOP}V{BOTTOM}");
            let _ = write!(marks, "M{x:.1} {BOTTOM}v5");
            if let Some(text) = &text {
                put!(out, r#"<text x="{x:.1}" y="{:.1}" text-anchor="middle">{}</text>"#, BOTTOM + 19.0, label(text));
            }
        }
        for Tick { at, label: text } in values.ticks() {
            let y = Self::y(*at);
            let _ = write!(marks, "M{left:.1} {y:.1}h{}", if text.is_some() { -5 } else { -3 });
            if let Some(text) = text {
                let _ = write!(grid, "M{left:.1} {y:.1}H{right:.1}");
                if with_labels {
                    let x = left - 9.0 - label_width(text);
                    put!(out, r#"<text x="{x:.1}" y="{:.1}">{}</text>"#, y + 4.0, label(text));
                }
            }
        }
        put!(out, r##"<path d="{grid}" stroke="#d9d9d9" stroke-width=".8" fill="none"/>"##);
        put!(out, r##"<path d="{marks}" stroke="#666" fill="none"/>"##);
        put!(
            out,
            r##"<rect x="{left:.1}" y="{TOP}" width="{PANEL_WIDTH}" height="{}" fill="none" stroke="#666"/>"##,
            BOTTOM - TOP
        );
        put!(
            out,
            r#"<text x="{left:.1}" y="{:.1}" font-size="13">{}</text>"#,
            BOTTOM + 40.0,
            self.axis_title
        );
        if with_labels {
            put!(
                out,
                r#"<text transform="translate(26 {:.1}) rotate(-90)" text-anchor="middle" font-size="13">BRDF in 1/sr</text>"#,
                (TOP + BOTTOM) / 2.0
            );
        }
    }

    fn points(&self, out: &mut String, values: &LogAxis, channel: usize) {
        let colour = COLOURS[channel];
        let mut shapes = String::new();
        let mut below = String::new();
        for (angle, value) in self.angles.iter().zip(&self.measured[channel]) {
            let Some(value) = value else { continue };
            let x = self.x(angle.to_degrees());
            match values.position(*value) {
                at if at < 0.0 => below_axis_marker(&mut below, x, BOTTOM - 2.0),
                at if at <= 1.0 => marker(&mut shapes, channel, x, Self::y(at)),
                _ => {}
            }
        }
        put!(out, r#"<path d="{shapes}" fill="{colour}" fill-opacity=".45"/>"#);
        if !below.is_empty() {
            put!(out, r#"<path d="{below}" fill="none" stroke="{colour}" stroke-opacity=".7"/>"#);
        }
    }

    fn line(&self, out: &mut String, values: &LogAxis, channel: usize) {
        let points: Vec<[f64; 2]> = self
            .angles
            .iter()
            .zip(&self.fitted[channel])
            .map(|(angle, value)| [self.x(angle.to_degrees()), values.position(*value)])
            .collect();
        let mut path = String::new();
        let mut pen_at = None;
        for pair in points.windows(2) {
            let Some([from, to]) = inside(pair[0], pair[1]) else { continue };
            if pen_at != Some(from) {
                let _ = write!(path, "M{:.1} {:.1}", from[0], Self::y(from[1]));
            }
            let _ = write!(path, "L{:.1} {:.1}", to[0], Self::y(to[1]));
            pen_at = Some(to);
        }
        let (colour, width) = (COLOURS[channel], LINE_WIDTHS[channel]);
        put!(
            out,
            r#"<path d="{path}" fill="none" stroke="{colour}" stroke-width="{width}" stroke-linejoin="round"/>"#
        );
    }
}

/// The part of a piece of line whose height lies in [0, 1].
fn inside(from: [f64; 2], to: [f64; 2]) -> Option<[[f64; 2]; 2]> {
    if !(from[1].is_finite() && to[1].is_finite()) {
        return None;
    }
    let at = |share: f64| [0, 1].map(|axis: usize| from[axis] + share * (to[axis] - from[axis]));
    let (low, high) = (from[1].min(to[1]), from[1].max(to[1]));
    if low >= 0.0 && high <= 1.0 {
        return Some([from, to]);
    }
    if high < 0.0 || low > 1.0 {
        return None;
    }
    let share = |height: f64| ((height - from[1]) / (to[1] - from[1])).clamp(0.0, 1.0);
    let (x, y) = (share(0.0), share(1.0));
    Some([at(x.min(y)), at(x.max(y))])
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

/// The shape of a measured value: a disc, a square or a triangle around (x, y).
fn marker(path: &mut String, channel: usize, x: f64, y: f64) {
    let _ = match channel {
        0 => write!(path, "M{:.1} {y:.1}a2.3 2.3 0 1 0 4.6 0a2.3 2.3 0 1 0 -4.6 0z", x - 2.3),
        1 => write!(path, "M{:.1} {:.1}h4.2v4.2h-4.2z", x - 2.1, y - 2.1),
        _ => write!(path, "M{x:.1} {:.1}l2.7 4.6h-5.4z", y - 2.9),
    };
}

/// An arrow head that points down: the value is below the axis.
fn below_axis_marker(path: &mut String, x: f64, y: f64) {
    let _ = write!(path, "M{:.1} {:.1}l2 3.5l2 -3.5", x - 2.0, y - 3.5);
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
        r##"<text x="{:.1}" y="42" text-anchor="end" fill="#666">two-step fit of the SGD model, samples at the bin's {}</text>"##,
        WIDTH - MARGIN,
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
fn table(out: &mut String, channels: &[ChannelFit], errors: Option<&ErrorPanel>) {
    let top = BOTTOM + 98.0;
    let mut columns: Vec<(String, Vec<f64>)> = [
        (indexed("ρ", "d", ""), channels.iter().map(|channel| channel.parameters.rho_d).collect()),
        (indexed("ρ", "s", ""), channels.iter().map(|channel| channel.parameters.rho_s).collect()),
        ("α".to_owned(), channels.iter().map(|channel| channel.parameters.alpha).collect()),
        ("p".to_owned(), channels.iter().map(|channel| channel.parameters.p).collect()),
        (indexed("F", "0", ""), channels.iter().map(|channel| channel.parameters.f0).collect()),
        (indexed("F", "1", ""), channels.iter().map(|channel| channel.parameters.f1).collect()),
    ]
    .into();
    if let Some(errors) = errors {
        columns.extend([
            ("E".to_owned(), errors.e.to_vec()),
            ("L".to_owned(), errors.l.to_vec()),
            ("C".to_owned(), errors.c.to_vec()),
        ]);
    }
    let first = LEFT[0] + 70.0;
    let pitch = (WIDTH - MARGIN - first) / columns.len() as f64;
    for (row, name) in CHANNELS.iter().enumerate().take(channels.len()) {
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
    put!(
        out,
        r##"<path d="M{:.1} {:.1}H{:.1}" stroke="#bbb" fill="none"/>"##,
        LEFT[0],
        top + 6.0,
        WIDTH - MARGIN
    );
    for (column, (title, values)) in columns.iter().enumerate() {
        let x = first + pitch * (column + 1) as f64;
        put!(out, r##"<text x="{:.1}" y="{top:.1}" fill="#666">{title}</text>"##, x - 13.0);
        for (row, value) in values.iter().enumerate() {
            let y = top + 21.0 * (row + 1) as f64;
            put!(out, r#"<text x="{x:.1}" y="{y:.1}" text-anchor="end">{}</text>"#, number(*value));
        }
    }
}
