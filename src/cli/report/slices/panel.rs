//! A panel: one slice with its axes.

use std::fmt::Write;

use brdfit_figures::axis::{AngleAxis, LogAxis, Tick};
use brdfit_figures::svg::{label, label_width};

use crate::report::slices::put;

/// Top and bottom of every panel.
pub(super) const TOP: f64 = 100.0;
/// See [`TOP`].
pub(super) const BOTTOM: f64 = 424.0;
const PANEL_WIDTH: f64 = 380.0;
/// Space between the frame of a panel and the first and last angle.
const INSET: f64 = 8.0;

/// Vermilion, bluish green and blue: still apart for colour-blind readers (Okabe & Ito 2008).
pub(super) const COLOURS: [&str; 3] = ["#d55e00", "#009e73", "#0072b2"];
/// The lines of R, G and B lie in this order on each other; where they coincide all three remain visible.
pub(super) const LINE_WIDTHS: [f64; 3] = [2.4, 1.8, 1.2];

/// One slice: its data and its place.
pub(super) struct Panel<'a> {
    pub(super) left: f64,
    pub(super) axis: AngleAxis,
    pub(super) title: String,
    pub(super) axis_title: String,
    pub(super) cutoff_degrees: f64,
    pub(super) angles: &'a [f64],
    pub(super) measured: &'a [Vec<Option<f64>>; 3],
    pub(super) fitted: &'a [Vec<f64>; 3],
}

impl Panel<'_> {
    fn x(&self, degrees: f64) -> f64 {
        self.left + INSET + self.axis.position(degrees) * (PANEL_WIDTH - 2.0 * INSET)
    }

    fn y(at: f64) -> f64 {
        BOTTOM - at * (BOTTOM - TOP)
    }

    /// Measured values above zero up to an angle.
    pub(super) fn measured_values(&self, up_to_degrees: f64) -> impl Iterator<Item = f64> + '_ {
        let rows = self.rows(up_to_degrees);
        self.measured.iter().flat_map(move |curve| curve.iter().take(rows).flatten()).copied().filter(|&f| f > 0.0)
    }

    /// Fitted values above zero up to an angle.
    pub(super) fn fitted_values(&self, up_to_degrees: f64) -> impl Iterator<Item = f64> + '_ {
        let rows = self.rows(up_to_degrees);
        self.fitted.iter().flat_map(move |curve| curve.iter().take(rows)).copied().filter(|&f| f > 0.0)
    }

    fn rows(&self, up_to_degrees: f64) -> usize {
        self.angles.partition_point(|angle| angle.to_degrees() <= up_to_degrees)
    }

    pub(super) fn has_values_below(&self, values: &LogAxis) -> bool {
        self.measured.iter().flatten().flatten().any(|&value| values.position(value) < 0.0)
    }

    pub(super) fn draw(&self, out: &mut String, values: &LogAxis, with_labels: bool) {
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
        put!(out, r#"<text x="{left:.1}" y="{:.1}" font-size="13">{}</text>"#, BOTTOM + 40.0, self.axis_title);
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
        put!(out, r#"<path d="{path}" fill="none" stroke="{colour}" stroke-width="{width}" stroke-linejoin="round"/>"#);
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

/// The shape of a measured value: a disc, a square or a triangle around (x, y).
pub(super) fn marker(path: &mut String, channel: usize, x: f64, y: f64) {
    let _ = match channel {
        0 => write!(path, "M{:.1} {y:.1}a2.5 2.5 0 1 0 5 0a2.5 2.5 0 1 0 -5 0z", x - 2.5),
        1 => write!(path, "M{:.1} {:.1}h4.6v4.6h-4.6z", x - 2.3, y - 2.3),
        _ => write!(path, "M{x:.1} {:.1}l2.9 5h-5.8z", y - 3.2),
    };
}

/// An arrow head that points down: the value is below the axis.
pub(super) fn below_axis_marker(path: &mut String, x: f64, y: f64) {
    let _ = write!(path, "M{:.1} {:.1}l2 3.5l2 -3.5", x - 2.0, y - 3.5);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_end_at_the_frame() {
        assert_eq!(inside([0.0, 0.5], [1.0, 1.5]), Some([[0.0, 0.5], [0.5, 1.0]]));
        assert_eq!(inside([0.0, 1.5], [1.0, 0.5]), Some([[0.5, 1.0], [1.0, 0.5]]));
        assert_eq!(inside([0.0, -1.0], [3.0, 2.0]), Some([[1.0, 0.0], [2.0, 1.0]]));
        assert_eq!(inside([0.0, 2.0], [1.0, 1.5]), None);
        assert_eq!(inside([0.0, f64::NEG_INFINITY], [1.0, 0.5]), None);
    }
}
