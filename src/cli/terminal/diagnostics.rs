//! What `-v` shows: the steps of the work as they happen, on standard error.

use tracing::Level;

use crate::terminal::console::Console;

/// Switches the events on: `-v` shows what is done with each file, `-vv` the details.
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
