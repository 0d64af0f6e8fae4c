//! Reads result documents; rejects other files with specific messages.

use std::fmt::Display;
use std::fs;
use std::path::Path;

use brdfit_brdf::{MaterialError, MaterialParameters, SCHEMA_VERSION};
use serde::Deserialize;
use serde::de::DeserializeOwned;
use sha2::{Digest, Sha256};

use crate::terminal::exit_code::Problem;

/// Larger files are not read: a document takes some 50 kB, a summary of a thousand materials a megabyte.
const MAX_BYTES: u64 = 256 << 20;

/// The schema version alone.
#[derive(Deserialize)]
struct Version {
    schema_version: Option<u32>,
}

/// A file with a JSON document.
#[derive(Debug)]
pub(crate) struct Document<'a> {
    path: &'a Path,
    /// The expected document, with an article ("a fit result").
    what: &'a str,
    bytes: Vec<u8>,
}

/// Reads a JSON document: [`Document::open`] and [`Document::decode`].
///
/// # Errors
/// As theirs.
pub(crate) fn read<T: DeserializeOwned>(path: &Path, what: &str) -> Result<T, Problem> {
    Document::open(path, what)?.decode()
}

/// SHA-256, lower-case hexadecimal.
pub(crate) fn sha256(bytes: &[u8]) -> String {
    Sha256::digest(bytes).iter().map(|byte| format!("{byte:02x}")).collect()
}

impl<'a> Document<'a> {
    /// Reads a file; `what` is what it should be, with an article.
    ///
    /// # Errors
    /// A file that cannot be read (exit code 2), is empty or too large (exit code 3).
    pub(crate) fn open(path: &'a Path, what: &'a str) -> Result<Self, Problem> {
        let size = fs::metadata(path).map_err(|error| Problem::reading(path, &error))?.len();
        let document = Self { path, what, bytes: Vec::new() };
        if size > MAX_BYTES {
            let why = format!("too large for {what} ({size} bytes); check that it is the right file");
            return Err(document.refuse(&why));
        }
        let bytes = fs::read(path).map_err(|error| Problem::reading(path, &error))?;
        if bytes.is_empty() {
            return Err(document.refuse(&format!("the file is empty (0 bytes), not {what}; write it again")));
        }
        Ok(Self { bytes, ..document })
    }

    /// The file as it is.
    pub(crate) fn bytes(&self) -> &[u8] {
        &self.bytes
    }

    /// The whole or, as other members are skipped, a part of it.
    ///
    /// # Errors
    /// A document that is not JSON, lacks a member, or was written by a later version (exit code 3).
    pub(crate) fn decode<T: DeserializeOwned>(&self) -> Result<T, Problem> {
        if let Ok(Version { schema_version: Some(version) }) = serde_json::from_slice(&self.bytes)
            && version > SCHEMA_VERSION
        {
            return Err(self.later(&format!("has schema version {version}; this program reads {SCHEMA_VERSION}")));
        }
        serde_json::from_slice(&self.bytes).map_err(|error| match error.classify() {
            serde_json::error::Category::Data => self.another(&error),
            _ => self.no_json(&error),
        })
    }

    /// The material part.
    ///
    /// # Errors
    /// As [`Self::decode`], and parameters outside of the model's domain (exit code 3); messages name the member by its path.
    pub(crate) fn material(&self) -> Result<MaterialParameters, Problem> {
        MaterialParameters::read(&self.bytes).map_err(|error| match error {
            MaterialError::Json(error) => self.no_json(&error),
            MaterialError::Version { .. } => self.later(&error),
            MaterialError::Member { .. } => self.another(&error),
            MaterialError::Parameter(_) => self.refuse(&format!("{error}; correct the parameter")),
        })
    }

    /// SHA-256 of the whole file, lower-case hexadecimal.
    pub(crate) fn sha256(&self) -> String {
        sha256(&self.bytes)
    }

    fn refuse(&self, why: &str) -> Problem {
        Problem::invalid(format!("{}: {why}", self.path.display()))
    }

    fn no_json(&self, error: &serde_json::Error) -> Problem {
        self.refuse(&format!("is not JSON, and thus not {} ({error}); check that it is the right file", self.what))
    }

    fn another(&self, error: &dyn Display) -> Problem {
        self.refuse(&format!("is not {} ({error}); check that it is the right file", self.what))
    }

    fn later(&self, why: &dyn Display) -> Problem {
        self.refuse(&format!("{why}; use a later brdfit"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::terminal::exit_code::Outcome;

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
            ("{", "is not JSON, and thus not a sample (EOF"),
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
