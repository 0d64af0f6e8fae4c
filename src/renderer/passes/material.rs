//! Materials: as given by the caller, and as prepared for the passes.

use brdfit_bandwidth::{Atlas, AtlasPlace};
use brdfit_brdf::{BatchBrdf, Brdf, Lambert};

/// The angular bandwidth of a BRDF, cycles per radian.
#[derive(Clone, Copy, Debug)]
pub enum Bandwidth<'a> {
    /// The same for all directions.
    Constant(f32),
    /// By both directions: level 0 of the atlas, nearest, the largest of its colours.
    Atlas(&'a Atlas),
}

/// A BRDF and the bandwidth of its lobes: what a backend makes its tables and evaluators of.
#[derive(Clone, Copy)]
pub struct Material<'a> {
    brdf: &'a dyn Brdf,
    bandwidth: Bandwidth<'a>,
}

impl<'a> Material<'a> {
    /// A BRDF with the bandwidth of its lobes.
    pub fn new(brdf: &'a dyn Brdf, bandwidth: Bandwidth<'a>) -> Self {
        Self { brdf, bandwidth }
    }

    /// A diffuse material, whose lobes are constant: their bandwidth is 0.
    pub fn diffuse(brdf: &'a Lambert) -> Self {
        Self::new(brdf, Bandwidth::Constant(0.0))
    }
}

/// A BRDF made ready for shading, and the bandwidth of its lobes.
pub(crate) struct ShadingMaterial<'a> {
    pub(crate) shading: Box<dyn BatchBrdf + 'a>,
    bandwidth: Bandwidth<'a>,
}

impl<'a> ShadingMaterial<'a> {
    /// Makes the tables of a material.
    pub(crate) fn new(material: &Material<'a>) -> Self {
        Self { shading: material.brdf.batch(), bandwidth: material.bandwidth }
    }

    /// Angular bandwidth of the BRDF for a pair of local directions, cycles per radian.
    pub(crate) fn bandwidth(&self, i: [f32; 3], o: [f32; 3]) -> f32 {
        match self.bandwidth {
            Bandwidth::Constant(bandwidth) => bandwidth,
            Bandwidth::Atlas(atlas) => {
                let texel = atlas.nearest(&AtlasPlace::new(atlas.layout(), i, o), 0);
                // four colours are stored as red, green, blue and their maximum; one as the maximum, 0, 0 and 1
                if atlas.channels().count() == 1 { texel[0] } else { texel[3] }
            }
        }
    }
}
