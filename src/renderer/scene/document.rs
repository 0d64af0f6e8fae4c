//! The scene document, as written by the user.

use std::collections::BTreeMap;
use std::path::Path;

use schemars::generate::SchemaSettings;
use schemars::{JsonSchema, Schema};
use serde::{Deserialize, Serialize};

use crate::lights::document::LightDocument;
use crate::lights::light_set::NearLight;
use crate::lights::octahedral::light::Light;
use crate::scene::error::{Field, SceneError};

/// A scene: camera, objects, materials and lights. World: right-handed, +z up. Lengths share one unit of any
/// size, angles are in degrees, colours are linear R, G, B with the primaries of sRGB. File names are relative to the folder of
/// the scene.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(title = "brdfit scene")]
#[schemars(extend("oneOf" = [{ "required": ["light"] }, { "required": ["lights"] }]))]
pub struct SceneDocument {
    /// The schema of this document, for editors; not read.
    #[serde(rename = "$schema", default, skip_serializing_if = "Option::is_none")]
    pub schema: Option<String>,
    /// The camera.
    pub camera: CameraDocument,
    /// A single light; exclusive with `lights`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub light: Option<LightDocument>,
    /// The lights, at least one; their radiances add up. At most one of `environment` and `procedural`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(length(min = 1))]
    pub lights: Option<Vec<LightDocument>>,
    /// The materials by name.
    pub materials: BTreeMap<String, SceneMaterial>,
    /// The surfaces.
    pub objects: Vec<ObjectDocument>,
}

/// A pinhole camera.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CameraDocument {
    /// Position of the eye.
    pub eye: [f64; 3],
    /// The point in the centre of the image.
    pub target: [f64; 3],
    /// The direction that points up in the image.
    #[serde(default = "up")]
    pub up: [f64; 3],
    /// Angle between the lower and the upper edge of the image, degrees, 0.01 to 170.
    pub vertical_fov: f64,
    /// Columns, 1 to 16384.
    pub width: usize,
    /// Rows, 1 to 16384.
    pub height: usize,
}

/// A material.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SceneMaterial {
    /// Source of its BRDF.
    pub source: MaterialSource,
    /// Its bandwidth atlas, KTX2 or OpenEXR; computed where absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub atlas: Option<String>,
    /// Factor of the BRDF, varying over the surface; 1 if absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub albedo: Option<AlbedoDocument>,
}

/// Source of a BRDF.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum MaterialSource {
    /// The result of a fit, a JSON file.
    Fit(String),
    /// A measurement.
    Measured {
        /// A file in the MERL format.
        file: String,
        /// Position of a tabulated value within its cell; default: that of the format, `edge` for MERL files.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        #[schemars(with = "SampleLocation")]
        sample_position: Option<SampleLocation>,
    },
    /// An embedded material, by its name.
    Embedded(String),
    /// A diffuse surface of this albedo per channel, 0 to 1.
    Lambert([f64; 3]),
    /// A diffuse part and one GGX lobe.
    Ggx {
        /// Diffuse albedo per channel, at least 0.
        rho_d: [f64; 3],
        /// Specular scale per channel, at least 0.
        rho_s: [f64; 3],
        /// Width of the distribution of normals, 1e-4 to 10; "m" is its old name.
        #[serde(alias = "m")]
        alpha: f64,
    },
}

/// Position of a tabulated value of a measurement within its cell.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum SampleLocation {
    /// At the lower edge of the cell.
    Edge,
    /// At the middle of the cell.
    Centre,
}

/// A factor of the BRDF as a function of texture coordinates.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum AlbedoDocument {
    /// An image, repeated, interpolated bilinearly; its lower left corner is at (0, 0).
    Texture {
        /// PNG with the sRGB curve.
        file: String,
        /// Repetitions per unit of the texture coordinates, above 0.
        #[serde(default = "one")]
        scale: f64,
    },
    /// A chequerboard.
    Checker {
        /// The two colours; the first is at (0, 0).
        colors: [[f64; 3]; 2],
        /// Squares per unit of the texture coordinates, above 0.
        #[serde(default = "eight")]
        scale: f64,
    },
    /// One colour.
    Constant([f64; 3]),
}

/// A surface in the scene. The mesh is scaled, then turned, then moved.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ObjectDocument {
    /// Its shape.
    pub mesh: MeshDocument,
    /// The name of its material.
    pub material: String,
    /// Factor of its size, above 0.
    #[serde(default = "one")]
    pub scale: f64,
    /// Turns about the world's x, then y, then z axis, degrees, counter-clockwise seen against the axis.
    #[serde(default)]
    pub rotate: [f64; 3],
    /// Position of its origin.
    #[serde(default)]
    pub translate: [f64; 3],
}

/// A shape.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum MeshDocument {
    /// A sphere; u is the azimuth over a full turn, v runs from the lower to the upper pole.
    Sphere {
        /// Its radius, above 0.
        #[serde(default = "one")]
        radius: f64,
    },
    /// A ring in the x-y plane; u along it, v around it.
    Torus {
        /// Distance of the middle of the tube from the z axis.
        #[serde(default = "one")]
        radius: f64,
        /// Radius of the tube, above 0 and below the other.
        #[serde(default = "torus_tube")]
        tube: f64,
    },
    /// A tube along a knot that winds around a ring in the x-y plane; u along it, v around it.
    TorusKnot {
        /// Turns about the z axis, 1 to 16.
        #[serde(default = "two")]
        p: u32,
        /// Turns about the ring, 1 to 16; no common divisor with p.
        #[serde(default = "three")]
        q: u32,
        /// Radius of the ring; the middle of the tube is half of it away from the ring.
        #[serde(default = "one")]
        radius: f64,
        /// Radius of the tube, above 0 and below half the other.
        #[serde(default = "knot_tube")]
        tube: f64,
    },
    /// A sphere whose distance from the centre varies smoothly and irregularly: bumpy with a small amplitude and a high frequency, a
    /// blob with a large amplitude and a low frequency. Texture coordinates of the sphere.
    DisplacedSphere {
        /// Mean radius, above 0.
        #[serde(default = "one")]
        radius: f64,
        /// Largest displacement as a part of the radius, 0 to 0.9.
        #[serde(default = "bump_amplitude")]
        amplitude: f64,
        /// Bumps per unit of length on the unit sphere, above 0; that of the finest octave at most 32.
        #[serde(default = "bump_frequency")]
        frequency: f64,
        /// Number of octaves, each of twice the frequency and half the amplitude of the one before; 1 to 8.
        #[serde(default = "one_octave")]
        octaves: u32,
        /// Seed of the irregular shape.
        #[serde(default)]
        seed: u32,
    },
    /// A square in the x-y plane around the origin, its front at +z; u along x and v along y from 0 to 1.
    Plane {
        /// Length of a side, above 0.
        #[serde(default = "two_units")]
        size: f64,
    },
    /// Triangles of a file; its own materials are not used.
    File {
        /// Wavefront OBJ (.obj) or glTF 2.0 (.gltf, .glb).
        path: String,
        /// The axis of the file that points up.
        #[serde(default)]
        up: UpAxis,
    },
}

/// The axis of a file that becomes the world's +z.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum UpAxis {
    /// +y, as glTF prescribes: (x, y, z) becomes (x, -z, y).
    #[default]
    Y,
    /// +z: unchanged.
    Z,
}

fn up() -> [f64; 3] {
    [0.0, 0.0, 1.0]
}

fn one() -> f64 {
    1.0
}

fn two_units() -> f64 {
    2.0
}

fn eight() -> f64 {
    8.0
}

fn torus_tube() -> f64 {
    0.4
}

fn knot_tube() -> f64 {
    0.25
}

fn two() -> u32 {
    2
}

fn three() -> u32 {
    3
}

fn one_octave() -> u32 {
    1
}

fn bump_amplitude() -> f64 {
    0.08
}

fn bump_frequency() -> f64 {
    4.0
}

impl SceneDocument {
    /// The JSON Schema (draft 2020-12) of the document.
    #[must_use]
    pub fn schema() -> Schema {
        SchemaSettings::draft2020_12().into_generator().into_root_schema_for::<Self>()
    }

    /// The lights, in the order of the document.
    pub(crate) fn lights(&self) -> impl Iterator<Item = &LightDocument> {
        self.light.iter().chain(self.lights.iter().flatten())
    }

    /// The lights at a finite distance, in the order of the document, which has been checked.
    #[must_use]
    pub fn near_lights(&self) -> Vec<NearLight> {
        self.lights().filter_map(LightDocument::near).collect()
    }

    /// The light at infinite distance, if there is one, with `n x n` texels; `folder` is what its file name is relative to.
    ///
    /// # Errors
    /// [`SceneError`] for a file that cannot be read or used, and for a size that [`Light`] does not have.
    pub fn environment(&self, folder: &Path, n: usize) -> Result<Option<Light>, SceneError> {
        let root = Field::default();
        let list = root.member("lights");
        let listed = self.lights.iter().flatten().enumerate().map(|(index, light)| (light, list.element(index)));
        let mut described = self.light.iter().map(|light| (light, root.member("light"))).chain(listed);
        described.find_map(|(light, at)| light.distant(folder, n, &at).transpose()).transpose()
    }
}
