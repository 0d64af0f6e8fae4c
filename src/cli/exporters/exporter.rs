//! The interface of the formats of `brdfit export`.

/// Makes the content of one file.
pub(crate) trait Exporter: Sync {
    /// The bytes of the file.
    fn export(&self) -> Vec<u8>;
}
