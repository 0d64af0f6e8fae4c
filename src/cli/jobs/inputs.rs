//! Expands inputs (files, folders, lists) to the files of a batch, each once, sorted by name.

use std::collections::BTreeMap;
use std::ffi::OsStr;
use std::fs;
use std::io::Read;
use std::path::{Path, PathBuf};

use brdfit_measured::extensions as measured_extensions;
use serde::Deserialize;
use serde::de::IgnoredAny;
use serde_json::error::Category;

use crate::results::folder::is_same_file;
use crate::terminal::exit_code::Problem;

/// Kinds of files that a command accepts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Wanted {
    /// Measured files; from folders, those with the extension of a format.
    Measured,
    /// Measured files and the results of fits; from folders, those with the extension of a format, and of what ends in .json
    /// all but other documents.
    Materials,
}

impl Wanted {
    /// Whether a file is taken from a folder.
    fn takes(self, path: &Path) -> bool {
        match path.extension().and_then(OsStr::to_str) {
            Some(extension) if measured_extensions().any(|known| known == extension) => true,
            Some("json") => self == Self::Materials && may_be_fit(path),
            _ => false,
        }
    }

    /// The files of [`Self::takes`] in words.
    fn name(self) -> String {
        let measured = measured_extensions().map(|extension| format!(".{extension}")).collect::<Vec<_>>().join(" or ");
        match self {
            Self::Measured => format!("{measured} file"),
            Self::Materials => format!("{measured} file or fit"),
        }
    }
}

/// Whether a file is a document with a list of channels, or none at all: then its turn in the batch reports the error.
fn may_be_fit(path: &Path) -> bool {
    #[derive(Deserialize)]
    struct Channels {
        #[serde(rename = "channels")]
        _list: Vec<IgnoredAny>,
    }
    let read = fs::read(path).map(|bytes| serde_json::from_slice::<Channels>(&bytes));
    !matches!(read, Ok(Err(error)) if error.classify() == Category::Data)
}

/// A file and the name of its results.
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
    /// If the name is unsuitable for a result: it is empty, or that of a fit collides with a summary.
    pub(crate) fn new(path: PathBuf, wanted: Wanted) -> Result<Self, Problem> {
        let Some(name) = path.file_stem().map(|stem| stem.to_string_lossy().into_owned()) else {
            return Err(Problem::usage(format!("{}: is not a file name; name a measured file", path.display())));
        };
        if wanted == Wanted::Measured && (name == "summary" || name.starts_with("summary.")) {
            return Err(Problem::usage(format!(
                "{}: its result would overwrite the summary {name}.json; rename the file",
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
pub(crate) fn collect(typed: &[PathBuf], recursive: bool, wanted: Wanted) -> Result<Vec<InputFile>, Problem> {
    let mut paths = Vec::new();
    for input in typed {
        match input.to_str().and_then(|text| text.strip_prefix('@')) {
            Some(list) => {
                for entry in read_list(list)? {
                    expand(&entry, recursive, wanted, &mut paths)?;
                }
            }
            None => expand(input, recursive, wanted, &mut paths)?,
        }
    }
    let mut by_name: BTreeMap<String, InputFile> = BTreeMap::new();
    for path in paths {
        let input = InputFile::new(path, wanted)?;
        if let Some(other) = by_name.get(&input.name)
            && !is_same_file(&other.path, &input.path)
        {
            return Err(Problem::usage(format!(
                "{} and {}: two inputs with the name {}; rename one, or write their results to different folders",
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
fn expand(path: &Path, recursive: bool, wanted: Wanted, paths: &mut Vec<PathBuf>) -> Result<(), Problem> {
    if !path.is_dir() {
        paths.push(path.to_path_buf());
        return Ok(());
    }
    let before = paths.len();
    search(path, recursive, wanted, paths)?;
    if paths.len() == before {
        let advice = if recursive { "name another folder" } else { "name another folder, or add --recursive" };
        return Err(Problem::invalid(format!("{}: no {} in this folder; {advice}", path.display(), wanted.name())));
    }
    Ok(())
}

/// Adds the wanted files of a folder. Links to folders are not followed, they may lead round in circles.
fn search(folder: &Path, recursive: bool, wanted: Wanted, paths: &mut Vec<PathBuf>) -> Result<(), Problem> {
    let failed = |error| Problem::reading(folder, &error);
    for entry in fs::read_dir(folder).map_err(failed)? {
        let entry = entry.map_err(failed)?;
        let path = entry.path();
        if entry.file_type().map_err(failed)?.is_dir() {
            if recursive {
                search(&path, recursive, wanted, paths)?;
            }
        } else if !path.is_dir() && wanted.takes(&path) {
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
        return refuse("lists no files; write one path per line");
    }
    Ok(entries)
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
        let folder = folder(&["b.binary", "a.binary", "c.txt", "deep/d.bsdf"]);
        let typed = [folder.path().to_path_buf()];
        assert_eq!(names(&collect(&typed, false, Wanted::Measured).unwrap()), ["a", "b"]);
        assert_eq!(names(&collect(&typed, true, Wanted::Measured).unwrap()), ["a", "b", "d"]);
        let empty = [folder.path().join("deep/none")];
        fs::create_dir(&empty[0]).unwrap();
        assert!(collect(&empty, false, Wanted::Measured).unwrap_err().to_string().contains("--recursive"));
    }

    #[test]
    fn a_list_is_relative_to_itself() {
        let folder = folder(&["x/a.binary", "b.binary"]);
        let list = folder.path().join("x/list.txt");
        fs::write(&list, "\u{feff}# comment\n\n  a.binary \r\n../b.binary\nmissing.binary\n").unwrap();
        let found = collect(&[PathBuf::from(format!("@{}", list.display()))], false, Wanted::Measured).unwrap();
        assert_eq!(names(&found), ["a", "b", "missing"]);
        assert!(found[0].path.is_file() && found[1].path.is_file());
    }

    #[test]
    fn one_file_counts_once_and_two_of_a_name_are_refused() {
        let folder = folder(&["a/x.binary", "b/x.binary"]);
        let at = |path: &str| folder.path().join(path);
        assert_eq!(
            collect(&[at("a"), at("a/x.binary"), at("a/../a/x.binary")], false, Wanted::Measured).unwrap().len(),
            1
        );
        let message = collect(&[at("a"), at("b/x.binary")], false, Wanted::Measured).unwrap_err().to_string();
        assert!(message.contains("a/x.binary and ") && message.contains("b/x.binary: two inputs"), "{message}");
    }

    #[test]
    fn names_of_summaries_are_refused() {
        for name in ["summary.binary", "summary.1-of-3.binary", "..", "/"] {
            assert!(InputFile::new(name.into(), Wanted::Measured).is_err(), "{name}");
        }
        assert_eq!(InputFile::new("summary2.binary".into(), Wanted::Measured).unwrap().name, "summary2");
    }

    #[test]
    fn a_folder_of_fits_holds_other_documents_too() {
        let folder = folder(&["d.binary", "empty.json", "x.svg"]);
        for (name, content) in [
            ("fit.json", r#"{"program": "p", "channels": [{}, {}, {}]}"#),
            ("fit.atlas.json", r#"{"channels": "max"}"#),
            ("summary.json", r#"{"materials": []}"#),
            ("list.json", r#"[{"channels": []}]"#),
            ("cut.json", r#"{"chan"#),
        ] {
            fs::write(folder.path().join(name), content).unwrap();
        }
        let typed = [folder.path().to_path_buf()];
        assert_eq!(names(&collect(&typed, false, Wanted::Materials).unwrap()), ["cut", "d", "empty", "fit"]);
        assert_eq!(names(&collect(&typed, false, Wanted::Measured).unwrap()), ["d"]);
        let named = collect(&[folder.path().join("summary.json")], false, Wanted::Materials).unwrap();
        assert_eq!(names(&named), ["summary"]);
    }
}
