//! Everything that can be wrong with a light or with a file that should hold one, sorted by what the user can do.

use std::io;

/// Why a light could not be made. Each message is one line; where a file is at fault it begins with its name.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum LightError {
    /// The operating system failed to read the file.
    #[error("{file}: {}; check the path", reason(source))]
    Io {
        /// The file.
        file: String,
        /// What the system says.
        source: io::Error,
    },
    /// The bytes are in another format altogether.
    #[error("{file}: neither an OpenEXR nor a Radiance HDR file ({why}); name an environment map")]
    WrongFormat {
        /// The file.
        file: String,
        /// What was found instead.
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
        /// What is wrong and what would be right.
        why: String,
    },
    /// Values handed over that no light has.
    #[error("radiance that no light has: {why}; it must be finite, not negative and at most 1e14")]
    Radiance {
        /// The first value or count that is wrong.
        why: String,
    },
}

/// What the operating system says, without its number.
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
    /// Whether the input was read and is wrong, in contrast to one that could not be read.
    #[must_use]
    pub fn is_invalid_input(&self) -> bool {
        !matches!(self, Self::Io { .. })
    }
}
