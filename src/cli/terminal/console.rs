//! User interface: diagnostics on standard error, progress bars, colour.

use std::io::{IsTerminal, Write};
use std::time::Duration;

use clap::ColorChoice;
use clap::builder::styling::{AnsiColor, Style};
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

/// Meaning of a text, which determines its colour.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Tone {
    /// A pass.
    Good,
    /// A warning.
    Warn,
    /// An error or a failure.
    Bad,
    /// A heading.
    Strong,
    /// Secondary information.
    Dim,
}

impl Tone {
    fn style(self) -> Style {
        match self {
            Self::Good => AnsiColor::Green.on_default(),
            Self::Warn => AnsiColor::Yellow.on_default(),
            Self::Bad => AnsiColor::Red.on_default().bold(),
            Self::Strong => Style::new().bold(),
            Self::Dim => Style::new().dimmed(),
        }
    }

    fn paint(self, text: &str) -> String {
        let style = self.style();
        format!("{style}{text}{style:#}")
    }
}

/// The terminal, as `--quiet` and `--color` allow its use.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Console {
    quiet: bool,
    colour_out: bool,
    colour_err: bool,
}

impl Console {
    /// A console; with `Auto`, `NO_COLOR` and streams that are not terminals disable colour.
    pub(crate) fn new(quiet: bool, color: ColorChoice) -> Self {
        let wanted = |terminal: bool| match color {
            ColorChoice::Always => true,
            ColorChoice::Never => false,
            ColorChoice::Auto => terminal && std::env::var_os("NO_COLOR").is_none_or(|value| value.is_empty()),
        };
        Self {
            quiet,
            colour_out: wanted(std::io::stdout().is_terminal()),
            colour_err: wanted(std::io::stderr().is_terminal()),
        }
    }

    /// A text for standard output in the colour of its tone.
    pub(crate) fn paint(&self, tone: Tone, text: &str) -> String {
        if self.colour_out { tone.paint(text) } else { text.to_owned() }
    }

    /// Whether diagnostics are coloured.
    pub(crate) fn colours_diagnostics(&self) -> bool {
        self.colour_err
    }

    /// Prints an error in one line, also with `--quiet`.
    pub(crate) fn error(&self, error: &anyhow::Error) {
        let message = format!("{error:#}").replace(['\n', '\r'], " ");
        let label = if self.colour_err { Tone::Bad.paint("error") } else { "error".to_owned() };
        emit(&format!("{label}: {message}"));
    }

    /// Prints a note in one line, unless `--quiet` is given.
    pub(crate) fn note(&self, message: &str) {
        if !self.quiet {
            emit(message);
        }
    }

    /// A progress bar over `total` steps; visible only on a terminal.
    pub(crate) fn progress(&self, total: usize, what: &str) -> Progress {
        let visible = !self.quiet && total > 1 && std::io::stderr().is_terminal();
        let target = if visible { ProgressDrawTarget::stderr() } else { ProgressDrawTarget::hidden() };
        let bar = ProgressBar::with_draw_target(Some(total as u64), target);
        let template = "{msg} [{bar:30}] {pos}/{len}  {elapsed} elapsed, {eta} left";
        if let Ok(style) = ProgressStyle::with_template(template) {
            bar.set_style(style.progress_chars("=> "));
        }
        bar.set_message(what.to_owned());
        if visible {
            bar.enable_steady_tick(Duration::from_millis(200));
        }
        Progress { bar }
    }
}

/// Writes one line to standard error. A failure here cannot be reported and is ignored.
fn emit(line: &str) {
    let _ = writeln!(std::io::stderr().lock(), "{line}");
}

/// A progress bar, cleared when dropped.
#[derive(Debug)]
pub(crate) struct Progress {
    bar: ProgressBar,
}

impl Progress {
    /// Advances by one step.
    pub(crate) fn tick(&self) {
        self.bar.inc(1);
    }

    /// Prints lines between two states of the bar.
    pub(crate) fn suspend<T>(&self, print: impl FnOnce() -> T) -> T {
        self.bar.suspend(print)
    }
}

impl Drop for Progress {
    fn drop(&mut self) {
        self.bar.finish_and_clear();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn colour_follows_the_option() {
        assert_eq!(Console::new(false, ColorChoice::Never).paint(Tone::Bad, "x"), "x");
        let painted = Console::new(false, ColorChoice::Always).paint(Tone::Strong, "x");
        assert_eq!(painted, "\u{1b}[1mx\u{1b}[0m");
    }
}
