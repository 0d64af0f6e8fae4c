//! Headings of options in the help.

/// Options of all subcommands.
pub(super) const GLOBAL: &str = "Global options";
/// Options for the results.
pub(super) const OUTPUT: &str = "Output";
/// Options for batches of inputs.
pub(super) const BATCH: &str = "Batch";
