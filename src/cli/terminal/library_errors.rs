//! Exit codes of the errors of the libraries, in one place.
//!
//! The error of a library names the file only if the library opened it; [`Problem::of`] prepends the name otherwise.

use std::error::Error;
use std::fmt::Display;

use brdfit_bandwidth::AtlasError;
use brdfit_brdf::ParameterError;
use brdfit_fit::FitError;
use brdfit_renderer::{FilmError, SceneError};

use crate::terminal::exit_code::{Outcome, Problem};

/// An error of a library.
pub(crate) trait LibraryError: Error {
    /// Its outcome.
    fn outcome(&self) -> Outcome;

    /// The remedy, if the message does not name it.
    fn advice(&self) -> Option<&'static str> {
        None
    }
}

impl Problem {
    /// An error of a library about the file or material with this name.
    pub(crate) fn of(name: impl Display, error: &impl LibraryError) -> Self {
        let advice = error.advice().map_or_else(String::new, |advice| format!("; {advice}"));
        Self::new(error.outcome(), format!("{name}: {error}{advice}"))
    }
}

fn input(is_invalid: bool) -> Outcome {
    if is_invalid { Outcome::InvalidInput } else { Outcome::InputOutput }
}

impl LibraryError for AtlasError {
    fn outcome(&self) -> Outcome {
        match self {
            // of a material, not of a file
            Self::Texels { .. } => Outcome::Computation,
            _ => input(self.is_invalid_input()),
        }
    }
}

impl LibraryError for FitError {
    fn outcome(&self) -> Outcome {
        match self {
            Self::FewRows { .. } => Outcome::InvalidInput,
            _ => Outcome::Computation,
        }
    }
}

impl LibraryError for ParameterError {
    fn outcome(&self) -> Outcome {
        Outcome::InvalidInput
    }

    fn advice(&self) -> Option<&'static str> {
        Some("correct the parameter")
    }
}

impl LibraryError for SceneError {
    fn outcome(&self) -> Outcome {
        input(self.is_invalid_input())
    }
}

impl LibraryError for FilmError {
    fn outcome(&self) -> Outcome {
        Outcome::InvalidInput
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn errors_end_the_run_by_what_the_user_can_do() {
        let atlas = |error: AtlasError| Outcome::of(&Problem::of("x", &error).into());
        assert_eq!(atlas(AtlasError::Damaged { why: "cut".to_owned() }), Outcome::InvalidInput);
        assert_eq!(atlas(AtlasError::Texels { why: "NaN".to_owned() }), Outcome::Computation);
        assert_eq!(atlas(AtlasError::Io(std::io::ErrorKind::UnexpectedEof.into())), Outcome::InputOutput);
        let rows = FitError::FewRows { slice: "theta_h", found: 1, needed: 4, cutoff: 80.0 };
        let problem = Problem::of("x.binary", &rows);
        assert!(problem.to_string().starts_with("x.binary: only 1 rows of the theta_h slice"), "{problem}");
        assert_eq!(Outcome::of(&problem.into()), Outcome::InvalidInput);
    }
}
