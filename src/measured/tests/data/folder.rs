//! Finds the test data, which is not part of the repository.

use std::path::{Path, PathBuf};

/// The folder of the test data: `BRDFIT_DATA`, else `../shared/data` counted from the workspace's root.
///
/// Without it tests are skipped, loudly; where `CI=true` they fail, also on stand-ins (`scripts/fixtures/make_stand_ins.sh`)
/// that `BRDFIT_DATA` does not name.
pub(crate) fn folder() -> Option<PathBuf> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let named = std::env::var_os("BRDFIT_DATA");
    let folder = named.as_ref().map_or_else(|| root.join("../shared/data"), |path| root.join(path));
    let ci = std::env::var("CI").as_deref() == Ok("true");
    if folder.is_dir() {
        let unnamed = named.is_none() && holds_stand_ins(&folder);
        assert!(!(ci && unnamed), "{} holds stand-ins: name them by BRDFIT_DATA", folder.display());
        return Some(folder);
    }
    assert!(!ci, "no test data at {} (set BRDFIT_DATA)", folder.display());
    eprintln!("SKIPPED: no test data at {} (set BRDFIT_DATA)", folder.display());
    None
}

/// The same folder for tests of what only the genuine data has: skipped, loudly, on stand-ins.
#[allow(dead_code)] // not every test program has such tests
pub(crate) fn genuine() -> Option<PathBuf> {
    let folder = folder()?;
    if holds_stand_ins(&folder) {
        eprintln!("SKIPPED: {} holds stand-ins, and this test is about the genuine data", folder.display());
        return None;
    }
    Some(folder)
}

/// Whether `scripts/fixtures/make_stand_ins.sh` made it.
pub(crate) fn holds_stand_ins(folder: &Path) -> bool {
    folder.join("STAND_INS").exists()
}
