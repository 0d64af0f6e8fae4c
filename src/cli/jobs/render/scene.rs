//! Assembles the input of a frame from a scene document: surfaces, lights, materials with their atlases.

use std::cell::LazyCell;
use std::fs;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use brdfit_bandwidth::{Atlas, AtlasChannels, Layout, LobeGrid, LobeOptions, compute_atlas, exr, ktx2};
use brdfit_brdf::{Brdf, GgxMaterial, Lambert};
use brdfit_measured::SamplePosition;
use brdfit_renderer::scene::{MaterialSource, SampleLocation, SceneMaterial};
use brdfit_renderer::{Bandwidth, Light, LightSet, Material, Scene, SceneDocument, SceneError};
use tracing::info;

use crate::args::embedded_materials;
use crate::jobs::batch::in_pool;
use crate::jobs::inputs::{InputFile, Wanted};
use crate::jobs::material_source::{MaterialInput, Reading};
use crate::results::documents::Document;
use crate::terminal::exit_code::Problem;

/// A scene, ready to be rendered.
pub(crate) struct LoadedScene {
    pub(crate) scene: Scene,
    pub(crate) lights: LightSet,
    /// Time for the bandwidth of the lights.
    pub(crate) light_bandwidth: Duration,
    /// In the order of the G-buffer's indices.
    pub(crate) materials: Vec<LoadedMaterial>,
    pub(crate) sha256: String,
}

/// A BRDF and its bandwidth.
pub(crate) struct LoadedMaterial {
    brdf: Box<dyn Brdf>,
    /// None for a diffuse material, whose bandwidth is 0.
    atlas: Option<Atlas>,
}

impl LoadedMaterial {
    /// As frames take it.
    pub(crate) fn for_frames(&self) -> Material<'_> {
        Material::new(self.brdf.as_ref(), self.atlas.as_ref().map_or(Bandwidth::Constant(0.0), Bandwidth::Atlas))
    }
}

/// Folders of the files that a scene names.
struct Folders<'a> {
    scene: &'a Path,
    /// Looked at first.
    materials: Option<&'a Path>,
}

impl LoadedScene {
    /// Reads a scene and all that it names. Materials without an atlas get one.
    ///
    /// # Errors
    /// One line with the scene, the path to the member, and what is wrong with it or with the file that it names.
    pub(crate) fn open(path: &Path, materials: Option<&Path>) -> anyhow::Result<Self> {
        let document = Document::open(path, "a scene")?;
        let folder = path.parent().unwrap_or(Path::new(""));
        let failed = |error: SceneError| Problem::of(path.display(), &error);
        let described = SceneDocument::read(document.bytes()).map_err(failed)?;
        let folders = Folders::new(folder, materials)?;
        let opened: Vec<_> = (described.materials.iter())
            .map(|(name, material)| {
                let member = format!("{}: materials.{name}", path.display());
                Ok((OpenedMaterial::open(material, &folders, &member)?, member))
            })
            .collect::<anyhow::Result<_>>()?;
        let scene = in_pool(|| Scene::load(&described, folder)).map_err(failed)?;
        info!(triangles = scene.triangle_count(), "surfaces");
        let environment = in_pool(|| described.environment(folder, Light::SIZE)).map_err(failed)?;
        let start = Instant::now();
        let lights = in_pool(|| LightSet::new(environment, described.near_lights()));
        let light_bandwidth = start.elapsed();
        // when all files have been read: atlases take their time, and what is wrong should be known before
        let grid: LazyCell<LobeGrid> = LazyCell::new(LobeGrid::default);
        let materials =
            opened.into_iter().map(|(opened, member)| opened.complete(&member, &grid)).collect::<Result<_, _>>()?;
        Ok(Self { scene, lights, light_bandwidth, materials, sha256: document.sha256() })
    }
}

/// The files of a material.
struct OpenedMaterial {
    brdf: Box<dyn Brdf>,
    atlas: Option<Atlas>,
    is_diffuse: bool,
}

impl OpenedMaterial {
    /// Reads the files of a material; `member` names it in messages.
    fn open(document: &SceneMaterial, folders: &Folders<'_>, member: &str) -> anyhow::Result<Self> {
        let within = |error: &anyhow::Error, part: &str| Problem::within(error, &format!("{member}.{part}"));
        let brdf = brdf(&document.source, folders).map_err(|error| within(&error, source_member(&document.source)))?;
        let atlas = document.atlas.as_ref().map(|file| read_atlas(&folders.find(file)));
        let atlas = atlas.transpose().map_err(|problem| within(&problem.into(), "atlas"))?;
        Ok(Self { brdf, atlas, is_diffuse: matches!(document.source, MaterialSource::Lambert(_)) })
    }

    /// The material with its atlas, which is computed where none was named and the material needs one.
    fn complete(self, member: &str, grid: &LazyCell<LobeGrid>) -> Result<LoadedMaterial, Problem> {
        let Self { brdf, atlas, is_diffuse } = self;
        if atlas.is_some() || is_diffuse {
            return Ok(LoadedMaterial { brdf, atlas });
        }
        info!(material = member, "no atlas named; computing one");
        let (channels, options) = (AtlasChannels::Max, LobeOptions::default());
        let grid: &LobeGrid = grid;
        let (atlas, _) = in_pool(|| compute_atlas(brdf.as_ref(), Layout::Isotropic, channels, grid, &options))
            .map_err(|error| Problem::of(member, &error))?;
        Ok(LoadedMaterial { brdf, atlas: Some(atlas.rounded_up()) })
    }
}

/// The member of a material's document that names its BRDF.
fn source_member(source: &MaterialSource) -> &'static str {
    match source {
        MaterialSource::Fit(_) => "source.fit",
        MaterialSource::Measured { .. } => "source.measured.file",
        MaterialSource::Embedded(_) => "source.embedded",
        MaterialSource::Lambert(_) => "source.lambert",
        MaterialSource::Ggx { .. } => "source.ggx",
    }
}

/// The BRDF that a source names.
fn brdf(source: &MaterialSource, folders: &Folders<'_>) -> anyhow::Result<Box<dyn Brdf>> {
    let (input, reading) = match source {
        MaterialSource::Lambert(albedo) => return Ok(Box::new(Lambert { albedo: *albedo })),
        MaterialSource::Ggx { rho_d, rho_s, alpha } => {
            let material = GgxMaterial::without_fresnel(*rho_d, *rho_s, *alpha);
            return Ok(Box::new(material.map_err(|error| Problem::invalid(error.to_string()))?));
        }
        MaterialSource::Embedded(name) => {
            let material = embedded_materials::material(name).ok_or_else(|| {
                let names = embedded_materials::names().collect::<Vec<_>>().join(", ");
                Problem::invalid(format!("no embedded material {name}; choose one of {names}"))
            })?;
            (MaterialInput::Embedded(material), Reading::default())
        }
        MaterialSource::Fit(file) => (MaterialInput::Fit(folders.input(file)?), Reading::default()),
        MaterialSource::Measured { file, sample_position } => {
            let sample_position = sample_position.map(|location| match location {
                SampleLocation::Edge => SamplePosition::Edge,
                SampleLocation::Centre => SamplePosition::Centre,
            });
            (MaterialInput::Measured(folders.input(file)?), Reading { sample_position, ..Reading::default() })
        }
    };
    input.open(reading)?.brdf()
}

impl<'a> Folders<'a> {
    fn new(scene: &'a Path, materials: Option<&'a Path>) -> Result<Self, Problem> {
        match materials {
            Some(folder) if !folder.is_dir() => {
                Err(Problem::input_output(format!("{}: no such folder; check --materials", folder.display())))
            }
            _ => Ok(Self { scene, materials }),
        }
    }

    /// The file of this name: among the materials if it is there, else relative to the scene.
    fn find(&self, file: &str) -> PathBuf {
        let material = self.materials.map(|folder| folder.join(file));
        material.filter(|path| path.exists()).unwrap_or_else(|| self.scene.join(file))
    }

    fn input(&self, file: &str) -> Result<InputFile, Problem> {
        InputFile::new(self.find(file), Wanted::Materials)
    }
}

/// Reads an atlas: OpenEXR by its extension, else KTX2.
fn read_atlas(path: &Path) -> Result<Atlas, Problem> {
    let bytes = fs::read(path).map_err(|error| Problem::reading(path, &error))?;
    let is_exr = path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("exr"));
    let read = if is_exr { exr::from_bytes(&bytes) } else { ktx2::from_bytes(&bytes) };
    read.map(|(atlas, _)| atlas).map_err(|error| Problem::of(path.display(), &error))
}
