//! Which documents of an earlier run can stay.

use std::fs;
use std::path::Path;

use brdfit_fit::document::{FitDocument, SCHEMA_VERSION};
use tracing::debug;

use crate::jobs::fit_job::{Job, Opened, PROGRAM};
use crate::results::json;

/// The document at `path`, if a new fit of this input would write the same bytes: made by this version of the program with
/// these options from a file with this hash, and unchanged since as far as its form shows.
pub(crate) fn reusable(path: &Path, opened: &Opened, job: &Job) -> Option<FitDocument> {
    let bytes = fs::read(path).ok()?;
    let refuse = |why: &str| {
        debug!(file = %path.display(), why, "fitted again");
        None
    };
    let Ok(document) = serde_json::from_slice::<FitDocument>(&bytes) else {
        return refuse("it is not a result");
    };
    if document.schema_version != SCHEMA_VERSION || document.program != PROGRAM {
        return refuse("another version made it");
    }
    let input = opened.input();
    if input.sha256.is_none() || document.input != *input {
        return refuse("the input is another one");
    }
    if document.model != job.model || document.options != *opened.options() || document.errors.is_some() != job.panel {
        return refuse("the options are others");
    }
    if json::to_vec(&document) != bytes {
        return refuse("it was changed by hand");
    }
    Some(document)
}
