//! All that a frame is rendered from.

use std::time::{Duration, Instant};

use crate::frame::error::FrameError;
use crate::geometry::differentials::Differentials;
use crate::geometry::gbuffer::{BACKGROUND, GBuffer};
use crate::lights::bandwidth::LightBandwidth;
use crate::lights::octahedral_light::Light;
use crate::passes::material::Material;

/// All that a frame is rendered from, checked, with what follows from it: the differentials of the surfaces and the bandwidth of the
/// light.
#[derive(Clone)]
pub struct FrameInput<'a> {
    gbuffer: GBuffer,
    differentials: Differentials,
    materials: Vec<Material<'a>>,
    light: &'a Light,
    light_bandwidth: LightBandwidth,
    foreground: usize,
    times: PreparationTimes,
}

/// Wall time of what follows from the input.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PreparationTimes {
    /// Differentials of the surfaces.
    pub differentials: Duration,
    /// Bandwidth of the light.
    pub light_bandwidth: Duration,
}

impl<'a> FrameInput<'a> {
    /// The input of these surfaces, the materials that they count, and the light.
    ///
    /// # Errors
    /// [`FrameError::NoMaterial`] if a pixel counts a material that is not there.
    pub fn new(gbuffer: GBuffer, materials: Vec<Material<'a>>, light: &'a Light) -> Result<Self, FrameError> {
        let mut foreground = 0;
        for (pixel, &material) in gbuffer.material.iter().enumerate().filter(|&(_, &index)| index != BACKGROUND) {
            if usize::from(material) >= materials.len() {
                return Err(FrameError::NoMaterial { pixel, material, materials: materials.len() });
            }
            foreground += 1;
        }
        let start = Instant::now();
        let differentials = Differentials::new(&gbuffer);
        let differenced = start.elapsed();
        let light_bandwidth = LightBandwidth::new(light);
        let times = PreparationTimes { differentials: differenced, light_bandwidth: start.elapsed() - differenced };
        Ok(Self { gbuffer, differentials, materials, light, light_bandwidth, foreground, times })
    }

    /// Visible surfaces.
    #[must_use]
    pub fn gbuffer(&self) -> &GBuffer {
        &self.gbuffer
    }

    /// Bandwidth of the light.
    #[must_use]
    pub fn light_bandwidth(&self) -> &LightBandwidth {
        &self.light_bandwidth
    }

    /// What the preparation took.
    #[must_use]
    pub fn times(&self) -> PreparationTimes {
        self.times
    }

    /// How the surfaces change from pixel to pixel.
    pub(crate) fn differentials(&self) -> &Differentials {
        &self.differentials
    }

    /// The materials that the G-buffer counts.
    pub(crate) fn materials(&self) -> &[Material<'a>] {
        &self.materials
    }

    /// The light.
    pub(crate) fn light(&self) -> &'a Light {
        self.light
    }

    /// Pixels that show a surface.
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
        let light = Procedural::Uniform.light(4);
        let chalk = Lambert { albedo: [0.5; 3] };
        let mut gbuffer = sphere(9, 4.0);
        gbuffer.material[4 * 9 + 4] = 1;
        let error = FrameInput::new(gbuffer.clone(), vec![Material::diffuse(&chalk)], &light).err();
        assert_eq!(error, Some(FrameError::NoMaterial { pixel: 40, material: 1, materials: 1 }));
        let two = FrameInput::new(gbuffer, vec![Material::diffuse(&chalk); 2], &light).unwrap();
        assert_eq!(two.foreground(), two.gbuffer().foreground().iter().filter(|&&shown| shown).count());
    }
}
