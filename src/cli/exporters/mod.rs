//! What `brdfit export` can write: each format is one file here and one line in `formats`.

pub(crate) mod exporter;
pub(crate) mod formats;
mod shader;
