//! Range checks of numeric options.

use crate::terminal::exit_code::Problem;

/// The value of an option.
///
/// # Errors
/// If it is not `within` the range; the message names the range ("above 0", "from 0 to 1").
pub(crate) fn must_lie(option: &str, value: f64, within: bool, range: &str) -> Result<f64, Problem> {
    if within { Ok(value) } else { Err(Problem::usage(format!("{option} {value}: must lie {range}"))) }
}
