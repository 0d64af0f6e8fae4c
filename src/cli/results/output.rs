//! Output: atomic writing of files, folders, standard output.
//!
//! A file is written under a temporary name beside its target, then renamed. The temporary file is locked while its writer
//! lives, so that the next run can tell the remains of a killed run (no lock) from the work of a concurrent one, also
//! across containers that share the folder: process numbers or ages cannot.

use std::collections::BTreeSet;
use std::ffi::OsStr;
use std::fs::{self, File, TryLockError};
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};

use tempfile::{NamedTempFile, TempPath};

use crate::terminal::exit_code::Problem;

/// Temporary names are `.brdfit-XXXXXX.tmp`.
const PREFIX: &str = ".brdfit-";
const SUFFIX: &str = ".tmp";

/// Lock held while temporary files are created, renamed or removed.
static OPEN: Mutex<Open> = Mutex::new(Open { temporary: BTreeSet::new(), swept: BTreeSet::new() });

/// Temporary files of this process.
struct Open {
    /// Temporary files that exist.
    temporary: BTreeSet<PathBuf>,
    /// Folders that were searched for the remains of killed runs.
    swept: BTreeSet<PathBuf>,
}

/// Writes a whole file, which replaces an older one in one step.
///
/// # Errors
/// Errors of the operating system; an existing file is then unchanged.
pub(crate) fn write(path: &Path, bytes: &[u8]) -> Result<(), Problem> {
    write_with(path, |out| out.write_all(bytes))
}

/// As [`write()`], without waiting for the disk (milliseconds per file): after a power failure, though not after a crash of
/// the program, the file may be empty. For results that the next run checks.
///
/// # Errors
/// As [`write()`].
pub(crate) fn write_recoverable(path: &Path, bytes: &[u8]) -> Result<(), Problem> {
    try_write(path, Wait::No, |out| out.write_all(bytes)).map_err(|error| Problem::writing(path, &error))
}

/// Whether to wait until the disk has the content.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Wait {
    Yes,
    No,
}

/// As [`write()`], for what is made piece by piece. Calls of `out` are buffered.
///
/// # Errors
/// As [`write()`], or what `content` returns.
pub(crate) fn write_with(path: &Path, content: impl FnOnce(&mut dyn Write) -> io::Result<()>) -> Result<(), Problem> {
    try_write(path, Wait::Yes, content).map_err(|error| Problem::writing(path, &error))
}

fn try_write(path: &Path, wait: Wait, content: impl FnOnce(&mut dyn Write) -> io::Result<()>) -> io::Result<()> {
    let target = match fs::metadata(path) {
        Ok(found) if found.is_dir() => return Err(io::ErrorKind::IsADirectory.into()),
        // Through a symbolic link to the file itself.
        Ok(found) if found.is_file() => fs::canonicalize(path)?,
        // A pipe or a device cannot be replaced, only written to.
        Ok(_) => return fill(File::options().write(true).open(path)?, content).map(drop),
        Err(_) => path.to_path_buf(),
    };
    let temporary = Temporary::create(parent(&target))?;
    let file = fill(temporary.file, content)?;
    if wait == Wait::Yes {
        file.sync_data()?;
    }
    temporary.name.persist(&target)?;
    Ok(())
}

/// Writes the content and hands the file back, all of it passed to the operating system.
fn fill(file: File, content: impl FnOnce(&mut dyn Write) -> io::Result<()>) -> io::Result<File> {
    let mut out = BufWriter::with_capacity(1 << 16, file);
    content(&mut out)?;
    out.into_inner().map_err(io::IntoInnerError::into_error)
}

/// Refuses a path at which no file can appear, before the work for it begins.
///
/// # Errors
/// A folder in its place, or no folder to hold it.
pub(crate) fn expect_place(path: &Path) -> Result<(), Problem> {
    let wrong = match path {
        _ if path.is_dir() => io::ErrorKind::IsADirectory,
        _ if !parent(path).is_dir() => io::ErrorKind::NotFound,
        _ => return Ok(()),
    };
    Err(Problem::writing(path, &wrong.into()))
}

/// The folder that a file lies in.
fn parent(path: &Path) -> &Path {
    path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."))
}

/// A locked temporary file that [`end`] knows of.
struct Temporary {
    file: File,
    name: Registered,
}

/// The name of a temporary file; the file goes when it is dropped.
struct Registered {
    path: Option<TempPath>,
}

impl Temporary {
    fn create(folder: &Path) -> io::Result<Self> {
        let mut open = open();
        if open.swept.insert(folder.to_path_buf()) {
            sweep(folder);
        }
        loop {
            let named = new_file(folder)?;
            // A sweep of another process may hold the new file or have removed it: then take another.
            if matches!(named.as_file().try_lock(), Err(TryLockError::WouldBlock)) || !named.path().exists() {
                continue;
            }
            open.temporary.insert(named.path().to_path_buf());
            let (file, path) = named.into_parts();
            return Ok(Self { file, name: Registered { path: Some(path) } });
        }
    }
}

impl Registered {
    fn persist(mut self, target: &Path) -> io::Result<()> {
        let mut open = open();
        let Some(path) = self.path.take() else { return Ok(()) };
        open.temporary.remove(path.to_path_buf().as_path());
        path.persist(target).map_err(|failed| failed.error)
    }
}

impl Drop for Registered {
    fn drop(&mut self) {
        if let Some(path) = self.path.take() {
            let mut open = open();
            open.temporary.remove(path.to_path_buf().as_path());
            drop(path);
        }
    }
}

fn open() -> MutexGuard<'static, Open> {
    OPEN.lock().unwrap_or_else(PoisonError::into_inner)
}

/// An empty file with the permissions that other new files have.
fn new_file(folder: &Path) -> io::Result<NamedTempFile> {
    let mut builder = tempfile::Builder::new();
    builder.prefix(PREFIX).suffix(SUFFIX);
    #[cfg(unix)]
    builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666)); // the umask takes its part
    builder.tempfile_in(folder)
}

/// Removes what killed runs left in a folder: temporary files of this program without a living owner.
fn sweep(folder: &Path) {
    let Ok(entries) = fs::read_dir(folder) else { return };
    for entry in entries.flatten().filter(|entry| is_temporary(&entry.file_name())) {
        if entry.file_type().is_ok_and(|kind| kind.is_file())
            && let Ok(file) = File::open(entry.path())
            && file.try_lock().is_ok()
        {
            let _ = fs::remove_file(entry.path());
        }
    }
}

fn is_temporary(name: &OsStr) -> bool {
    name.to_str().is_some_and(|name| name.starts_with(PREFIX) && name.ends_with(SUFFIX))
}

/// Removes a file; one that is not there is no error.
///
/// # Errors
/// Errors of the operating system.
pub(crate) fn remove(path: &Path) -> Result<(), Problem> {
    match fs::remove_file(path) {
        Err(error) if error.kind() != io::ErrorKind::NotFound => Err(Problem::writing(path, &error)),
        _ => Ok(()),
    }
}

/// Drops every file that is being written and ends the process, from any thread: what Ctrl-C does.
pub(crate) fn end(code: u8) -> ! {
    let open = open(); // held to the end: nothing appears any more
    for path in &open.temporary {
        let _ = fs::remove_file(path);
    }
    std::process::exit(code.into())
}

/// Makes sure that an output folder exists.
///
/// # Errors
/// If it is a file, or cannot be created.
pub(crate) fn folder(path: &Path) -> Result<(), Problem> {
    if path.is_file() {
        return Err(Problem::input_output(format!(
            "{}: is a file, not a folder; name the folder for the results with -o",
            path.display()
        )));
    }
    fs::create_dir_all(path).map_err(|error| match error.kind() {
        io::ErrorKind::NotADirectory | io::ErrorKind::AlreadyExists => Problem::input_output(format!(
            "{}: a part of this path is a file; choose another folder with -o",
            path.display()
        )),
        _ => Problem::writing(path, &error),
    })
}

/// Writes to the file, or to standard output where there is none or where it is called `-`.
///
/// # Errors
/// As [`write()`] and [`print()`].
pub(crate) fn deliver(path: Option<&Path>, bytes: &[u8]) -> Result<(), Problem> {
    match path {
        Some(path) if path != Path::new("-") => write(path, bytes),
        _ => print_bytes(bytes),
    }
}

/// Writes a text to standard output. A reader that has gone away (`| head`) is no error.
///
/// # Errors
/// Errors of the operating system.
pub(crate) fn print(text: &str) -> Result<(), Problem> {
    print_bytes(text.as_bytes())
}

fn print_bytes(bytes: &[u8]) -> Result<(), Problem> {
    let mut out = io::stdout().lock();
    match out.write_all(bytes).and_then(|()| out.flush()) {
        Err(error) if error.kind() != io::ErrorKind::BrokenPipe => {
            Err(Problem::writing(Path::new("standard output"), &error))
        }
        _ => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(folder: &Path) -> Vec<String> {
        let mut names: Vec<String> =
            fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
        names.sort();
        names
    }

    #[test]
    fn a_file_is_replaced_whole_or_not_at_all() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("x.json");
        write(&path, b"one").unwrap();
        write(&path, b"two").unwrap();
        let failed = write_with(&path, |out| {
            out.write_all(b"half")?;
            Err(io::ErrorKind::StorageFull.into())
        });
        assert!(failed.unwrap_err().to_string().contains("no space left"));
        assert_eq!(fs::read(&path).unwrap(), b"two");
        assert_eq!(names(folder.path()), ["x.json"]);
    }

    #[test]
    fn a_sweep_takes_what_has_no_owner_only() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        for name in [".brdfit-orphan.tmp", ".brdfit-living.tmp", ".other-x.tmp", "brdfit-x.tmp", ".brdfit-x.json"] {
            fs::write(at(name), "x").unwrap();
        }
        fs::create_dir(at(".brdfit-folder.tmp")).unwrap();
        let living = File::open(at(".brdfit-living.tmp")).unwrap();
        living.lock().unwrap();
        write(&at("y"), b"y").unwrap();
        assert_eq!(
            names(folder.path()),
            [".brdfit-folder.tmp", ".brdfit-living.tmp", ".brdfit-x.json", ".other-x.tmp", "brdfit-x.tmp", "y"]
        );
    }

    #[test]
    fn a_temporary_file_of_this_process_survives_a_sweep() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("x");
        write_with(&path, |out| {
            sweep(folder.path());
            out.write_all(b"x")
        })
        .unwrap();
        assert_eq!(names(folder.path()), ["x"]);
    }

    #[cfg(unix)]
    #[test]
    fn links_are_followed_and_devices_are_not_replaced() {
        use std::os::unix::fs::{FileTypeExt, symlink};
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        fs::write(at("real"), "old").unwrap();
        symlink(at("real"), at("link")).unwrap();
        write(&at("link"), b"new").unwrap();
        assert!(at("link").is_symlink());
        assert_eq!(fs::read(at("real")).unwrap(), b"new");
        write(Path::new("/dev/null"), b"x").unwrap();
        assert!(fs::metadata("/dev/null").unwrap().file_type().is_char_device());
    }

    #[test]
    fn a_folder_that_cannot_be_is_named() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("x");
        fs::write(&file, "x").unwrap();
        assert!(super::folder(&file).unwrap_err().to_string().contains("is a file, not a folder"));
        assert!(super::folder(&file.join("y")).unwrap_err().to_string().contains("a part of this path is a file"));
        super::folder(&folder.path().join("a/b")).unwrap();
    }
}
