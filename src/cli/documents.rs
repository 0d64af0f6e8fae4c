//! Reads documents back, with messages for files that are something else.

use std::fs;
use std::path::Path;

use brdfit_fit::document::SCHEMA_VERSION;
use serde::Deserialize;
use serde::de::DeserializeOwned;

use crate::outcome::Problem;

/// Larger files are not read: a document takes some 50 kB, a summary of a thousand materials a megabyte.
const MAX_BYTES: u64 = 256 << 20;

/// The part that tells the version.
#[derive(Deserialize)]
struct Version {
    schema_version: Option<u32>,
}

/// Reads a JSON document; `what` is what it should be, with an article ("a fit result").
///
/// # Errors
/// A file that cannot be read (exit code 2), is no JSON, lacks something, or was written by a later version (exit code 3).
pub(crate) fn read<T: DeserializeOwned>(path: &Path, what: &str) -> Result<T, Problem> {
    let size = fs::metadata(path).map_err(|error| Problem::reading(path, &error))?.len();
    let refuse = |why: String| Problem::invalid(format!("{}: {why}", path.display()));
    if size > MAX_BYTES {
        return Err(refuse(format!("has {size} bytes, too many for {what}; check that it is the right file")));
    }
    let bytes = fs::read(path).map_err(|error| Problem::reading(path, &error))?;
    if bytes.is_empty() {
        return Err(refuse(format!("the file is empty (0 bytes), not {what}; make it again")));
    }
    if let Ok(Version { schema_version: Some(version) }) = serde_json::from_slice(&bytes)
        && version > SCHEMA_VERSION
    {
        return Err(refuse(format!(
            "has schema version {version}, this program knows {SCHEMA_VERSION}; use a later brdfit"
        )));
    }
    serde_json::from_slice(&bytes).map_err(|error| {
        let why = match error.classify() {
            serde_json::error::Category::Data => "is not",
            _ => "is not JSON and so not",
        };
        refuse(format!("{why} {what} ({error}); check that it is the right file"))
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::outcome::Outcome;

    #[derive(Debug, Deserialize)]
    #[allow(dead_code)] // read by the macro only
    struct Sample {
        value: f64,
    }

    #[test]
    fn each_mistake_has_its_message() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("x.json");
        for (content, part) in [
            ("", "empty (0 bytes), not a sample"),
            ("{", "is not JSON and so not a sample (EOF"),
            ("\"text\"", "is not a sample (invalid"),
            ("{}", "missing field `value` at line 1"),
            (r#"{"value": 1e999}"#, "number out of range"),
            (r#"{"schema_version": 99, "value": 1}"#, "has schema version 99"),
        ] {
            fs::write(&path, content).unwrap();
            let problem = read::<Sample>(&path, "a sample").unwrap_err();
            assert!(problem.to_string().contains(part), "{content}: {problem}");
            assert_eq!(Outcome::of(&problem.into()), Outcome::InvalidInput);
        }
        let missing = read::<Sample>(&folder.path().join("none"), "a sample").unwrap_err();
        assert_eq!(Outcome::of(&missing.into()), Outcome::InputOutput);
        assert!(read::<Sample>(folder.path(), "a sample").unwrap_err().to_string().contains("is a folder"));
    }
}
