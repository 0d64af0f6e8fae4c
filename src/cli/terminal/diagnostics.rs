//! Diagnostics of `-v` and `-vv` on standard error.

use tracing::Level;

use crate::terminal::console::Console;

/// Enables diagnostics: `-v` reports the steps of each file, `-vv` adds debug output.
pub(crate) fn start(verbose: u8, console: &Console) {
    let level = match verbose {
        0 => return,
        1 => Level::INFO,
        _ => Level::DEBUG,
    };
    tracing_subscriber::fmt()
        .with_max_level(level)
        .with_writer(std::io::stderr)
        .with_ansi(console.colours_diagnostics())
        .with_target(false)
        .without_time()
        .init();
}
