//! The table of formats, and opening a file of any of them.

use std::path::Path;

use crate::error::MeasurementError;
use crate::grid::sample_position::SamplePosition;
use crate::mapped_file::MappedFile;
use crate::measurement::{Format, Measurement};
use crate::merl::measurement::MERL;
use crate::rgl::measurement::RGL;

/// All formats. A file that none recognises by its first bytes is read as the one with its extension, else as the first, whose
/// messages say what is wrong with it.
pub static FORMATS: &[&Format] = &[&MERL, &RGL];

/// Opens a measured file of any format, with its samples at `position` (`None`: where the format has them, or the
/// format's default).
///
/// The file must stay as it is while it is open: it is mapped into memory. If another process cuts it, reading the missing part
/// ends this process (SIGBUS on Unix).
///
/// # Errors
/// A file that cannot be read, is not a whole file of its format, or is of a kind that is not supported.
pub fn open(path: &Path, position: Option<SamplePosition>) -> Result<Box<dyn Measurement>, MeasurementError> {
    let file = MappedFile::open(path)?;
    let recognised = FORMATS.iter().find(|format| (format.probe)(&file));
    let format = recognised.or_else(|| FORMATS.iter().find(|format| format.has_extension(path)));
    (format.unwrap_or(&FORMATS[0]).open)(file, position)
}

/// The extensions of measured files in a folder, without the dot, in the order of [`FORMATS`].
pub fn extensions() -> impl Iterator<Item = &'static str> {
    FORMATS.iter().flat_map(|format| format.extensions.iter().copied())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_and_extensions_are_unique() {
        let unique = |words: Vec<&str>| {
            let mut sorted = words.clone();
            sorted.sort_unstable();
            sorted.dedup();
            sorted.len() == words.len()
        };
        assert!(unique(FORMATS.iter().map(|format| format.id).collect()));
        assert!(unique(extensions().collect()));
        assert!(FORMATS[0].has_extension(Path::new("a/x.binary")) && !FORMATS[0].has_extension(Path::new("binary")));
    }

    /// What no format recognises is read by its extension.
    #[test]
    fn the_extension_decides_where_the_bytes_do_not() {
        let folder = tempfile::tempdir().unwrap();
        for (name, part) in [("x.binary", "not a MERL"), ("x.bsdf", "not an RGL"), ("x", "not a MERL")] {
            let path = folder.path().join(name);
            std::fs::write(&path, b"<!DOCTYPE html><title>404 Not Found</title>").unwrap();
            let message = open(&path, None).unwrap_err().to_string();
            assert!(message.contains(part), "{message}");
        }
    }
}
