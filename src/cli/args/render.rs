//! Command-line arguments of `brdfit render`.

use std::path::PathBuf;

use clap::Args;

use crate::args::headings::OUTPUT;
use crate::args::value_enums::{AllocationArg, BackgroundArg, GeometryArg, LayerArg, ModeArg, UpsamplingArg};

/// Options of `brdfit render`.
#[derive(Debug, Args)]
pub(crate) struct RenderArgs {
    /// Scene: JSON, see `brdfit schema scene` and docs/formats.md
    #[arg(value_name = "SCENE.json")]
    pub(crate) scene: PathBuf,

    /// Folder that is searched for materials and atlases before the scene's
    /// own
    #[arg(long, value_name = "DIR")]
    pub(crate) materials: Option<PathBuf>,

    /// Image: radiance as OpenEXR
    #[arg(short, long, value_name = "IMAGE.exr", help_heading = OUTPUT)]
    pub(crate) output: PathBuf,

    /// Image for display: exposed, sRGB-encoded PNG
    #[arg(long, value_name = "FILE", help_heading = OUTPUT)]
    pub(crate) png: Option<PathBuf>,

    /// False-colour map of the shading density, beside the image, as PNG
    #[arg(long, value_name = "FILE", help_heading = OUTPUT)]
    pub(crate) map: Option<PathBuf>,

    /// Statistics as JSON: times, samples, quality
    #[arg(long, value_name = "FILE", help_heading = OUTPUT)]
    pub(crate) stats: Option<PathBuf>,

    /// Buffers to store as layers of the image
    #[arg(long, value_name = "LIST", value_delimiter = ',', help_heading = OUTPUT)]
    pub(crate) layers: Vec<LayerArg>,

    /// Light as a latitude-longitude OpenEXR map, with its bandwidth as a
    /// layer
    #[arg(long, value_name = "FILE", help_heading = OUTPUT)]
    pub(crate) light_map: Option<PathBuf>,

    /// Reference image of the same scene, for PSNR, relMSE and FLIP
    #[arg(long, value_name = "IMAGE.exr", help_heading = OUTPUT)]
    pub(crate) reference: Option<PathBuf>,

    /// Exposure factor [default: from the reference or the image]
    #[arg(long, value_name = "X", help_heading = OUTPUT, allow_negative_numbers = true)]
    pub(crate) exposure: Option<f32>,

    /// Background of pixels without a surface
    #[arg(long, value_name = "WHAT", default_value = "light", help_heading = OUTPUT)]
    pub(crate) background: BackgroundArg,

    /// Rendering mode
    #[arg(long, value_name = "MODE", default_value = "adaptive", help_heading = SAMPLING)]
    pub(crate) mode: ModeArg,

    /// Mean number of samples per surface pixel; the pilot adds about one
    #[arg(long, value_name = "N", default_value_t = 16.0, help_heading = SAMPLING, allow_negative_numbers = true)]
    pub(crate) spp: f64,

    /// Target relative error (predicted, root mean square over the pixels)
    /// instead of a number of samples
    #[arg(long, value_name = "E", conflicts_with = "spp", help_heading = SAMPLING, allow_negative_numbers = true)]
    pub(crate) target_error: Option<f64>,

    /// Random seed; the same seed gives the same image
    #[arg(long, value_name = "N", default_value_t = 0, help_heading = SAMPLING)]
    pub(crate) seed: u32,

    /// Prefilter the light where the predicted relative error of a point
    /// exceeds X (less noise, some bias): never, always, or a number
    #[arg(long, value_name = "X", default_value = "never", help_heading = SAMPLING, allow_hyphen_values = true)]
    pub(crate) prefilter: String,

    /// Pilot samples per tile of 4 x 4 pixels
    #[arg(long, value_name = "N", default_value_t = 16, help_heading = SAMPLING,
          value_parser = clap::value_parser!(u32).range(4..=4096))]
    pub(crate) pilot_samples: u32,

    /// Sample allocation
    #[arg(long, value_name = "HOW", default_value = "variance", help_heading = SAMPLING)]
    pub(crate) allocation: AllocationArg,

    /// Transport of bandwidth from the surface to the image
    #[arg(long, value_name = "HOW", default_value = "reflected", help_heading = SAMPLING)]
    pub(crate) geometry: GeometryArg,

    /// Sampling rate in units of the Nyquist rate (2 samples per cycle);
    /// 3.1416 is the published rule
    #[arg(long, value_name = "K", default_value_t = 1.0, help_heading = SAMPLING, allow_negative_numbers = true)]
    pub(crate) sampling_rate: f32,

    /// Filter that fills the pixels between the shaded ones
    #[arg(long, value_name = "HOW", default_value = "edge-aware", help_heading = SAMPLING)]
    pub(crate) upsample: UpsamplingArg,

    /// Average N frames with consecutive seeds from --seed; adds a layer with
    /// the variance of one frame
    #[arg(long, value_name = "N", default_value_t = 1, help_heading = SAMPLING,
          value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
    pub(crate) frames: u32,

    /// Render each frame N times and report median times
    #[arg(long, value_name = "N", default_value_t = 1, help_heading = SAMPLING,
          value_parser = clap::value_parser!(u16).range(1..=1000))]
    pub(crate) repeat: u16,
}

const SAMPLING: &str = "Sampling";

pub(super) const EXAMPLES: &str = "\
Examples:
  brdfit render scene.json -o scene.exr --png scene.png
  brdfit render scene.json -o reference.exr --mode reference --spp 1024 --seed 1
  brdfit render scene.json -o scene.exr --reference reference.exr --stats s.json
  brdfit render scene.json -o scene.exr --layers all --map map.png
For a material without an atlas, one is computed first, in up to a second; to
keep it, use `brdfit atlas` and name the atlas in the scene.";
