//! Metadata of an atlas in EXR and KTX2 files.

use crate::atlas::error::AtlasError;
use crate::atlas::sidecar::{ATLAS_SCHEMA_VERSION, Mapping, Provenance, Source};
use crate::atlas::texture::{Atlas, Layout, UNITS};

/// The metadata of EXR and KTX2 files, sorted by key.
pub(crate) fn attributes(atlas: &Atlas, provenance: &Provenance, encoding: &str) -> Vec<(&'static str, String)> {
    let source = &provenance.source;
    let mut list = vec![
        ("brdfit.encoding", encoding.to_owned()),
        ("brdfit.layout", atlas.layout().name().to_owned()),
        ("brdfit.mapping", Mapping::new(atlas.layout()).text()),
        ("brdfit.program", provenance.program.clone()),
        ("brdfit.schema_version", ATLAS_SCHEMA_VERSION.to_string()),
        ("brdfit.source.kind", source.kind.clone()),
        ("brdfit.source.name", source.name.clone()),
    ];
    list.extend(source.sha256.iter().map(|sha256| ("brdfit.source.sha256", sha256.clone())));
    list.push(("brdfit.units", UNITS.to_owned()));
    list
}

/// Layout and origin from the texts of a file, `find` looks one up.
///
/// # Errors
/// [`AtlasError::Unsupported`] if a text is missing or of another version, unit or layout.
pub(crate) fn from_attributes(find: impl Fn(&str) -> Option<String>) -> Result<(Layout, Provenance), AtlasError> {
    let need = |key: &str| find(key).ok_or_else(|| AtlasError::unsupported(format!("it does not say {key}")));
    let unknown = |key: &str, value: &str| AtlasError::unsupported(format!("{key} is '{value}'"));
    let version = need("brdfit.schema_version")?;
    if version != ATLAS_SCHEMA_VERSION.to_string() {
        return Err(AtlasError::unsupported(format!("schema version {version}, not {ATLAS_SCHEMA_VERSION}")));
    }
    let units = need("brdfit.units")?;
    if units != UNITS {
        return Err(unknown("brdfit.units", &units));
    }
    let layout = need("brdfit.layout")?;
    let known = [Layout::Isotropic, Layout::Hemisphere].into_iter().find(|known| known.name() == layout);
    let layout = known.ok_or_else(|| unknown("brdfit.layout", &layout))?;
    let (name, kind) = (need("brdfit.source.name")?, need("brdfit.source.kind")?);
    let source = Source { name, sha256: find("brdfit.source.sha256"), kind };
    Ok((layout, Provenance { program: need("brdfit.program")?, source }))
}
