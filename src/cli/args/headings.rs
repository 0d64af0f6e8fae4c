//! Headings of options in the help.

/// Options that every subcommand takes.
pub(super) const GLOBAL: &str = "Everywhere";
/// Where results of many inputs go.
pub(super) const OUTPUT: &str = "Output";
/// How many inputs are worked through.
pub(super) const BATCH: &str = "Batch";
