//! From what was typed (files, folders, lists) to the measured files of a batch, each once, in the order of their names.

use std::collections::BTreeMap;
use std::ffi::OsStr;
use std::fs;
use std::io::Read;
use std::path::{Path, PathBuf};

use crate::outcome::Problem;

/// Extension of the files that are taken from folders.
const EXTENSION: &str = "binary";

/// A measured file and the name of its results.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct InputFile {
    /// The file, as it was named or found.
    pub(crate) path: PathBuf,
    /// Its name without folder and extension.
    pub(crate) name: String,
}

impl InputFile {
    /// The input for one file.
    ///
    /// # Errors
    /// Where the name would not do for a result: it has none, or it is that of a summary.
    pub(crate) fn new(path: PathBuf) -> Result<Self, Problem> {
        let Some(name) = path.file_stem().map(|stem| stem.to_string_lossy().into_owned()) else {
            return Err(Problem::usage(format!("{}: is not the name of a file; name a MERL file", path.display())));
        };
        if name == "summary" || name.starts_with("summary.") {
            return Err(Problem::usage(format!(
                "{}: its result would take the place of {name}.json, a summary; rename the file",
                path.display()
            )));
        }
        Ok(Self { path, name })
    }
}

/// The files of a batch, sorted by name.
///
/// Files that were named are taken as they are, whether they exist or not: that is found out when their turn comes. A file
/// that is reached twice counts once.
///
/// # Errors
/// A folder or list that cannot be read or is empty, or two different files with the same name.
pub(crate) fn collect(typed: &[PathBuf], recursive: bool) -> Result<Vec<InputFile>, Problem> {
    let mut paths = Vec::new();
    for input in typed {
        match input.to_str().and_then(|text| text.strip_prefix('@')) {
            Some(list) => {
                for entry in read_list(list)? {
                    expand(&entry, recursive, &mut paths)?;
                }
            }
            None => expand(input, recursive, &mut paths)?,
        }
    }
    let mut by_name: BTreeMap<String, InputFile> = BTreeMap::new();
    for path in paths {
        let input = InputFile::new(path)?;
        if let Some(other) = by_name.get(&input.name)
            && !is_same_file(&other.path, &input.path)
        {
            return Err(Problem::usage(format!(
                "{} and {}: two inputs with the name {}; rename one, or fit them into different folders",
                other.path.display(),
                input.path.display(),
                input.name
            )));
        }
        by_name.entry(input.name.clone()).or_insert(input);
    }
    Ok(by_name.into_values().collect())
}

/// Adds a file, or the files of a folder.
fn expand(path: &Path, recursive: bool, paths: &mut Vec<PathBuf>) -> Result<(), Problem> {
    if !path.is_dir() {
        paths.push(path.to_path_buf());
        return Ok(());
    }
    let before = paths.len();
    search(path, recursive, paths)?;
    if paths.len() == before {
        let advice = if recursive { "name another folder" } else { "name another folder, or add --recursive" };
        return Err(Problem::invalid(format!("{}: no .{EXTENSION} file in this folder; {advice}", path.display())));
    }
    Ok(())
}

/// Adds the measured files of a folder. Links to folders are not followed, they may lead round in circles.
fn search(folder: &Path, recursive: bool, paths: &mut Vec<PathBuf>) -> Result<(), Problem> {
    let failed = |error| Problem::reading(folder, &error);
    for entry in fs::read_dir(folder).map_err(failed)? {
        let entry = entry.map_err(failed)?;
        let path = entry.path();
        if entry.file_type().map_err(failed)?.is_dir() {
            if recursive {
                search(&path, recursive, paths)?;
            }
        } else if path.extension() == Some(OsStr::new(EXTENSION)) && !path.is_dir() {
            paths.push(path);
        }
    }
    Ok(())
}

/// The entries of a list, relative to the folder of the list (`-`: standard input, relative to the current folder).
fn read_list(list: &str) -> Result<Vec<PathBuf>, Problem> {
    let (label, folder, bytes) = if list == "-" {
        let mut bytes = Vec::new();
        let label = PathBuf::from("standard input");
        std::io::stdin().lock().read_to_end(&mut bytes).map_err(|error| Problem::reading(&label, &error))?;
        (label, Path::new(""), bytes)
    } else {
        let path = Path::new(list);
        let bytes = fs::read(path).map_err(|error| Problem::reading(path, &error))?;
        (path.to_path_buf(), path.parent().unwrap_or(Path::new("")), bytes)
    };
    let refuse = |what: &str| Err(Problem::invalid(format!("{}: {what}", label.display())));
    let Ok(text) = String::from_utf8(bytes) else {
        return refuse("is not a text file; a list has one path per line, in UTF-8");
    };
    let lines = text.strip_prefix('\u{feff}').unwrap_or(&text).lines().map(str::trim);
    let entries: Vec<PathBuf> =
        lines.filter(|line| !line.is_empty() && !line.starts_with('#')).map(|line| folder.join(line)).collect();
    if entries.is_empty() {
        return refuse("lists no file; write one path per line");
    }
    Ok(entries)
}

fn is_same_file(a: &Path, b: &Path) -> bool {
    a == b || matches!((fs::canonicalize(a), fs::canonicalize(b)), (Ok(a), Ok(b)) if a == b)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A folder with empty files.
    fn folder(files: &[&str]) -> tempfile::TempDir {
        let folder = tempfile::tempdir().unwrap();
        for file in files {
            let path = folder.path().join(file);
            fs::create_dir_all(path.parent().unwrap()).unwrap();
            fs::write(path, "").unwrap();
        }
        folder
    }

    fn names(found: &[InputFile]) -> Vec<&str> {
        found.iter().map(|input| input.name.as_str()).collect()
    }

    #[test]
    fn folders_are_searched_and_sorted() {
        let folder = folder(&["b.binary", "a.binary", "c.txt", "deep/d.binary"]);
        let typed = [folder.path().to_path_buf()];
        assert_eq!(names(&collect(&typed, false).unwrap()), ["a", "b"]);
        assert_eq!(names(&collect(&typed, true).unwrap()), ["a", "b", "d"]);
        let empty = [folder.path().join("deep/none")];
        fs::create_dir(&empty[0]).unwrap();
        assert!(collect(&empty, false).unwrap_err().to_string().contains("--recursive"));
    }

    #[test]
    fn a_list_is_relative_to_itself() {
        let folder = folder(&["x/a.binary", "b.binary"]);
        let list = folder.path().join("x/list.txt");
        fs::write(&list, "\u{feff}# comment\n\n  a.binary \r\n../b.binary\nmissing.binary\n").unwrap();
        let found = collect(&[PathBuf::from(format!("@{}", list.display()))], false).unwrap();
        assert_eq!(names(&found), ["a", "b", "missing"]);
        assert!(found[0].path.is_file() && found[1].path.is_file());
    }

    #[test]
    fn one_file_counts_once_and_two_of_a_name_are_refused() {
        let folder = folder(&["a/x.binary", "b/x.binary"]);
        let at = |path: &str| folder.path().join(path);
        assert_eq!(collect(&[at("a"), at("a/x.binary"), at("a/../a/x.binary")], false).unwrap().len(), 1);
        let message = collect(&[at("a"), at("b/x.binary")], false).unwrap_err().to_string();
        assert!(message.contains("a/x.binary and ") && message.contains("b/x.binary: two inputs"), "{message}");
    }

    #[test]
    fn names_of_summaries_are_refused() {
        for name in ["summary.binary", "summary.1-of-3.binary", "..", "/"] {
            assert!(InputFile::new(name.into()).is_err(), "{name}");
        }
        assert_eq!(InputFile::new("summary2.binary".into()).unwrap().name, "summary2");
    }
}
