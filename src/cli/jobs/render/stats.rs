//! The document of `brdfit render --stats`.

use std::time::Duration;

use brdfit_renderer::{FrameStatistics, Times};
use schemars::JsonSchema;
use serde::Serialize;

use crate::jobs::render::options::OptionsEntry;

/// Version of the layout.
const SCHEMA_VERSION: u32 = 1;

/// Statistics of a rendering: options, samples, times, quality. All but the times are reproducible.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
#[schemars(title = "brdfit render statistics")]
pub(crate) struct RenderDocument {
    /// Version of the layout.
    pub(crate) schema_version: u32,
    /// The program and its version.
    pub(crate) program: String,
    /// The scene.
    pub(crate) scene: SceneEntry,
    /// Everything the image depends on.
    pub(crate) options: OptionsEntry,
    /// Columns and rows.
    pub(crate) size: [usize; 2],
    /// Surface pixels.
    pub(crate) foreground: u64,
    /// Samples of one frame.
    pub(crate) samples: SamplesEntry,
    /// Shading points per level: cells of 1, 2, 4, .. 32 pixels along a side.
    pub(crate) shaded_per_level: Vec<u64>,
    /// Shading points whose light was prefiltered.
    pub(crate) prefiltered: u64,
    /// Wall times in milliseconds, medians over the repetitions.
    pub(crate) milliseconds: TimesEntry,
    /// Comparison with the reference, where there is one.
    pub(crate) quality: Option<QualityEntry>,
}

/// The scene.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub(crate) struct SceneEntry {
    /// File name without its folder.
    pub(crate) name: String,
    /// SHA-256 of the file.
    pub(crate) sha256: String,
}

/// Samples.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub(crate) struct SamplesEntry {
    /// Samples of the pilot.
    pub(crate) pilot: u64,
    /// Samples of the shading points.
    pub(crate) shading: u64,
    /// Samples of both per surface pixel.
    pub(crate) per_pixel: f64,
}

/// Wall times in milliseconds.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub(crate) struct TimesEntry {
    /// Surfaces, visibility and differentials.
    pub(crate) gbuffer: f64,
    /// Bandwidth of the light.
    pub(crate) light_bandwidth: f64,
    /// Samples of the pilot.
    pub(crate) pilot: f64,
    /// Image-space bandwidth and levels.
    pub(crate) bandwidth_buffer: f64,
    /// Cells, leaves, parents.
    pub(crate) decisions: f64,
    /// The list of shading points and their counts.
    pub(crate) list: f64,
    /// Shading.
    pub(crate) shading: f64,
    /// Up-sampling.
    pub(crate) upsampling: f64,
    /// Times the texture.
    pub(crate) resolve: f64,
    /// From the pilot to the up-sampling.
    pub(crate) frame: f64,
}

/// Errors relative to the reference, over the surface pixels.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub(crate) struct QualityEntry {
    /// File name of the reference without its folder.
    pub(crate) reference: String,
    /// Exposure factor.
    pub(crate) exposure: f32,
    /// Peak signal to noise ratio of the exposed image under the sRGB curve, decibel; none if it is the same.
    pub(crate) psnr: Option<f64>,
    /// Mean of `(x - y)^2 / (y^2 + 0.01)` of the exposed linear values.
    pub(crate) relmse: f64,
    /// Mean FLIP error, 0 to 1, at 67 pixels per degree.
    pub(crate) flip: f64,
}

impl RenderDocument {
    /// The document without a comparison.
    pub(crate) fn new(
        scene: SceneEntry,
        options: OptionsEntry,
        size: [usize; 2],
        statistics: &FrameStatistics,
        milliseconds: TimesEntry,
    ) -> Self {
        let FrameStatistics { foreground, pilot_samples: pilot, shading_samples: shading, shaded, prefiltered, .. } =
            *statistics;
        let per_pixel = (pilot + shading) as f64 / (foreground.max(1)) as f64;
        Self {
            schema_version: SCHEMA_VERSION,
            program: format!("brdfit {}", env!("CARGO_PKG_VERSION")),
            scene,
            options,
            size,
            foreground,
            samples: SamplesEntry { pilot, shading, per_pixel },
            shaded_per_level: shaded.to_vec(),
            prefiltered,
            milliseconds,
            quality: None,
        }
    }
}

impl TimesEntry {
    /// Medians over the frames, and the times before them.
    pub(crate) fn new(gbuffer: Duration, light_bandwidth: Duration, frames: &[Times]) -> Self {
        let median = |time: fn(&Times) -> Duration| {
            let mut times: Vec<Duration> = frames.iter().map(time).collect();
            times.sort();
            milliseconds(times[times.len() / 2])
        };
        Self {
            gbuffer: milliseconds(gbuffer),
            light_bandwidth: milliseconds(light_bandwidth),
            pilot: median(|times| times.pilot),
            bandwidth_buffer: median(|times| times.bandwidth),
            decisions: median(|times| times.decisions),
            list: median(|times| times.list),
            shading: median(|times| times.shading),
            upsampling: median(|times| times.upsampling),
            resolve: median(|times| times.resolve),
            frame: median(Times::frame),
        }
    }
}

fn milliseconds(time: Duration) -> f64 {
    (time.as_secs_f64() * 1e6).round() / 1e3
}
