//! The bandwidth atlas of one material and the files that hold it.

use std::sync::{Mutex, PoisonError};

use brdfit_bandwidth::sidecar::{
    ATLAS_SCHEMA_VERSION, AtlasDocument, AtlasOptions, FileContent, FileEntry, Provenance,
};
use brdfit_bandwidth::{Atlas, AtlasChannels, Layout, LobeGrid, LobeOptions, compute_atlas, exr, ktx2};
use brdfit_brdf::Brdf;
use brdfit_figures::png;
use brdfit_measured::SamplePosition;
use rayon::prelude::*;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use tracing::{debug, info};

use crate::jobs::batch::in_pool;
use crate::jobs::material_source::Origin;
use crate::report::atlas_preview::preview;
use crate::results::folder::{PROGRAM, ResultFile, ResultFolder, Reusable};
use crate::results::json;
use crate::results::output;
use crate::terminal::exit_code::Problem;

/// `<name>.atlas.json`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[schemars(title = "brdfit bandwidth atlas")]
pub(crate) struct Sidecar {
    #[serde(flatten)]
    pub(crate) atlas: AtlasDocument,
    /// Position of a sample of the measurement within its cell; absent for a fit.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(crate) sample_position: Option<SamplePosition>,
}

impl Reusable for Sidecar {
    const SCHEMA_VERSION: u32 = ATLAS_SCHEMA_VERSION;
    const FILE: ResultFile = ResultFile::Atlas;

    fn made_by(&self) -> (u32, &str) {
        (self.atlas.schema_version, &self.atlas.program)
    }

    fn companions(&self) -> impl Iterator<Item = &str> {
        self.atlas.files.iter().map(|entry| entry.name.as_str())
    }
}

/// Options and output files of the atlas of each material.
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

    /// The sidecar that is in the folder, if a new one of this material would be the same.
    pub(crate) fn kept(&self, folder: &ResultFolder, origin: &Origin) -> Option<Sidecar> {
        folder.kept(&origin.source.name, |Sidecar { atlas, sample_position }: &Sidecar| {
            if (&atlas.source, *sample_position) != (&origin.source, origin.sample_position) {
                return Some("the material is another one");
            }
            let same = atlas.options == AtlasOptions::from(&self.job.options)
                && (atlas.layout, atlas.channels) == (self.job.layout, self.job.channels)
                && atlas.files == self.job.entries(&origin.source.name);
            (!same).then_some("options differ")
        })
    }

    /// Computes and encodes the atlas of a material; `label` names it in messages.
    ///
    /// # Errors
    /// A material with values beyond the range of the computation.
    pub(crate) fn make(&self, brdf: &dyn Brdf, origin: Origin, label: &str) -> Result<MadeAtlas, Problem> {
        let AtlasJob { layout, channels, options, .. } = &self.job;
        let provenance = Provenance { program: PROGRAM.to_owned(), source: origin.source };
        let (atlas, statistics) = {
            let _turn = self.turn.lock().unwrap_or_else(PoisonError::into_inner);
            in_pool(|| compute_atlas(brdf, *layout, *channels, &self.grid, options))
                .map_err(|error| Problem::of(label, &error))?
        };
        let encode = |&content: &FileContent| encode(&atlas, &provenance, content, label);
        let files = in_pool(|| self.job.files.par_iter().map(encode).collect::<Result<_, _>>())?;
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
    pub(crate) fn write(self, folder: &ResultFolder) -> Result<Sidecar, Problem> {
        let path = folder.file(ResultFile::Atlas, &self.sidecar.atlas.source.name);
        output::remove(&path)?;
        for (entry, bytes) in self.sidecar.atlas.files.iter().zip(&self.files) {
            output::write(&folder.path().join(&entry.name), bytes)?;
        }
        output::write(&path, &json::to_vec(&self.sidecar))?;
        info!(file = %path.display(), "written");
        Ok(self.sidecar)
    }
}

impl AtlasJob {
    /// The files of a material.
    fn entries(&self, name: &str) -> Vec<FileEntry> {
        let entry = |&content: &FileContent| FileEntry { name: file_of(content).name(name), content };
        self.files.iter().map(entry).collect()
    }
}

/// The file that holds this content.
fn file_of(content: FileContent) -> ResultFile {
    match content {
        FileContent::Ktx2Half => ResultFile::AtlasKtx2,
        FileContent::ExrHalf | FileContent::ExrFloat => ResultFile::AtlasExr,
        FileContent::PngPreview => ResultFile::AtlasPreview,
    }
}

fn encode(atlas: &Atlas, provenance: &Provenance, content: FileContent, label: &str) -> Result<Vec<u8>, Problem> {
    let exr = |samples| exr::to_bytes(atlas, provenance, samples).map_err(|error| error.to_string());
    let encoded = match content {
        FileContent::Ktx2Half => Ok(ktx2::to_bytes(atlas, provenance)),
        FileContent::ExrHalf => exr(exr::Samples::Half),
        FileContent::ExrFloat => exr(exr::Samples::Float),
        FileContent::PngPreview => {
            png::encode(&preview(atlas, &provenance.source.name)).map_err(|error| error.to_string())
        }
    };
    encoded.map_err(|error| Problem::computation(format!("{label}: {error}")))
}

#[cfg(test)]
mod tests {
    use super::*;
    use brdfit_bandwidth::sidecar::AtlasStatistics;
    use brdfit_bandwidth::{Rule, SIZE};
    use std::fs;

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
        let temporary = tempfile::tempdir().unwrap();
        let folder = ResultFolder::at(temporary.path());
        let at = |file: ResultFile| folder.file(file, "x");
        let maker = AtlasMaker::new(AtlasJob::default());
        let origin = Origin::fit("x", Some("ab".to_owned()));
        assert_eq!(maker.kept(&folder, &origin), None);
        let written = made(&maker, &origin).write(&folder).unwrap();
        let kept = |maker: &AtlasMaker, origin: &Origin| maker.kept(&folder, origin).is_some();
        assert_eq!(maker.kept(&folder, &origin), Some(written));

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

        fs::write(at(ResultFile::AtlasExr), "").unwrap();
        assert!(!kept(&maker, &origin), "an empty file");
        fs::remove_file(at(ResultFile::AtlasExr)).unwrap();
        assert!(!kept(&maker, &origin), "a missing file");
        made(&maker, &origin).write(&folder).unwrap();
        assert!(kept(&maker, &origin));
        let text = fs::read_to_string(at(ResultFile::Atlas)).unwrap();
        for (what, text) in [
            ("cut", text[..text.len() / 2].to_owned()),
            ("changed", text.replacen("\"delta\": ", "\"delta\":  ", 1)),
            ("of another version", text.replacen("\"program\": \"brdfit ", "\"program\": \"brdfit 0", 1)),
        ] {
            fs::write(at(ResultFile::Atlas), text).unwrap();
            assert!(!kept(&maker, &origin), "{what}");
        }
    }

    #[test]
    fn a_sidecar_is_there_only_with_its_files() {
        let temporary = tempfile::tempdir().unwrap();
        let folder = ResultFolder::at(temporary.path());
        let maker = AtlasMaker::new(AtlasJob::default());
        let origin = Origin::fit("x", None);
        made(&maker, &origin).write(&folder).unwrap();
        // the second file cannot be written
        let exr = folder.file(ResultFile::AtlasExr, "x");
        fs::remove_file(&exr).unwrap();
        fs::create_dir(&exr).unwrap();
        let refused = made(&maker, &origin).write(&folder).unwrap_err().to_string();
        assert!(refused.contains("x.atlas.exr: is a folder"), "{refused}");
        assert!(!folder.file(ResultFile::Atlas, "x").exists());
    }
}
