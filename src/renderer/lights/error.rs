//! Errors of lights and of their files, grouped by remedy.

use std::io;

/// Errors of making lights. Each message is one line that begins with the file name, if a file is at fault.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum LightError {
    /// The operating system failed to read the file.
    #[error("{file}: {}; check the path", reason(source))]
    Io {
        /// The file.
        file: String,
        /// The error of the operating system.
        source: io::Error,
    },
    /// The bytes are in another format altogether.
    #[error("{file}: neither an OpenEXR nor a Radiance HDR file ({why}); name an environment map")]
    WrongFormat {
        /// The file.
        file: String,
        /// What was found.
        why: String,
    },
    /// The bytes are in the right format and contradict it.
    #[error("{file}: the file is damaged: {why}; write the environment map again")]
    Damaged {
        /// The file.
        file: String,
        /// The decoder's complaint.
        why: String,
    },
    /// A sound file that cannot be an environment map.
    #[error("{file}: cannot be used as an environment map: {why}")]
    Unsupported {
        /// The file.
        file: String,
        /// Fault and remedy.
        why: String,
    },
    /// Values handed over that no light has.
    #[error("invalid radiance: {why}; it must be finite, not negative and at most 1e14")]
    Radiance {
        /// The first value or count that is wrong.
        why: String,
    },
}

/// The message of the operating system, without the error number.
pub(crate) fn reason(error: &io::Error) -> String {
    match error.kind() {
        _ if error.raw_os_error().is_none() => error.to_string(),
        io::ErrorKind::NotFound | io::ErrorKind::NotADirectory => "no such file".to_owned(),
        io::ErrorKind::PermissionDenied => "permission denied".to_owned(),
        io::ErrorKind::IsADirectory => "is a folder".to_owned(),
        _ => format!("cannot be read ({error})"),
    }
}

impl LightError {
    /// Whether the content is invalid, as opposed to an input error.
    #[must_use]
    pub fn is_invalid_input(&self) -> bool {
        !matches!(self, Self::Io { .. })
    }
}
