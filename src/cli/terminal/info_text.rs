//! Report on a measured file in 80 columns.

use std::fmt::Write;

use brdfit_measured::{AlbedoHealth, ChannelHealth, ChannelRange, Health, Info, Region, Summary, TableShape};

use crate::terminal::console::{Console, Tone};
use crate::terminal::table::{Align, Table};

/// The text for one file.
pub(crate) fn render(info: &Info, console: &Console) -> String {
    match info {
        Info::Cells(health) => cells(health, console),
        Info::Summary(summary) => summarised(summary, console),
    }
}

/// A file of cells.
fn cells(health: &Health, console: &Console) -> String {
    let mut text = String::new();
    let [h, d, p] = health.dimensions.shape();
    let position = health.sample_position;
    // Writing to a text cannot fail.
    let _ = writeln!(text, "{}", console.paint(Tone::Strong, &health.name));
    let _ = writeln!(
        text,
        "{h} x {d} x {p} (theta_h x theta_d x phi_d), {} bytes, samples at the {position}",
        health.bytes
    );
    let _ = writeln!(text, "sha256 {}", health.sha256);
    let _ = writeln!(text, "\n{}", regions(health, console));
    let _ = writeln!(text, "{}", channels(health, console));
    let _ = write!(text, "{}", albedo(&health.albedo));
    text
}

/// A file of another kind.
fn summarised(summary: &Summary, console: &Console) -> String {
    let mut text = String::new();
    let position = summary.sample_position;
    let _ = writeln!(text, "{}", console.paint(Tone::Strong, &summary.name));
    if !summary.description.is_empty() {
        let _ = writeln!(text, "{:.80}", summary.description);
    }
    let _ = writeln!(text, "format {}, {} bytes, samples at the {position}", summary.format, summary.bytes);
    let _ = writeln!(text, "sha256 {}", summary.sha256);
    let angles: Vec<String> = summary.measured_theta_i_deg.iter().map(|degrees| format!("{degrees:.1}")).collect();
    let _ = writeln!(text, "{} theta_i measured: {} deg", angles.len(), angles.join(", "));
    let _ = writeln!(text, "non-reciprocity {:.4}: median |f(i,o) - f(o,i)| / mean\n", summary.non_reciprocity);
    let _ = writeln!(text, "{}", shapes(summary));
    let _ = writeln!(text, "{}", ranges(summary));
    let _ = write!(text, "{}", albedo(&summary.albedo));
    text
}

fn shapes(summary: &Summary) -> Table {
    let mut table = Table::new([("table", Align::Left), ("shape", Align::Left)]);
    for TableShape { name, shape } in &summary.tables {
        let shape: Vec<String> = shape.iter().map(ToString::to_string).collect();
        table.row([name.clone(), shape.join(" x ")]);
    }
    table
}

fn ranges(summary: &Summary) -> Table {
    let mut table = Table::new([("channel", Align::Left), ("min (1/sr)", Align::Right), ("max (1/sr)", Align::Right)]);
    for ChannelRange { name, min, max } in &summary.channels {
        table.row([name.clone(), number(*min), number(*max)]);
    }
    table
}

fn regions(health: &Health, console: &Console) -> Table {
    let mut table = Table::new([
        ("cells", Align::Left),
        ("number", Align::Right),
        ("valid", Align::Right),
        ("share", Align::Right),
        ("R < 0", Align::Right),
        ("G < 0", Align::Right),
        ("B < 0", Align::Right),
        ("NaN", Align::Right),
        ("inf", Align::Right),
    ]);
    let regions = &health.regions;
    for (name, region) in [
        ("all", &regions.all),
        ("both angles <= 80", &regions.interior),
        ("grazing", &regions.grazing),
        ("below horizon", &regions.below_horizon),
        ("theta_h bin 0", &regions.specular_row),
        ("theta_d bin 0", &regions.retro_row),
    ] {
        let Region { cells, valid, negative, nan, infinite } = *region;
        let bad = |counts: [usize; 3]| match counts.iter().sum::<usize>() {
            0 => "0".to_owned(),
            count => console.paint(Tone::Bad, &count.to_string()),
        };
        let share = if cells == 0 { "-".to_owned() } else { format!("{:.1}%", 100.0 * valid as f64 / cells as f64) };
        let [r, g, b] = negative.map(|count| count.to_string());
        table.row([name.to_owned(), cells.to_string(), valid.to_string(), share, r, g, b, bad(nan), bad(infinite)]);
    }
    table
}

fn channels(health: &Health, console: &Console) -> Table {
    let mut table = Table::new([
        ("channel", Align::Left),
        ("min (1/sr)", Align::Right),
        ("max (1/sr)", Align::Right),
        ("at theta_h", Align::Right),
        ("theta_d", Align::Right),
        ("phi_d", Align::Right),
        ("peak", Align::Left),
    ]);
    for channel in &health.channels {
        let ChannelHealth { name, min, max, max_at, zero_peak } = channel;
        let value = |value: &Option<f64>| value.map_or("-".to_owned(), number);
        let angle = |angle: Option<f64>| angle.map_or("-".to_owned(), |degrees| format!("{degrees:.2}"));
        let peak = if *zero_peak { console.paint(Tone::Warn, "zero: out of gamut") } else { "measured".to_owned() };
        table.row([
            name.clone(),
            value(min),
            value(max),
            angle(max_at.map(|at| at.theta_h_deg)),
            angle(max_at.map(|at| at.theta_d_deg)),
            angle(max_at.map(|at| at.phi_d_deg)),
            peak,
        ]);
    }
    table
}

fn albedo(albedo: &AlbedoHealth) -> Table {
    let mut table = Table::new([
        ("albedo at theta_i", Align::Left),
        ("R", Align::Right),
        ("G", Align::Right),
        ("B", Align::Right),
        ("measured share", Align::Right),
    ]);
    for (n, (degrees, covered)) in albedo.theta_i_deg.iter().zip(&albedo.covered).enumerate() {
        let [r, g, b] = albedo.values.each_ref().map(|values| format!("{:.4}", values[n]));
        table.row([format!("{degrees} deg"), r, g, b, format!("{:.1}%", 100.0 * covered)]);
    }
    table
}

/// Five significant digits, as a plain number where that is short.
fn number(value: f64) -> String {
    if value == 0.0 || (1e-3..1e5).contains(&value.abs()) {
        let digits = if value == 0.0 { 0 } else { (4 - value.abs().log10().floor() as i32).clamp(0, 7) as usize };
        format!("{value:.digits$}")
    } else {
        format!("{value:.3e}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use brdfit_measured::{Dimensions, HealthCheck, MerlFile, SamplePosition};
    use clap::ColorChoice;

    #[test]
    fn numbers_are_short() {
        let shown = [0.0, 0.25, 12.3456789, 99999.0, 0.0012345, 1.5e-7, 2.5e9].map(number);
        assert_eq!(shown, ["0", "0.25000", "12.346", "99999", "0.0012345", "1.500e-7", "2.500e9"]);
    }

    #[test]
    fn the_text_fits_a_terminal() {
        let dimensions = Dimensions::FULL_TURN;
        let file = MerlFile::from_fn("a.binary", dimensions, |_, h, _, _| if h == 3 { 12345.0 } else { -1.0 }).unwrap();
        let health = HealthCheck::new(dimensions, SamplePosition::Centre).examine(&file, &file.scan());
        let text = render(&Info::Cells(Box::new(health)), &Console::new(false, ColorChoice::Never));
        assert!(text.lines().all(|line| line.chars().count() <= 80), "{text}");
        assert!(text.starts_with("a.binary\n90 x 90 x 360 (theta_h x theta_d x phi_d), 69984012 bytes"), "{text}");
        for part in ["sha256 ", "below horizon", "12345", "albedo at theta_i", "80 deg"] {
            assert!(text.contains(part), "{part}: {text}");
        }
    }
}
