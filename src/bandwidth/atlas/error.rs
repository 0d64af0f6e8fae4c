//! Everything that can be wrong with an atlas or with a file that should hold one, sorted by what the user can do.

use std::io;

/// Why an atlas could not be built, written or read. Each message is one line that says what is wrong and what to do; the
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
        /// What was found instead.
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
        /// What is different from the files that this crate writes.
        why: String,
    },
    /// The texels handed over cannot be an atlas.
    #[error("texels that cannot be an atlas: {why}; check the material that they were computed from")]
    Texels {
        /// The first texel or count that is wrong.
        why: String,
    },
}

impl AtlasError {
    /// Whether the bytes were read and are wrong, in contrast to bytes that could not be read or written.
    #[must_use]
    pub fn is_invalid_input(&self) -> bool {
        !matches!(self, Self::Io(_))
    }
}
