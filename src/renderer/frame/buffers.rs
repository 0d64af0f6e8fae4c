//! The buffers that the passes of a frame fill.

use wide::f32x4;

use crate::passes::allocation::SampleCounts;
use crate::passes::decision::Decisions;
use crate::passes::image_bandwidth::ImageBandwidth;
use crate::passes::pilot::Pilot;
use crate::passes::pyramid::SurfacePyramid;
use crate::passes::shading_list::ShadingList;
use crate::passes::upsampling::CellRadiance;

/// The outputs of the passes, kept from one frame to the next.
#[derive(Clone, Debug, Default)]
pub(crate) struct FrameBuffers {
    /// Predictions of the pilot; none in the reference mode.
    pub(crate) pilot: Pilot,
    /// Image-space bandwidth and levels; none where every pixel is shaded.
    pub(crate) bandwidth: ImageBandwidth,
    /// The surface of each cell.
    pub(crate) pyramid: SurfacePyramid,
    /// State of each cell.
    pub(crate) decisions: Decisions,
    /// The shading points.
    pub(crate) list: ShadingList,
    /// With how many samples.
    pub(crate) counts: SampleCounts,
    /// Radiance of the shading points.
    pub(crate) shaded: Vec<f32x4>,
    /// Radiance of all cells with a texture of 1.
    pub(crate) radiance: CellRadiance,
}

impl FrameBuffers {
    /// Pixels of the last frame; 0 before the first.
    pub(crate) fn pixels(&self) -> usize {
        self.radiance.levels[0].len()
    }

    /// Whether a frame has been rendered.
    pub(crate) fn is_rendered(&self) -> bool {
        self.pixels() > 0
    }

    /// Whether the last frame had a pilot.
    pub(crate) fn is_predicted(&self) -> bool {
        self.is_rendered() && self.pilot.points.of_pixel.len() == self.pixels()
    }

    /// Whether the last frame divided its pixels into cells.
    pub(crate) fn is_divided(&self) -> bool {
        self.is_rendered() && self.bandwidth.level.len() == self.pixels()
    }
}
