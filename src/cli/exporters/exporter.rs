//! What every format of `brdfit export` does.

/// Makes the content of one file.
pub(crate) trait Exporter: Sync {
    /// The bytes of the file.
    fn export(&self) -> Vec<u8>;
}
