//! `brdfit compare` as it is typed.

use std::path::PathBuf;

use clap::Args;

use crate::args::value_enums::Format;

/// Options of `brdfit compare`.
#[derive(Debug, Args)]
pub(crate) struct CompareArgs {
    /// A result of `brdfit fit`, or a folder of them
    #[arg(value_name = "OURS")]
    pub(crate) ours: PathBuf,

    /// The result to compare with, or a folder with one of the same name
    /// for each
    #[arg(value_name = "REFERENCE")]
    pub(crate) reference: PathBuf,

    /// Text for people, or JSON
    #[arg(long, value_name = "FORMAT", default_value = "text")]
    pub(crate) format: Format,

    /// Write to a file instead of standard output
    #[arg(short, long, value_name = "FILE")]
    pub(crate) output: Option<PathBuf>,

    /// Hold a cost that is lower than the reference's against us, too
    #[arg(long, help_heading = TOLERANCES)]
    pub(crate) two_sided: bool,

    /// Warn where the cost of a step is above the reference's by more
    #[arg(long, value_name = "X", default_value = "1e-6", value_parser = tolerance, help_heading = TOLERANCES)]
    pub(crate) cost_warn: f64,

    /// Fail where it is above by more
    #[arg(long, value_name = "X", default_value = "1e-4", value_parser = tolerance, help_heading = TOLERANCES)]
    pub(crate) cost_fail: f64,

    /// Warn where E, L or C differ by more
    #[arg(long, value_name = "X", default_value = "1e-3", value_parser = tolerance, help_heading = TOLERANCES)]
    pub(crate) errors_warn: f64,

    /// Fail where they differ by more
    #[arg(long, value_name = "X", default_value = "1e-2", value_parser = tolerance, help_heading = TOLERANCES)]
    pub(crate) errors_fail: f64,

    /// Warn where a fitted curve differs by more (root mean square)
    #[arg(long, value_name = "X", default_value = "1e-3", value_parser = tolerance, help_heading = TOLERANCES)]
    pub(crate) curve_warn: f64,

    /// Fail where it differs by more
    #[arg(long, value_name = "X", default_value = "1e-2", value_parser = tolerance, help_heading = TOLERANCES)]
    pub(crate) curve_fail: f64,
}

const TOLERANCES: &str = "Tolerances (relative; inf switches one off)";

pub(super) const EXAMPLES: &str = "\
Examples:
  brdfit compare fits/gold.json reference/gold.json
  brdfit compare fits reference --format json -o comparison.json
The measured slices must be the same to 1e-9. Step 2 is judged where the costs
of step 1 agree, on which it depends; curves, E, L and C where both do: other
minima have other curves. Parameters are not compared: different ones can give
the same curve. Exit code 7 if anything fails.";

fn tolerance(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(value) if value >= 0.0 => Ok(value),
        _ => Err("a tolerance is a number that is not negative, for instance 1e-6".to_owned()),
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
