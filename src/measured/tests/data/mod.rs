//! Finds the measured files and unpacks them into the target folder.

use std::fs::{self, File};
use std::io::{BufReader, Read};
use std::path::{Path, PathBuf};

use lzma_rust2::XzReader;

mod folder;

#[allow(unused_imports)] // no test program needs both
pub(crate) use folder::{folder, genuine};

/// The contents of an xz file.
pub(crate) fn unpacked(path: &Path) -> Vec<u8> {
    let mut bytes = Vec::new();
    let packed = File::open(path).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
    XzReader::new(BufReader::new(packed), true)
        .read_to_end(&mut bytes)
        .unwrap_or_else(|e| panic!("{}: {e}", path.display()));
    bytes
}

/// The measured files in the order of their names, unpacked once into the target folder and found there later.
pub(crate) fn measured(data: &Path) -> Vec<PathBuf> {
    let cache = Path::new(env!("CARGO_TARGET_TMPDIR")).join(if folder::holds_stand_ins(data) {
        "stand-ins"
    } else {
        "measured"
    });
    fs::create_dir_all(&cache).unwrap();
    let mut files: Vec<PathBuf> = fs::read_dir(data.join("measured"))
        .unwrap()
        .map(|entry| entry.unwrap().path())
        .filter(|path| path.to_string_lossy().ends_with(".binary.xz"))
        .map(|packed| {
            let file = cache.join(packed.file_stem().unwrap());
            if !file.exists() {
                let mut partial = tempfile::NamedTempFile::new_in(&cache).unwrap();
                std::io::Write::write_all(&mut partial, &unpacked(&packed)).unwrap();
                partial.persist(&file).unwrap();
            }
            file
        })
        .collect();
    files.sort();
    assert!(!files.is_empty(), "no .binary.xz files in {}", data.display());
    files
}
