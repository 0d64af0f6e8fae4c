//! A material as the passes see it.

use brdfit_bandwidth::{Atlas, AtlasPlace};
use brdfit_brdf::{BatchBrdf, Brdf};

/// A BRDF made ready for shading, and the bandwidth of its lobes.
pub struct Material<'a> {
    pub(crate) shading: Box<dyn BatchBrdf + 'a>,
    atlas: &'a Atlas,
}

impl<'a> Material<'a> {
    /// The material of a BRDF and its atlas.
    pub fn new(brdf: &'a dyn Brdf, atlas: &'a Atlas) -> Self {
        Self { shading: brdf.batch(), atlas }
    }

    /// Angular bandwidth of the BRDF for a pair of local directions, cycles per radian: level 0 of the atlas, nearest, the
    /// largest of its colours.
    pub(crate) fn bandwidth(&self, i: [f32; 3], o: [f32; 3]) -> f32 {
        let texel = self.atlas.nearest(&AtlasPlace::new(self.atlas.layout(), i, o), 0);
        // four colours are stored as red, green, blue and their maximum; one as the maximum, 0, 0 and 1
        if self.atlas.channels().count() == 1 { texel[0] } else { texel[3] }
    }
}
