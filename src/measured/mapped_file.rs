//! A file in memory: mapped from disk, or made by a program.

use std::fs::File;
use std::ops::Deref;
use std::path::{Path, PathBuf};

use memmap2::Mmap;

use crate::error::{ContainerFault, MeasurementError, Unreadable};

/// The bytes of a file, read-only, with its name. Pages that are not accessed are not read from disk.
#[derive(Debug)]
pub(crate) struct MappedFile {
    path: PathBuf,
    bytes: Bytes,
}

#[derive(Debug)]
enum Bytes {
    Mapped(Mmap),
    Owned(Vec<u8>),
}

impl MappedFile {
    /// Maps a regular file that is not empty.
    ///
    /// The file must stay as it is while it is open. If another process cuts it, reading the missing part ends this
    /// process (SIGBUS on Unix); if another process writes to it, old and new values may be seen mixed.
    ///
    /// # Errors
    /// [`Unreadable`], or [`ContainerFault::Empty`].
    pub(crate) fn open(path: &Path) -> Result<Self, MeasurementError> {
        let failed = |source| MeasurementError::new(path, Unreadable::from(source));
        // Asked before opening, because opening a pipe would wait for its writer.
        let kind = std::fs::metadata(path).map_err(failed)?.file_type();
        if kind.is_dir() {
            return Err(MeasurementError::new(path, Unreadable::IsDirectory));
        }
        if !kind.is_file() {
            return Err(MeasurementError::new(path, Unreadable::NotARegularFile));
        }
        let file = File::open(path).map_err(failed)?;
        if file.metadata().map_err(failed)?.len() == 0 {
            return Err(MeasurementError::new(path, ContainerFault::Empty));
        }
        let bytes = Bytes::Mapped(map(&file).map_err(failed)?);
        Ok(Self { path: path.to_path_buf(), bytes })
    }

    /// Takes the bytes of a whole file; `path` serves messages only.
    pub(crate) fn from_bytes(path: impl Into<PathBuf>, bytes: Vec<u8>) -> Self {
        Self { path: path.into(), bytes: Bytes::Owned(bytes) }
    }

    /// The path as it was given.
    pub(crate) fn path(&self) -> &Path {
        &self.path
    }

    /// Tells the system that the whole file is about to be read: one call instead of a page fault per 64 kB. A hint, so
    /// that it does not matter where it fails (Linux before 5.14) or does not exist.
    pub(crate) fn expect_all(&self) {
        #[cfg(target_os = "linux")]
        if let Bytes::Mapped(map) = &self.bytes {
            let _ = map.advise(memmap2::Advice::PopulateRead);
        }
    }
}

impl Deref for MappedFile {
    type Target = [u8];

    #[inline]
    fn deref(&self) -> &[u8] {
        match &self.bytes {
            Bytes::Mapped(map) => map,
            Bytes::Owned(bytes) => bytes,
        }
    }
}

/// Maps a whole regular file for reading.
fn map(file: &File) -> std::io::Result<Mmap> {
    // SAFETY: the map is read-only and lives as long as the slice that is borrowed from it, and its length is the file's
    // at the time of the call. Every bit pattern is valid for the bytes and the numbers that are read. What remains is
    // what no check in this process can exclude: another process may write to the file (the bytes seen then change under
    // a shared reference, which the language does not allow for) or cut it (reading past the new end raises SIGBUS). All
    // sizes come from the length of the map and nothing that was read once is relied on to read the same again, so a
    // concurrent write leads to wrong values, not to an access outside the map. The documentation of `MappedFile::open`
    // asks for files that stay as they are.
    #[allow(unsafe_code)]
    unsafe {
        Mmap::map(file)
    }
}
