//! What the examples share: materials from files.

use std::error::Error;
use std::path::Path;

use brdfit_brdf::{Brdf, MaterialParameters};
use brdfit_measured::{MeasuredBrdf, MerlFile, SamplePosition};

/// A result of `brdfit fit` (.json) or a MERL file (.binary, samples at the centres of the cells), and the name of the material.
pub(crate) fn open(path: &str) -> Result<(String, Box<dyn Brdf>), Box<dyn Error>> {
    let path = Path::new(path);
    let name = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
    if path.extension().is_some_and(|extension| extension == "json") {
        return Ok((name, MaterialParameters::read(&std::fs::read(path)?)?.brdf()));
    }
    Ok((name, Box::new(MeasuredBrdf::new(&MerlFile::open(path)?, SamplePosition::Centre)?)))
}
