//! The lights of a scene document, and their construction.

use std::path::Path;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::geometry::vec3::Vec3;
use crate::lights::environment_map::{LatLong, turned_back};
use crate::lights::error::LightError;
use crate::lights::light_set::NearLight;
use crate::lights::octahedral::light::Light;
use crate::lights::procedural::Procedural;
use crate::lights::rectangle::RectangleDocument;
use crate::scene::error::{Field, SceneError};
use crate::scene::values::{file_name, finite, positive};

/// A light.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum LightDocument {
    /// A latitude-longitude image: the upper row is +z, the middle column +x, +y lies left of it.
    Environment {
        /// OpenEXR (.exr) or Radiance (.hdr).
        file: String,
        /// Turn about +z, degrees, counter-clockwise seen from above.
        #[serde(default)]
        rotation: f64,
        /// Factor of the radiance.
        #[serde(default = "one")]
        scale: f64,
    },
    /// A built-in light.
    Procedural {
        /// Name of the built-in light.
        kind: Procedural,
        /// Turn about +z, degrees, counter-clockwise seen from above.
        #[serde(default)]
        rotation: f64,
        /// Factor of the radiance.
        #[serde(default = "one")]
        scale: f64,
    },
    /// A one-sided rectangular light of constant radiance, visible to the camera.
    Rect(RectangleDocument),
}

fn one() -> f64 {
    1.0
}

impl LightDocument {
    /// Checks the values.
    pub(crate) fn check(&self, at: &Field) -> Result<(), SceneError> {
        let (at, rotation, scale) = match self {
            Self::Environment { file, rotation, scale } => {
                let at = at.member("environment");
                file_name(file, &["exr", "hdr"], &at.member("file"))?;
                (at, *rotation, *scale)
            }
            Self::Procedural { rotation, scale, .. } => (at.member("procedural"), *rotation, *scale),
            Self::Rect(rectangle) => return rectangle.check(&at.member("rect")),
        };
        finite(rotation, &at.member("rotation"))?;
        positive(scale, &at.member("scale"))
    }

    /// Whether the light is one at infinite distance, of which a scene has one at most.
    pub(crate) fn is_distant(&self) -> bool {
        self.near().is_none()
    }

    /// A light at a finite distance, which has been checked.
    pub(crate) fn near(&self) -> Option<NearLight> {
        match self {
            Self::Environment { .. } | Self::Procedural { .. } => None,
            Self::Rect(rectangle) => Some(rectangle.light()),
        }
    }

    /// The image of a light at infinite distance with `n x n` texels; `None` for another. `folder` is what its file name is relative to,
    /// `at` the member that describes the light.
    pub(crate) fn distant(&self, folder: &Path, n: usize, at: &Field) -> Result<Option<Light>, SceneError> {
        let failed = |field: Field| move |source: LightError| SceneError::Light { field, source };
        match self {
            Self::Environment { file, rotation, scale } => {
                let at = at.member("environment");
                let map = LatLong::read(&folder.join(file)).map_err(failed(at.member("file")))?;
                map.to_light(n, rotation.to_radians() as f32, *scale as f32).map_err(failed(at)).map(Some)
            }
            Self::Procedural { kind, rotation, scale } => {
                let (sin, cos) = (libm::sin(rotation.to_radians()) as f32, libm::cos(rotation.to_radians()) as f32);
                let radiance = |d: Vec3| kind.radiance(turned_back(d, [cos, sin])).map(|value| value * *scale as f32);
                Light::from_fn(n, radiance).map_err(failed(at.member("procedural"))).map(Some)
            }
            _ => Ok(None),
        }
    }
}
