//! The resolve pass: radiance times texture, and the background.

use rayon::prelude::*;
use wide::f32x4;

use crate::geometry::gbuffer::{BACKGROUND, GBuffer};
use crate::passes::pass::Pass;

/// Radiance times texture; zeros in the background.
pub(crate) struct ResolvePass<'a> {
    pub(crate) gbuffer: &'a GBuffer,
    /// Radiance of each pixel with a texture of 1.
    pub(crate) radiance: &'a [f32x4],
}

impl Pass for ResolvePass<'_> {
    type Output = Vec<[f32; 3]>;

    fn run(&self, image: &mut Vec<[f32; 3]>) {
        let gbuffer = self.gbuffer;
        let textured = |(pixel, value): (usize, &f32x4)| {
            let [r, g, b, _] = value.to_array();
            let [a, c, d] = gbuffer.albedo[pixel];
            if gbuffer.material[pixel] == BACKGROUND { [0.0; 3] } else { [r * a, g * c, b * d] }
        };
        self.radiance.par_iter().enumerate().with_min_len(4096).map(textured).collect_into_vec(image);
    }
}
