//! Errors of atlases and of their files, grouped by remedy.

use std::io;

/// Errors of building, writing and reading atlases. Each message is one line with the fault and the remedy; the
/// caller puts the file's name in front.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum AtlasError {
    /// The operating system failed to read or to write.
    #[error("{0}; check the path and the disk")]
    Io(#[from] io::Error),
    /// The bytes are in another format altogether.
    #[error("not {expected} file ({why}); name the atlas itself")]
    WrongFormat {
        /// The format that was asked for, with an article.
        expected: &'static str,
        /// What was found.
        why: String,
    },
    /// The bytes are in the right format and contradict it or each other.
    #[error("the file is damaged: {why}; write the atlas again")]
    Damaged {
        /// The first contradiction that was found.
        why: String,
    },
    /// A sound file that is not an atlas, or is one that this version cannot use.
    #[error("cannot be used as a bandwidth atlas: {why}; use the file as brdfit wrote it")]
    Unsupported {
        /// The difference from the files that this crate writes.
        why: String,
    },
    /// The texels handed over cannot be an atlas.
    #[error("invalid texels: {why}; check the material that they were computed from")]
    Texels {
        /// The first texel or count that is wrong.
        why: String,
    },
}

impl AtlasError {
    /// Whether the content is invalid, as opposed to an input or output error.
    #[must_use]
    pub fn is_invalid_input(&self) -> bool {
        !matches!(self, Self::Io(_))
    }
}
