//! The environment: an octahedral image at infinite distance as one of the lights.

use crate::geometry::vec3::Vec3;
use crate::lights::bandwidth::LightBandwidth;
use crate::lights::lighting::{Arriving, Lighting, PrefilteredLighting, Receivers, Seen};
use crate::lights::octahedral::light::Light;

/// Radiance that depends on the direction alone.
#[derive(Clone, Debug)]
pub(crate) struct Environment {
    pub(crate) light: Light,
    pub(crate) bandwidth: LightBandwidth,
}

impl Environment {
    /// The environment of an image; its bandwidth is analysed here.
    pub(crate) fn new(light: Light) -> Self {
        Self { bandwidth: LightBandwidth::new(&light), light }
    }
}

impl Lighting for Environment {
    fn sample(&self, _: Receivers<'_>, u: [&[f32]; 2], directions: [&mut [f32]; 3]) {
        self.light.sample_many(u, directions);
    }

    fn evaluate(&self, _: Receivers<'_>, directions: [&[f32]; 3], arriving: Arriving<'_>) {
        self.light.evaluate_many(directions, arriving.radiance, arriving.density);
        arriving.distance.fill(f32::INFINITY);
    }

    fn bandwidth(&self, _: Receivers<'_>, directions: [&[f32]; 3], bandwidth: &mut [f32]) {
        self.bandwidth.at_many(directions, bandwidth);
    }

    fn prefiltered(&self) -> Option<&dyn PrefilteredLighting> {
        Some(self)
    }

    fn seen(&self, _: Vec3, direction: Vec3) -> Option<Seen> {
        Some(Seen { distance: f32::INFINITY, radiance: self.light.radiance(direction) })
    }
}

impl PrefilteredLighting for Environment {
    fn evaluate(&self, _: Receivers<'_>, directions: [&[f32]; 3], footprint: &[f32], radiance: [&mut [f32]; 3]) {
        self.light.prefiltered_many(directions, footprint, radiance);
    }
}
