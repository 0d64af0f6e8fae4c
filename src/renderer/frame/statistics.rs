//! Statistics of a frame: times and samples.

use std::time::Duration;

use crate::passes::image_bandwidth::COARSEST_LEVEL;

/// Wall time of each pass.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Times {
    /// Samples of the pilot.
    pub pilot: Duration,
    /// Image-space bandwidth and levels of pixels.
    pub bandwidth: Duration,
    /// Pyramid, grading, leaves, stencils of the up-sampling.
    pub decisions: Duration,
    /// The list and its counts.
    pub list: Duration,
    /// Shading.
    pub shading: Duration,
    /// Up-sampling.
    pub upsampling: Duration,
    /// Times the texture.
    pub resolve: Duration,
}

impl Times {
    /// From the pilot to the up-sampling, which is what is compared.
    pub fn frame(&self) -> Duration {
        self.pilot + self.bandwidth + self.decisions + self.list + self.shading + self.upsampling
    }
}

/// Statistics of a frame.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FrameStatistics {
    /// Wall time of each pass.
    pub times: Times,
    /// Surface pixels.
    pub foreground: u64,
    /// Samples of the pilot.
    pub pilot_samples: u64,
    /// Samples of the shading points.
    pub shading_samples: u64,
    /// Shading points per level.
    pub shaded: [u64; COARSEST_LEVEL + 1],
    /// Number of those whose light was prefiltered.
    pub prefiltered: u64,
}
