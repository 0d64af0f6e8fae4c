//! From the light of a document to the light of the renderer.

use std::path::Path;

use crate::Vec3;
use crate::lights::environment_map::{LatLong, turned_back};
use crate::lights::error::LightError;
use crate::lights::octahedral_light::Light;
use crate::scene::document::LightDocument;
use crate::scene::error::{Field, SceneError};

impl LightDocument {
    /// The light with `n x n` texels; `folder` is what its file name is relative to.
    ///
    /// # Errors
    /// [`SceneError`] for a file that cannot be read or used, and for a size that [`Light`] does not have.
    pub fn light(&self, folder: &Path, n: usize) -> Result<Light, SceneError> {
        let failed =
            |field: &'static str| move |source: LightError| SceneError::Light { field: Field::from(field), source };
        match self {
            Self::Environment { file, rotation, scale } => {
                let map = LatLong::read(&folder.join(file)).map_err(failed("light.environment.file"))?;
                map.to_light(n, rotation.to_radians() as f32, *scale as f32).map_err(failed("light.environment"))
            }
            Self::Procedural { kind, rotation, scale } => {
                let (sin, cos) = (libm::sin(rotation.to_radians()) as f32, libm::cos(rotation.to_radians()) as f32);
                let radiance = |d: Vec3| kind.radiance(turned_back(d, [cos, sin])).map(|value| value * *scale as f32);
                Light::from_fn(n, radiance).map_err(failed("light.procedural"))
            }
        }
    }
}
