//! A folder of results: file names, re-use of results of an earlier run, and protection of inputs against overwriting.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

use serde::Serialize;
use serde::de::DeserializeOwned;
use tracing::{debug, info};

use crate::results::json;
use crate::results::output;
use crate::results::shard::Shard;
use crate::terminal::exit_code::Problem;

/// The program as its documents name it.
pub(crate) const PROGRAM: &str = concat!("brdfit ", env!("CARGO_PKG_VERSION"));

/// A file that a material leaves.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum ResultFile {
    /// The document of a fit.
    Fit,
    /// Its slices, drawn.
    Slices,
    /// The document of an atlas.
    Atlas,
    /// The atlas as a texture.
    AtlasKtx2,
    /// The atlas as OpenEXR.
    AtlasExr,
    /// The preview of the atlas.
    AtlasPreview,
    /// A MERL file.
    Measurement,
    /// A scene that shows the material.
    Scene,
    /// That scene, rendered.
    Rendering,
}

impl ResultFile {
    /// The name of the file of a material.
    pub(crate) fn name(self, material: &str) -> String {
        let ending = match self {
            Self::Fit => "json",
            Self::Slices => "svg",
            Self::Atlas => "atlas.json",
            Self::AtlasKtx2 => "atlas.ktx2",
            Self::AtlasExr => "atlas.exr",
            Self::AtlasPreview => "atlas.png",
            Self::Measurement => "binary",
            Self::Scene => "scene.json",
            Self::Rendering => "render.png",
        };
        format!("{material}.{ending}")
    }
}

/// A document that a later run may keep.
pub(crate) trait Reusable: Serialize + DeserializeOwned {
    /// Version of its layout that this program writes.
    const SCHEMA_VERSION: u32;

    /// Its kind of file.
    const FILE: ResultFile;

    /// The version of its layout and the program that wrote it.
    fn made_by(&self) -> (u32, &str);

    /// Names of the files that belong to it.
    fn companions(&self) -> impl Iterator<Item = &str>;
}

/// A folder for results.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct ResultFolder {
    path: PathBuf,
}

impl ResultFolder {
    /// The folder at a path, where it may not be yet.
    pub(crate) fn at(path: impl Into<PathBuf>) -> Self {
        Self { path: path.into() }
    }

    /// Makes sure that the folder exists.
    ///
    /// # Errors
    /// If it is a file, or cannot be created.
    pub(crate) fn create(&self) -> Result<(), Problem> {
        output::folder(&self.path)
    }

    /// Its path.
    pub(crate) fn path(&self) -> &Path {
        &self.path
    }

    /// Path of a file of a material.
    pub(crate) fn file(&self, file: ResultFile, material: &str) -> PathBuf {
        self.path.join(file.name(material))
    }

    /// Path of the summary of a batch or of a shard.
    pub(crate) fn summary(&self, shard: Option<Shard>) -> PathBuf {
        match shard {
            None => self.path.join("summary.json"),
            Some(shard) => self.path.join(format!("summary.{shard}.json")),
        }
    }

    /// Path of the summary of a batch as a table.
    pub(crate) fn summary_table(&self) -> PathBuf {
        self.path.join("summary.csv")
    }

    /// The document of a material that is there, if a new one would be the same bytes: made by this version of the program, with
    /// all files beside it, unchanged since as far as its form shows, and `differs` finds nothing in it that would be otherwise.
    pub(crate) fn kept<D: Reusable>(
        &self,
        material: &str,
        differs: impl FnOnce(&D) -> Option<&'static str>,
    ) -> Option<D> {
        let path = self.file(D::FILE, material);
        let bytes = fs::read(&path).ok()?;
        match self.check(&bytes, differs) {
            Ok(document) => {
                info!(file = %path.display(), "kept");
                Some(document)
            }
            Err(why) => {
                debug!(file = %path.display(), why, "computed again");
                None
            }
        }
    }

    fn check<D: Reusable>(
        &self,
        bytes: &[u8],
        differs: impl FnOnce(&D) -> Option<&'static str>,
    ) -> Result<D, &'static str> {
        let document: D = serde_json::from_slice(bytes).map_err(|_| "not such a document")?;
        if document.made_by() != (D::SCHEMA_VERSION, PROGRAM) {
            return Err("made by another version");
        }
        if let Some(why) = differs(&document) {
            return Err(why);
        }
        if json::to_vec(&document) != bytes {
            return Err("modified since it was written");
        }
        let there = |name: &str| fs::metadata(self.path.join(name)).is_ok_and(|found| found.len() > 0);
        if !document.companions().all(there) {
            return Err("one of its files is missing");
        }
        Ok(document)
    }
}

/// Whether two paths lead to one file.
pub(crate) fn is_same_file(a: &Path, b: &Path) -> bool {
    a == b || matches!((fs::canonicalize(a), fs::canonicalize(b)), (Ok(a), Ok(b)) if a == b)
}

/// Refuses to write over an input; `by` completes the message "would be overwritten".
///
/// # Errors
/// The first input at which an output lies.
pub(crate) fn keep_inputs<'a>(
    inputs: impl IntoIterator<Item = &'a Path>,
    outputs: &[PathBuf],
    by: &str,
) -> Result<(), Problem> {
    let written: BTreeSet<PathBuf> =
        outputs.iter().flat_map(|path| [Some(path.clone()), fs::canonicalize(path).ok()]).flatten().collect();
    for input in inputs {
        if written.contains(input) || fs::canonicalize(input).is_ok_and(|input| written.contains(&input)) {
            return Err(Problem::usage(format!("{}: would be overwritten{by}", input.display())));
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde::Deserialize;

    #[derive(Debug, PartialEq, Serialize, Deserialize)]
    struct Note {
        schema_version: u32,
        program: String,
        text: String,
        files: Vec<String>,
    }

    impl Reusable for Note {
        const SCHEMA_VERSION: u32 = 3;
        const FILE: ResultFile = ResultFile::Fit;

        fn made_by(&self) -> (u32, &str) {
            (self.schema_version, &self.program)
        }

        fn companions(&self) -> impl Iterator<Item = &str> {
            self.files.iter().map(String::as_str)
        }
    }

    fn note() -> Note {
        Note { schema_version: 3, program: PROGRAM.to_owned(), text: "a".to_owned(), files: vec!["x.svg".to_owned()] }
    }

    #[test]
    fn a_document_stays_only_if_a_new_one_would_be_the_same() {
        let temporary = tempfile::tempdir().unwrap();
        let folder = ResultFolder::at(temporary.path());
        let path = folder.file(ResultFile::Fit, "x");
        let kept = || folder.kept("x", |note: &Note| (note.text != "a").then_some("another text"));
        let put = |note: &Note| fs::write(&path, json::to_vec(note)).unwrap();
        assert_eq!(kept(), None);
        put(&note());
        assert_eq!(kept(), None, "x.svg is not there");
        fs::write(temporary.path().join("x.svg"), "").unwrap();
        assert_eq!(kept(), None, "x.svg is empty");
        fs::write(temporary.path().join("x.svg"), "<svg/>").unwrap();
        assert_eq!(kept(), Some(note()));
        for other in [
            Note { schema_version: 2, ..note() },
            Note { program: "brdfit 0.0.0".to_owned(), ..note() },
            Note { text: "b".to_owned(), ..note() },
        ] {
            put(&other);
            assert_eq!(kept(), None, "{other:?}");
        }
        let text = String::from_utf8(json::to_vec(&note())).unwrap();
        for text in [&text[..text.len() / 2], &text.replacen("\"a\"", " \"a\"", 1), "[]", ""] {
            fs::write(&path, text).unwrap();
            assert_eq!(kept(), None, "{text}");
        }
    }

    #[test]
    fn inputs_are_kept_however_they_are_called() {
        let temporary = tempfile::tempdir().unwrap();
        let at = |name: &str| temporary.path().join(name);
        fs::write(at("x.json"), "").unwrap();
        fs::create_dir(at("sub")).unwrap();
        let check = |input: &Path, output: PathBuf| keep_inputs([input], &[output], "; choose another name");
        let message = check(&at("x.json"), at("sub/../x.json")).unwrap_err().to_string();
        assert!(message.ends_with("x.json: would be overwritten; choose another name"), "{message}");
        assert!(check(&at("missing.json"), at("missing.json")).is_err());
        check(&at("x.json"), at("y.json")).unwrap();
        check(&at("x.json"), at("sub/x.json")).unwrap();
    }
}
