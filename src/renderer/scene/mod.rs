//! Scenes: the document, its surfaces, and their G-buffer.
//!
//! [`SceneDocument::read`] reads and checks the document, [`Scene::load`] the meshes and textures that it names, [`Scene::gbuffer`]
//! finds what is visible. The light and the BRDFs are the caller's, who finds them in the document.

pub(crate) mod check;
pub(crate) mod document;
pub(crate) mod error;
pub(crate) mod gbuffer;
pub(crate) mod reading;
pub(crate) mod texture;
pub(crate) mod values;

use std::fmt;
use std::path::Path;

pub use crate::lights::document::LightDocument;
pub use document::{
    AlbedoDocument, CameraDocument, MaterialSource, MeshDocument, ObjectDocument, SampleLocation, SceneDocument,
    SceneMaterial, UpAxis,
};
pub use error::{Field, SceneError};

use crate::lights::light_set::LightSet;
use crate::scene::check::check;
use crate::scene::error::FileError;
use crate::scene::texture::{Albedo, Texture};
use crate::scene::values::{LARGEST_NUMBER, extension};
use crate::shapes::camera::Camera;
use crate::shapes::mesh::Mesh;
use crate::shapes::placement::Placement;
use crate::shapes::sphere::DisplacedSphere;
use crate::shapes::visible_surfaces::VisibleSurfaces;
use crate::shapes::{gltf, obj, plane, sphere, torus};

/// Most triangles of a scene: vertices are counted in 32 bits.
const MOST_TRIANGLES: usize = 1 << 30;

/// The surfaces of a scene and the camera that looks at them.
#[derive(Clone)]
pub struct Scene {
    camera: Camera,
    /// All objects, in world space.
    mesh: Mesh,
    /// The material of each triangle.
    triangle_materials: Vec<u16>,
    visibility: VisibleSurfaces,
    /// Those that the camera sees.
    near_lights: LightSet,
    materials: Vec<String>,
    albedo: Vec<Albedo>,
}

impl Scene {
    /// Reads the meshes and textures of `document`, whose file names are relative to `folder`, and prepares the search for what is visible.
    ///
    /// # Errors
    /// [`SceneError`] with the member of the document that names what is wrong: values as [`SceneDocument::read`] refuses them, files
    /// that cannot be read or used.
    pub fn load(document: &SceneDocument, folder: &Path) -> Result<Self, SceneError> {
        check(document)?;
        let root = Field::default();
        let (mut materials, mut albedo) = (Vec::new(), Vec::new());
        for (name, material) in &document.materials {
            let at = root.member("materials").member(name).member("albedo");
            albedo.push(load_albedo(material.albedo.as_ref(), folder, &at)?);
            materials.push(name.clone());
        }
        let (mut mesh, mut triangle_materials) = (Mesh::default(), Vec::new());
        for (index, object) in document.objects.iter().enumerate() {
            let at = root.member("objects").element(index).member("mesh");
            let part = load_mesh(&object.mesh, folder, &at)?;
            if mesh.triangles.len() + part.triangles.len() > MOST_TRIANGLES
                || mesh.positions.len() + part.positions.len() > MOST_TRIANGLES
            {
                return Err(SceneError::document(
                    &at,
                    format!("more than {MOST_TRIANGLES} triangles or vertices up to here"),
                ));
            }
            let material = materials.binary_search(&object.material).expect("the document has been checked") as u16;
            triangle_materials.resize(triangle_materials.len() + part.triangles.len(), material);
            let part = part.placed(&Placement::of_object(object));
            if !part.positions.iter().flat_map(|p| p.iter()).all(|x| x.abs() <= LARGEST_NUMBER as f32) {
                return Err(SceneError::document(
                    &at,
                    format!("has vertices farther than {LARGEST_NUMBER:e} from the origin"),
                ));
            }
            mesh.append(part);
        }
        let visibility = VisibleSurfaces::new(&mesh);
        let near_lights = LightSet::new(None, document.near_lights());
        let camera = Camera::new(&document.camera);
        Ok(Self { camera, mesh, triangle_materials, visibility, near_lights, materials, albedo })
    }

    /// The camera.
    #[must_use]
    pub fn camera(&self) -> &Camera {
        &self.camera
    }

    /// The names of the materials, in the order of their indices in the G-buffer: that of the document's map.
    #[must_use]
    pub fn materials(&self) -> &[String] {
        &self.materials
    }

    /// Number of triangles.
    #[must_use]
    pub fn triangle_count(&self) -> usize {
        self.mesh.triangles.len()
    }
}

impl fmt::Debug for Scene {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let triangles = self.triangle_count();
        f.debug_struct("Scene")
            .field("camera", &self.camera)
            .field("triangles", &triangles)
            .field("materials", &self.materials)
            .finish_non_exhaustive()
    }
}

fn load_albedo(albedo: Option<&AlbedoDocument>, folder: &Path, at: &Field) -> Result<Albedo, SceneError> {
    let single = |color: &[f64; 3]| color.map(|x| x as f32);
    Ok(match albedo {
        None => Albedo::Constant([1.0; 3]),
        Some(AlbedoDocument::Constant(color)) => Albedo::Constant(single(color)),
        Some(AlbedoDocument::Checker { colors, scale }) => {
            Albedo::Checker { colors: [single(&colors[0]), single(&colors[1])], scale: *scale as f32 }
        }
        Some(AlbedoDocument::Texture { file, scale }) => {
            let texture = load_file(folder, file, &at.member("texture").member("file"), Texture::from_png)?;
            Albedo::Texture { texture, scale: *scale as f32 }
        }
    })
}

fn load_mesh(mesh: &MeshDocument, folder: &Path, at: &Field) -> Result<Mesh, SceneError> {
    Ok(match mesh {
        MeshDocument::Sphere { radius } => sphere::sphere(*radius),
        MeshDocument::Torus { radius, tube } => torus::torus(*radius, *tube),
        MeshDocument::TorusKnot { p, q, radius, tube } => torus::torus_knot(*p, *q, *radius, *tube),
        MeshDocument::DisplacedSphere { radius, amplitude, frequency, octaves, seed } => DisplacedSphere {
            radius: *radius,
            amplitude: *amplitude,
            frequency: *frequency,
            octaves: *octaves,
            seed: *seed,
        }
        .mesh(),
        MeshDocument::Plane { size } => plane::plane(*size),
        MeshDocument::File { path, up } => {
            let read = |bytes: &[u8]| match extension(path).as_str() {
                "obj" => obj::read(bytes),
                _ => gltf::read(bytes, folder.join(path).parent().unwrap_or(folder)),
            };
            load_file(folder, path, &at.member("file").member("path"), read)?.placed(&Placement::of_axes(*up))
        }
    })
}

/// The result of `read` for the bytes of `file`, which the member at `field` names.
fn load_file<T>(
    folder: &Path,
    file: &str,
    field: &Field,
    read: impl FnOnce(&[u8]) -> Result<T, FileError>,
) -> Result<T, SceneError> {
    let path = folder.join(file);
    let bytes = std::fs::read(&path).map_err(FileError::from);
    bytes.and_then(|bytes| read(&bytes)).map_err(|error| SceneError::file(field, &path, error))
}
