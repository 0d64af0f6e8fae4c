//! The rendering of `brdfit demo`: the fitted material on a sphere, beside the map of its shading density.

use std::collections::BTreeMap;
use std::path::PathBuf;

use brdfit_renderer::scene::{
    CameraDocument, LightDocument, MaterialSource, MeshDocument, ObjectDocument, SceneMaterial,
};
use brdfit_renderer::{Budget, Procedural, RenderOptions, SceneDocument};

use crate::args::value_enums::BackgroundArg;
use crate::jobs::batch::in_pool;
use crate::jobs::render::files::{Rendered, write_map};
use crate::jobs::render::frame::RenderedScene;
use crate::jobs::render::scene::LoadedScene;
use crate::results::folder::{ResultFile, ResultFolder};
use crate::results::json;
use crate::results::output;

/// Columns and rows of the picture.
const SIZE: usize = 512;

/// The files of the picture.
#[derive(Debug)]
pub(crate) struct PictureFiles {
    /// The scene, as `brdfit render` takes it.
    pub(crate) scene: PathBuf,
    /// The picture and the map.
    pub(crate) picture: PathBuf,
}

impl PictureFiles {
    /// The files for a material in a folder.
    pub(crate) fn new(folder: &ResultFolder, name: &str) -> Self {
        Self { scene: folder.file(ResultFile::Scene, name), picture: folder.file(ResultFile::Rendering, name) }
    }

    /// Writes the scene and renders it. The fit and the atlas of the material lie beside the scene.
    ///
    /// # Errors
    /// Errors of the operating system; an unusable fit or atlas.
    pub(crate) fn make(&self, name: &str) -> anyhow::Result<()> {
        output::write(&self.scene, &json::to_vec(&scene(name)))?;
        let loaded = LoadedScene::open(&self.scene, None)?;
        let options = RenderOptions { budget: Budget::SamplesPerPixel(16.0), ..RenderOptions::default() };
        let sphere = in_pool(|| RenderedScene::render(&loaded, &options, 1, 1))?;
        let image = sphere.image(BackgroundArg::Light);
        let exposure = sphere.exposure(None);
        let rendered = Rendered { scene: &sphere, image: &image, exposure };
        Ok(write_map(&self.picture, name, &rendered)?)
    }
}

/// A sphere of the material under the built-in sky.
fn scene(name: &str) -> SceneDocument {
    let material = SceneMaterial {
        source: MaterialSource::Fit(ResultFile::Fit.name(name)),
        atlas: Some(ResultFile::AtlasKtx2.name(name)),
        albedo: None,
    };
    SceneDocument {
        schema: None,
        camera: CameraDocument {
            eye: [4.2, 0.0, 0.6],
            target: [0.0; 3],
            up: [0.0, 0.0, 1.0],
            vertical_fov: 31.0,
            width: SIZE,
            height: SIZE,
        },
        light: Some(LightDocument::Procedural { kind: Procedural::Sky, rotation: 0.0, scale: 1.0 }),
        lights: None,
        materials: BTreeMap::from([(name.to_owned(), material)]),
        objects: vec![ObjectDocument {
            mesh: MeshDocument::Sphere { radius: 1.0 },
            material: name.to_owned(),
            scale: 1.0,
            rotate: [0.0; 3],
            translate: [0.0; 3],
        }],
    }
}
