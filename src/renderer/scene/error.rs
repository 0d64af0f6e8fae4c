//! Errors of scenes and of the files that they name, grouped by remedy.

use std::fmt;
use std::io;
use std::path::{Path, PathBuf};

use crate::lights::error::{LightError, reason};

/// Errors of reading scenes. Each message is one line: the path to the invalid member of the document, the file that
/// it names if any, the fault. The caller prepends the name of the scene file.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum SceneError {
    /// The text is not JSON, or a member is missing, unknown, of the wrong type, or has a value that cannot be used.
    #[error("{field}{why}")]
    Document {
        /// The path to the member in the document.
        field: Field,
        /// What is wrong.
        why: String,
    },
    /// A file that the scene names could not be read.
    #[error("{field}{}: {}; check the path", file.display(), reason(source))]
    Io {
        /// The member that names the file.
        field: Field,
        /// The file, with the folder of the scene in front.
        file: PathBuf,
        /// The error of the operating system.
        source: io::Error,
    },
    /// A file that the scene names was read and cannot be used.
    #[error("{field}{}: {why}", file.display())]
    File {
        /// The member that names the file.
        field: Field,
        /// The file, with the folder of the scene in front.
        file: PathBuf,
        /// The fault.
        why: String,
    },
    /// The light could not be made; the message names its file.
    #[error("{field}{source}")]
    Light {
        /// The member that describes the light.
        field: Field,
        /// What is wrong.
        source: LightError,
    },
}

impl SceneError {
    /// Whether the content is invalid, as opposed to an input error.
    #[must_use]
    pub fn is_invalid_input(&self) -> bool {
        match self {
            Self::Io { .. } => false,
            Self::Light { source, .. } => source.is_invalid_input(),
            Self::Document { .. } | Self::File { .. } => true,
        }
    }

    pub(crate) fn document(field: impl Into<Field>, why: impl Into<String>) -> Self {
        Self::Document { field: field.into(), why: why.into() }
    }

    /// From an error of the document itself: `why` belongs to `file`, which the member at `field` names.
    pub(crate) fn file(field: &Field, file: &Path, error: FileError) -> Self {
        let (field, file) = (field.clone(), file.to_owned());
        match error {
            FileError::Io(source) => Self::Io { field, file, source },
            FileError::Content(why) => Self::File { field, file, why },
        }
    }
}

/// Errors of reading a mesh or an image; the caller knows the file.
#[derive(Debug)]
pub(crate) enum FileError {
    Io(io::Error),
    Content(String),
}

impl From<io::Error> for FileError {
    fn from(error: io::Error) -> Self {
        Self::Io(error)
    }
}

impl FileError {
    pub(crate) fn content(why: impl Into<String>) -> Self {
        Self::Content(why.into())
    }
}

/// The path to a member of the document, as `objects[2].material`; empty for the document itself.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Field(String);

impl Field {
    /// The member `name` of this object.
    #[must_use]
    pub fn member(&self, name: &str) -> Self {
        if self.0.is_empty() { Self(name.to_owned()) } else { Self(format!("{}.{name}", self.0)) }
    }

    /// The element `index` of this list.
    #[must_use]
    pub fn element(&self, index: usize) -> Self {
        Self(format!("{}[{index}]", self.0))
    }

    /// The path as text.
    #[must_use]
    pub fn as_str(&self) -> &str {
        &self.0
    }
}

impl From<&str> for Field {
    fn from(path: &str) -> Self {
        Self(if path == "." { String::new() } else { path.to_owned() })
    }
}

impl From<&Field> for Field {
    fn from(field: &Field) -> Self {
        field.clone()
    }
}

impl fmt::Display for Field {
    /// With a colon behind it unless it is the document itself.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.0.is_empty() { Ok(()) } else { write!(f, "{}: ", self.0) }
    }
}
