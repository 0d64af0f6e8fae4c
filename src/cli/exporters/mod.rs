//! Exporters of `brdfit export`: one file per format and one line in `formats`.

pub(crate) mod exporter;
pub(crate) mod formats;
mod shader;
