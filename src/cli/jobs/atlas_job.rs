//! The bandwidth atlas of one material and the files that hold it.

use std::fs;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

use brdfit_bandwidth::sidecar::{
    ATLAS_SCHEMA_VERSION, AtlasDocument, AtlasOptions, FileContent, FileEntry, Provenance,
};
use brdfit_bandwidth::{
    Atlas, AtlasChannels, AtlasError, Layout, LobeGrid, LobeOptions, compute_atlas, exr, ktx2, png_bytes, preview,
};
use brdfit_brdf::Brdf;
use brdfit_measured::SamplePosition;
use rayon::prelude::*;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use tracing::{debug, info};

use crate::jobs::batch::in_pool;
use crate::jobs::fit_job::PROGRAM;
use crate::jobs::material_source::Origin;
use crate::results::json;
use crate::results::output;
use crate::terminal::exit_code::Problem;

/// `<name>.atlas.json`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[schemars(title = "brdfit bandwidth atlas")]
pub(crate) struct Sidecar {
    #[serde(flatten)]
    pub(crate) atlas: AtlasDocument,
    /// Where in its cell a sample of the measurement was taken to lie; absent for a fit.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(crate) sample_position: Option<SamplePosition>,
}

/// What is computed of each material, and into which files it goes.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct AtlasJob {
    pub(crate) layout: Layout,
    pub(crate) channels: AtlasChannels,
    pub(crate) options: LobeOptions,
    pub(crate) files: Vec<FileContent>,
}

impl Default for AtlasJob {
    fn default() -> Self {
        Self {
            layout: Layout::Isotropic,
            channels: AtlasChannels::Max,
            options: LobeOptions::default(),
            files: vec![FileContent::Ktx2Half, FileContent::ExrHalf],
        }
    }
}

/// Makes atlases that share a job, and with it the grid of directions.
#[derive(Debug)]
pub(crate) struct AtlasMaker {
    job: AtlasJob,
    grid: LobeGrid,
    /// Held while an atlas is computed, which takes all threads and up to 200 MB.
    turn: Mutex<()>,
}

/// An atlas that is ready to be written.
#[derive(Debug)]
pub(crate) struct MadeAtlas {
    sidecar: Sidecar,
    files: Vec<Vec<u8>>,
}

impl AtlasMaker {
    pub(crate) fn new(job: AtlasJob) -> Self {
        Self { job, grid: LobeGrid::default(), turn: Mutex::new(()) }
    }

    /// The sidecar that is in the folder, if a new one of this material would be the same: made by this version of the program
    /// with these options from the same source, unchanged since, and all its files are there.
    pub(crate) fn reusable(&self, folder: &Path, origin: &Origin) -> Option<Sidecar> {
        let name = &origin.source.name;
        let path = sidecar_path(folder, name);
        let bytes = fs::read(&path).ok()?;
        let refuse = |why: &str| {
            debug!(file = %path.display(), why, "made again");
            None
        };
        let Ok(sidecar) = serde_json::from_slice::<Sidecar>(&bytes) else {
            return refuse("it is not the document of an atlas");
        };
        let Sidecar { atlas, sample_position } = &sidecar;
        if atlas.schema_version != ATLAS_SCHEMA_VERSION || atlas.program != PROGRAM {
            return refuse("another version made it");
        }
        if (&atlas.source, *sample_position) != (&origin.source, origin.sample_position) {
            return refuse("the material is another one");
        }
        if atlas.options != AtlasOptions::from(&self.job.options)
            || (atlas.layout, atlas.channels) != (self.job.layout, self.job.channels)
            || atlas.files != self.job.entries(name)
        {
            return refuse("the options are others");
        }
        if json::to_vec(&sidecar) != bytes {
            return refuse("it was changed by hand");
        }
        let there = |entry: &FileEntry| fs::metadata(folder.join(&entry.name)).is_ok_and(|found| found.len() > 0);
        if !atlas.files.iter().all(there) {
            return refuse("a file is missing");
        }
        info!(file = %path.display(), "kept");
        Some(sidecar)
    }

    /// Computes and encodes the atlas of a material; `label` names it in messages.
    ///
    /// # Errors
    /// A material with values beyond the range of the computation.
    pub(crate) fn make(&self, brdf: &dyn Brdf, origin: Origin, label: &str) -> Result<MadeAtlas, Problem> {
        let AtlasJob { layout, channels, options, .. } = &self.job;
        let provenance = Provenance { program: PROGRAM.to_owned(), source: origin.source };
        let failed = |error: AtlasError| Problem::computation(format!("{label}: {error}"));
        let (atlas, statistics) = {
            let _turn = self.turn.lock().unwrap_or_else(PoisonError::into_inner);
            in_pool(|| compute_atlas(brdf, *layout, *channels, &self.grid, options)).map_err(failed)?
        };
        let encode = |&content: &FileContent| encode(&atlas, &provenance, content);
        let files = in_pool(|| self.job.files.par_iter().map(encode).collect::<Result<_, _>>()).map_err(failed)?;
        debug!(material = label, ?statistics, range = ?atlas.range(), "computed");
        let entries = self.job.entries(&provenance.source.name);
        let document = AtlasDocument::new(&atlas, provenance, options.into(), statistics, entries);
        Ok(MadeAtlas { sidecar: Sidecar { atlas: document, sample_position: origin.sample_position }, files })
    }
}

impl MadeAtlas {
    /// Writes all files. The sidecar is the last one: where it is, its files are.
    ///
    /// # Errors
    /// As [`output::write`].
    pub(crate) fn write(self, folder: &Path) -> Result<Sidecar, Problem> {
        let path = sidecar_path(folder, &self.sidecar.atlas.source.name);
        output::remove(&path)?;
        for (entry, bytes) in self.sidecar.atlas.files.iter().zip(&self.files) {
            output::write(&folder.join(&entry.name), bytes)?;
        }
        output::write(&path, &json::to_vec(&self.sidecar))?;
        info!(file = %path.display(), "written");
        Ok(self.sidecar)
    }
}

impl AtlasJob {
    /// The files of a material.
    fn entries(&self, name: &str) -> Vec<FileEntry> {
        let entry = |&content: &FileContent| FileEntry { name: file_name(name, extension(content)), content };
        self.files.iter().map(entry).collect()
    }
}

/// The sidecar of a material.
pub(crate) fn sidecar_path(folder: &Path, name: &str) -> PathBuf {
    folder.join(file_name(name, "json"))
}

/// The name of a file that belongs to the atlas of a material.
pub(crate) fn file_name(name: &str, extension: &str) -> String {
    format!("{name}.atlas.{extension}")
}

/// The extension of the files with this content.
fn extension(content: FileContent) -> &'static str {
    match content {
        FileContent::Ktx2Half => "ktx2",
        FileContent::ExrHalf | FileContent::ExrFloat => "exr",
        FileContent::PngPreview => "png",
    }
}

fn encode(atlas: &Atlas, provenance: &Provenance, content: FileContent) -> Result<Vec<u8>, AtlasError> {
    match content {
        FileContent::Ktx2Half => Ok(ktx2::to_bytes(atlas, provenance)),
        FileContent::ExrHalf => exr::to_bytes(atlas, provenance, exr::Samples::Half),
        FileContent::ExrFloat => exr::to_bytes(atlas, provenance, exr::Samples::Float),
        FileContent::PngPreview => png_bytes(&preview(atlas, &provenance.source.name)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use brdfit_bandwidth::sidecar::AtlasStatistics;
    use brdfit_bandwidth::{Rule, SIZE};

    /// A made atlas of a material that is the same everywhere.
    fn made(maker: &AtlasMaker, origin: &Origin) -> MadeAtlas {
        let AtlasJob { layout, channels, options, .. } = &maker.job;
        let texels = vec![0.0; SIZE * SIZE * channels.count()];
        let atlas = Atlas::from_level0(*layout, *channels, texels).unwrap();
        let provenance = Provenance { program: PROGRAM.to_owned(), source: origin.source.clone() };
        let statistics = AtlasStatistics { tiles_per_resolution: vec![], saturated_tiles: vec![3] };
        let entries = maker.job.entries(&origin.source.name);
        let files = maker.job.files.iter().map(|_| b"texels".to_vec()).collect();
        let document = AtlasDocument::new(&atlas, provenance, options.into(), statistics, entries);
        MadeAtlas { sidecar: Sidecar { atlas: document, sample_position: origin.sample_position }, files }
    }

    #[test]
    fn what_is_kept_would_be_made_the_same() {
        let folder = tempfile::tempdir().unwrap();
        let at = |extension: &str| folder.path().join(file_name("x", extension));
        let maker = AtlasMaker::new(AtlasJob::default());
        let origin = Origin::fit("x", Some("ab".to_owned()));
        assert_eq!(maker.reusable(folder.path(), &origin), None);
        let written = made(&maker, &origin).write(folder.path()).unwrap();
        let kept = |maker: &AtlasMaker, origin: &Origin| maker.reusable(folder.path(), origin).is_some();
        assert_eq!(maker.reusable(folder.path(), &origin), Some(written));

        for other in [
            Origin::fit("x", Some("cd".to_owned())),
            Origin::fit("x", None),
            Origin { sample_position: Some(SamplePosition::Edge), ..origin.clone() },
        ] {
            assert!(!kept(&maker, &other), "{other:?}");
        }
        let change = |change: fn(&mut AtlasJob)| {
            let mut job = AtlasJob::default();
            change(&mut job);
            AtlasMaker::new(job)
        };
        for other in [
            change(|job| job.layout = Layout::Hemisphere),
            change(|job| job.channels = AtlasChannels::Rgba),
            change(|job| job.options.max_resolution = 512),
            change(|job| job.options.finest_share = 0.25),
            change(|job| job.options.estimator.rule = Rule::Epsilon(0.5)),
            change(|job| job.options.estimator.reflections = false),
            change(|job| job.files[1] = FileContent::ExrFloat),
            change(|job| job.files.push(FileContent::PngPreview)),
            change(|job| job.files.truncate(1)),
        ] {
            assert!(!kept(&other, &origin), "{other:?}");
        }

        fs::write(at("exr"), "").unwrap();
        assert!(!kept(&maker, &origin), "an empty file");
        fs::remove_file(at("exr")).unwrap();
        assert!(!kept(&maker, &origin), "a missing file");
        made(&maker, &origin).write(folder.path()).unwrap();
        assert!(kept(&maker, &origin));
        let text = fs::read_to_string(at("json")).unwrap();
        for (what, text) in [
            ("cut", text[..text.len() / 2].to_owned()),
            ("changed", text.replacen("\"delta\": ", "\"delta\":  ", 1)),
            ("of another version", text.replacen("\"program\": \"brdfit ", "\"program\": \"brdfit 0", 1)),
        ] {
            fs::write(at("json"), text).unwrap();
            assert!(!kept(&maker, &origin), "{what}");
        }
    }

    #[test]
    fn a_sidecar_is_there_only_with_its_files() {
        let folder = tempfile::tempdir().unwrap();
        let maker = AtlasMaker::new(AtlasJob::default());
        let origin = Origin::fit("x", None);
        made(&maker, &origin).write(folder.path()).unwrap();
        // the second file cannot be written
        let exr = folder.path().join(file_name("x", "exr"));
        fs::remove_file(&exr).unwrap();
        fs::create_dir(&exr).unwrap();
        let refused = made(&maker, &origin).write(folder.path()).unwrap_err().to_string();
        assert!(refused.contains("x.atlas.exr: is a folder"), "{refused}");
        assert!(!sidecar_path(folder.path(), "x").exists());
    }
}
