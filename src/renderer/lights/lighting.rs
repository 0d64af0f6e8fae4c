//! The interface of lights.

use std::fmt::Debug;

use crate::geometry::vec3::Vec3;

/// Receivers of light, one per lane, world space.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Receivers<'a> {
    /// World units.
    pub(crate) position: [&'a [f32]; 3],
}

/// Light that arrives at receivers from given directions, one lane each.
#[derive(Debug)]
pub(crate) struct Arriving<'a> {
    /// Linear R, G, B, in the units of the source.
    pub(crate) radiance: [&'a mut [f32]; 3],
    /// The density with which [`Lighting::sample`] draws the direction for the receiver, 1/sr.
    pub(crate) density: &'a mut [f32],
    /// From the receiver to the light, world units; infinite for distant lights and where there is none.
    pub(crate) distance: &'a mut [f32],
}

/// A light as seen by the camera.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Seen {
    /// World units.
    pub(crate) distance: f32,
    /// Linear R, G, B; zero on a side that emits nothing.
    pub(crate) radiance: [f32; 3],
}

/// A light, for many receivers at once: arrays of components in, arrays of components out, all of one length.
///
/// Lights add up: the radiance that arrives from a direction is the sum over all of them, and none hides another from a receiver.
/// All functions are deterministic, and a lane's result does not depend on the lanes beside it.
pub(crate) trait Lighting: Debug + Send + Sync {
    /// Draws a unit direction for each receiver from two numbers in [0, 1). Where nothing can be drawn, as behind the light, it is any
    /// direction in which [`Self::evaluate`] finds no radiance or no density.
    fn sample(&self, receivers: Receivers<'_>, u: [&[f32]; 2], directions: [&mut [f32]; 3]);

    /// Radiance, density and distance for unit directions, whoever drew them. The density integrates to 1 over the directions from
    /// which radiance arrives, or is 0 for a receiver that none reaches.
    fn evaluate(&self, receivers: Receivers<'_>, directions: [&[f32]; 3], arriving: Arriving<'_>);

    /// Local bandwidth of the incident radiance over direction, cycles per radian; infinite at an edge.
    fn bandwidth(&self, receivers: Receivers<'_>, directions: [&[f32]; 3], bandwidth: &mut [f32]);

    /// The same light with averages over cones of directions, where it has them.
    fn prefiltered(&self) -> Option<&dyn PrefilteredLighting> {
        None
    }

    /// The light that a camera ray meets along a unit direction; `None` where it passes.
    fn seen(&self, eye: Vec3, direction: Vec3) -> Option<Seen>;
}

/// Averages of a light over cones of directions.
pub(crate) trait PrefilteredLighting {
    /// Mean radiance over about `footprint` steradians around each unit direction.
    fn evaluate(&self, receivers: Receivers<'_>, directions: [&[f32]; 3], footprint: &[f32], radiance: [&mut [f32]; 3]);
}
