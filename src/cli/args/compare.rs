//! Command-line arguments of `brdfit compare`.

use std::path::PathBuf;

use clap::Args;

use crate::args::value_enums::Format;

/// Options of `brdfit compare`.
#[derive(Debug, Args)]
pub(crate) struct CompareArgs {
    /// Result of `brdfit fit`, or a folder of results
    #[arg(value_name = "OURS")]
    pub(crate) ours: PathBuf,

    /// Result to compare with, or a folder with results of the same names
    #[arg(value_name = "REFERENCE")]
    pub(crate) reference: PathBuf,

    /// Output format
    #[arg(long, value_name = "FORMAT", default_value = "text")]
    pub(crate) format: Format,

    /// Write to a file instead of standard output
    #[arg(short, long, value_name = "FILE")]
    pub(crate) output: Option<PathBuf>,

    /// Also treat a cost below the reference's as a difference
    #[arg(long, help_heading = TOLERANCES)]
    pub(crate) two_sided: bool,

    /// Warn if the cost of a step exceeds the reference's by more than X
    #[arg(long, value_name = "X", default_value = "1e-6", value_parser = tolerance, help_heading = TOLERANCES)]
    pub(crate) cost_warn: f64,

    /// Fail if the cost of a step exceeds the reference's by more than X
    #[arg(long, value_name = "X", default_value = "1e-4", value_parser = tolerance, help_heading = TOLERANCES)]
    pub(crate) cost_fail: f64,

    /// Warn if E, L or C differ by more than X
    #[arg(long, value_name = "X", default_value = "1e-3", value_parser = tolerance, help_heading = TOLERANCES)]
    pub(crate) errors_warn: f64,

    /// Fail if E, L or C differ by more than X
    #[arg(long, value_name = "X", default_value = "1e-2", value_parser = tolerance, help_heading = TOLERANCES)]
    pub(crate) errors_fail: f64,

    /// Warn if a fitted curve differs by more than X (root mean square)
    #[arg(long, value_name = "X", default_value = "1e-3", value_parser = tolerance, help_heading = TOLERANCES)]
    pub(crate) curve_warn: f64,

    /// Fail if a fitted curve differs by more than X (root mean square)
    #[arg(long, value_name = "X", default_value = "1e-2", value_parser = tolerance, help_heading = TOLERANCES)]
    pub(crate) curve_fail: f64,
}

const TOLERANCES: &str = "Tolerances (relative; inf disables one)";

pub(super) const EXAMPLES: &str = "\
Examples:
  brdfit compare fits/gold.json reference/gold.json
  brdfit compare fits reference --format json -o comparison.json
Measured slices must agree to 1e-9. Step 2 is compared only where the costs of
step 1 agree, because it depends on step 1; curves, E, L and C only where the
costs of both steps agree. Parameters are not compared: different parameters
can give the same curve. The exit code is 7 if any comparison fails.";

fn tolerance(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(value) if value >= 0.0 => Ok(value),
        _ => Err("a tolerance is a non-negative number, for instance 1e-6".to_owned()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tolerances_are_numbers() {
        assert_eq!((tolerance("0"), tolerance("inf")), (Ok(0.0), Ok(f64::INFINITY)));
        for text in ["-1", "nan", "x", ""] {
            assert!(tolerance(text).is_err(), "{text}");
        }
    }
}
