//! The input of a frame.

use crate::frame::error::FrameError;
use crate::geometry::differentials::Differentials;
use crate::geometry::gbuffer::{BACKGROUND, GBuffer};
use crate::lights::light_set::LightSet;
use crate::passes::material::Material;

/// The validated input of a frame, with the differentials of its surfaces.
#[derive(Clone)]
pub struct FrameInput<'a> {
    gbuffer: GBuffer,
    differentials: Differentials,
    materials: Vec<Material<'a>>,
    lights: LightSet,
    foreground: usize,
}

impl<'a> FrameInput<'a> {
    /// The input of these surfaces, the materials that they count, and the lights.
    ///
    /// # Errors
    /// [`FrameError::NoMaterial`] if a pixel counts a material that is not there.
    pub fn new(gbuffer: GBuffer, materials: Vec<Material<'a>>, lights: LightSet) -> Result<Self, FrameError> {
        let mut foreground = 0;
        for (pixel, &material) in gbuffer.material.iter().enumerate().filter(|&(_, &index)| index != BACKGROUND) {
            if usize::from(material) >= materials.len() {
                return Err(FrameError::NoMaterial { pixel, material, materials: materials.len() });
            }
            foreground += 1;
        }
        let differentials = Differentials::new(&gbuffer);
        Ok(Self { gbuffer, differentials, materials, lights, foreground })
    }

    /// Visible surfaces.
    #[must_use]
    pub fn gbuffer(&self) -> &GBuffer {
        &self.gbuffer
    }

    /// The lights.
    #[must_use]
    pub fn lights(&self) -> &LightSet {
        &self.lights
    }

    /// Screen-space differentials of the surfaces.
    pub(crate) fn differentials(&self) -> &Differentials {
        &self.differentials
    }

    /// The materials that the G-buffer counts.
    pub(crate) fn materials(&self) -> &[Material<'a>] {
        &self.materials
    }

    /// Surface pixels.
    pub(crate) fn foreground(&self) -> usize {
        self.foreground
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use brdfit_brdf::Lambert;

    use crate::lights::procedural::Procedural;
    use crate::test_scenes::sphere;

    #[test]
    fn a_material_that_is_not_there_is_named() {
        let lights = LightSet::from(Procedural::Uniform.light(4));
        let chalk = Lambert { albedo: [0.5; 3] };
        let mut gbuffer = sphere(9, 4.0);
        gbuffer.material[4 * 9 + 4] = 1;
        let error = FrameInput::new(gbuffer.clone(), vec![Material::diffuse(&chalk)], lights.clone()).err();
        assert_eq!(error, Some(FrameError::NoMaterial { pixel: 40, material: 1, materials: 1 }));
        let two = FrameInput::new(gbuffer, vec![Material::diffuse(&chalk); 2], lights).unwrap();
        assert_eq!(two.foreground(), two.gbuffer().foreground().iter().filter(|&&shown| shown).count());
    }
}
