//! Exit codes, and the error that carries one.

use std::fmt;
use std::io;
use std::path::Path;

use brdfit_measured::MeasurementError;

/// The exit codes of the program, as `brdfit --help` lists them. A batch reports the largest.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
#[repr(u8)]
pub(crate) enum Outcome {
    /// Success.
    Done = 0,
    /// Invalid usage.
    Usage = 1,
    /// A file could not be read or written.
    InputOutput = 2,
    /// An input is invalid.
    InvalidInput = 3,
    /// A computation failed on valid input.
    Computation = 4,
    /// A comparison found a difference beyond its tolerance.
    Difference = 7,
}

impl Outcome {
    /// The exit code of an interrupted run (Ctrl-C), which ends without passing through [`crate::main`].
    pub(crate) const INTERRUPTED: u8 = 130;

    /// The exit status.
    pub(crate) fn code(self) -> u8 {
        self as u8
    }

    /// The exit code of an error: the first [`Problem`], [`MeasurementError`] or [`io::Error`] in its chain decides.
    pub(crate) fn of(error: &anyhow::Error) -> Self {
        error.chain().find_map(Self::of_cause).unwrap_or(Self::Computation)
    }

    fn of_cause(cause: &(dyn std::error::Error + 'static)) -> Option<Self> {
        if let Some(problem) = cause.downcast_ref::<Problem>() {
            return Some(problem.outcome);
        }
        if let Some(error) = cause.downcast_ref::<MeasurementError>() {
            return Some(if error.is_invalid_input() { Self::InvalidInput } else { Self::InputOutput });
        }
        cause.downcast_ref::<io::Error>().map(|_| Self::InputOutput)
    }
}

impl From<Outcome> for std::process::ExitCode {
    fn from(outcome: Outcome) -> Self {
        outcome.code().into()
    }
}

/// An error with its exit code. The message is one line, `FILE: what is wrong; what to do`, without the word "error".
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Problem {
    outcome: Outcome,
    message: String,
}

impl Problem {
    /// A problem with the given outcome.
    pub(crate) fn new(outcome: Outcome, message: String) -> Self {
        Self { outcome, message }
    }

    /// Invalid usage (exit code 1).
    pub(crate) fn usage(message: impl Into<String>) -> Self {
        Self { outcome: Outcome::Usage, message: message.into() }
    }

    /// An input is invalid (exit code 3).
    pub(crate) fn invalid(message: impl Into<String>) -> Self {
        Self { outcome: Outcome::InvalidInput, message: message.into() }
    }

    /// A computation failed on valid input (exit code 4).
    pub(crate) fn computation(message: impl Into<String>) -> Self {
        Self { outcome: Outcome::Computation, message: message.into() }
    }

    /// A file or folder could not be read or written (exit code 2), for a reason that the program found itself.
    pub(crate) fn input_output(message: impl Into<String>) -> Self {
        Self { outcome: Outcome::InputOutput, message: message.into() }
    }

    /// An error with the place where it was found in front; its exit code stays.
    pub(crate) fn within(error: &anyhow::Error, place: &str) -> Self {
        Self { outcome: Outcome::of(error), message: format!("{place}: {error:#}") }
    }

    /// A file or folder could not be read (exit code 2).
    pub(crate) fn reading(path: &Path, error: &io::Error) -> Self {
        let what = match error.kind() {
            io::ErrorKind::NotFound | io::ErrorKind::NotADirectory => "no such file; check the path".to_owned(),
            io::ErrorKind::PermissionDenied => "permission denied; make it readable for this user".to_owned(),
            io::ErrorKind::IsADirectory => "is a folder; name a file".to_owned(),
            _ => format!("cannot be read ({error}); check the disk and the path"),
        };
        Self::input_output(format!("{}: {what}", path.display()))
    }

    /// A file or folder could not be written (exit code 2). No partial file is left.
    pub(crate) fn writing(path: &Path, error: &io::Error) -> Self {
        let what = match error.kind() {
            io::ErrorKind::StorageFull | io::ErrorKind::QuotaExceeded => {
                "no space left on the device; make room or choose another place with -o".to_owned()
            }
            io::ErrorKind::PermissionDenied => "permission denied; choose another place with -o".to_owned(),
            io::ErrorKind::ReadOnlyFilesystem => {
                "the file system is read-only; choose another place with -o".to_owned()
            }
            io::ErrorKind::NotFound | io::ErrorKind::NotADirectory => {
                "its folder does not exist; create it or choose another place with -o".to_owned()
            }
            io::ErrorKind::IsADirectory => "is a folder; name a file with -o".to_owned(),
            _ => format!("cannot be written ({error}); choose another place with -o"),
        };
        Self::input_output(format!("{}: {what}", path.display()))
    }
}

impl fmt::Display for Problem {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.message)
    }
}

impl std::error::Error for Problem {}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_known_cause_decides() {
        let io = || io::Error::other("x");
        assert_eq!(Outcome::of(&anyhow::Error::from(io()).context("y")), Outcome::InputOutput);
        assert_eq!(Outcome::of(&Problem::usage("x").into()), Outcome::Usage);
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("x.binary");
        let opening = || brdfit_measured::open(&path, None).unwrap_err();
        assert_eq!(Outcome::of(&opening().into()), Outcome::InputOutput);
        std::fs::write(&path, "").unwrap();
        assert_eq!(Outcome::of(&opening().into()), Outcome::InvalidInput);
        assert_eq!(Outcome::of(&anyhow::anyhow!("x")), Outcome::Computation);
    }

    #[test]
    fn the_larger_code_is_the_larger_outcome() {
        let all = [
            Outcome::Done,
            Outcome::Usage,
            Outcome::InputOutput,
            Outcome::InvalidInput,
            Outcome::Computation,
            Outcome::Difference,
        ];
        assert!(all.is_sorted() && all.is_sorted_by_key(|outcome| outcome.code()));
        assert_eq!(all.map(Outcome::code), [0, 1, 2, 3, 4, 7]);
    }

    #[test]
    fn a_problem_says_what_to_do() {
        let full = Problem::writing(Path::new("out/x.json"), &io::ErrorKind::StorageFull.into());
        assert_eq!(
            full.to_string(),
            "out/x.json: no space left on the device; make room or choose another place with -o"
        );
    }
}
