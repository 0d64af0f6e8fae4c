//! Finds the measured data, which is not part of the repository, and unpacks it into the target folder.

use std::fs::{self, File};
use std::io::{BufReader, Read};
use std::path::{Path, PathBuf};

use lzma_rust2::XzReader;

/// The folder of the test data: `BRDFIT_DATA`, else `../shared/data` counted from the workspace's root.
///
/// Without it tests are skipped, loudly; where `CI=true` they fail.
pub(crate) fn folder() -> Option<PathBuf> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let folder = std::env::var_os("BRDFIT_DATA").map_or_else(|| root.join("../shared/data"), |path| root.join(path));
    if folder.is_dir() {
        return Some(folder);
    }
    let missing = format!("no test data at {} (set BRDFIT_DATA)", folder.display());
    assert!(std::env::var("CI").as_deref() != Ok("true"), "{missing}");
    eprintln!("SKIPPED: {missing}");
    None
}

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
    let cache = Path::new(env!("CARGO_TARGET_TMPDIR")).join("measured");
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
