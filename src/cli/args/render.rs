//! `brdfit render` as it is typed.

use std::path::PathBuf;

use clap::Args;

use crate::args::headings::OUTPUT;
use crate::args::value_enums::{AllocationArg, BackgroundArg, GeometryArg, LayerArg, ModeArg, UpsamplingArg};

/// Options of `brdfit render`.
#[derive(Debug, Args)]
pub(crate) struct RenderArgs {
    /// A scene: JSON, see `brdfit schema scene` and docs/formats.md
    #[arg(value_name = "SCENE.json")]
    pub(crate) scene: PathBuf,

    /// Folder where files of materials and atlases are looked for before the
    /// scene's own
    #[arg(long, value_name = "DIR")]
    pub(crate) materials: Option<PathBuf>,

    /// The image: radiance as OpenEXR
    #[arg(short, long, value_name = "IMAGE.exr", help_heading = OUTPUT)]
    pub(crate) output: PathBuf,

    /// The image as people see it: exposed, with the sRGB curve
    #[arg(long, value_name = "FILE", help_heading = OUTPUT)]
    pub(crate) png: Option<PathBuf>,

    /// A map of where the image was shaded, beside the image
    #[arg(long, value_name = "FILE", help_heading = OUTPUT)]
    pub(crate) map: Option<PathBuf>,

    /// Times, counts and quality as JSON
    #[arg(long, value_name = "FILE", help_heading = OUTPUT)]
    pub(crate) stats: Option<PathBuf>,

    /// Buffers that the image gets as layers
    #[arg(long, value_name = "LIST", value_delimiter = ',', help_heading = OUTPUT)]
    pub(crate) layers: Vec<LayerArg>,

    /// The light by latitude and longitude as OpenEXR, with a layer of its
    /// bandwidth
    #[arg(long, value_name = "FILE", help_heading = OUTPUT)]
    pub(crate) light_map: Option<PathBuf>,

    /// An image of the same scene to compare with: PSNR, relMSE and FLIP
    #[arg(long, value_name = "IMAGE.exr", help_heading = OUTPUT)]
    pub(crate) reference: Option<PathBuf>,

    /// Factor from radiance to display [default: from the reference or the
    /// image]
    #[arg(long, value_name = "X", help_heading = OUTPUT, allow_negative_numbers = true)]
    pub(crate) exposure: Option<f32>,

    /// What pixels without a surface show
    #[arg(long, value_name = "WHAT", default_value = "light", help_heading = OUTPUT)]
    pub(crate) background: BackgroundArg,

    /// Which parts of the prediction are used
    #[arg(long, value_name = "MODE", default_value = "adaptive", help_heading = SAMPLING)]
    pub(crate) mode: ModeArg,

    /// Samples per pixel of a surface in the mean; the pilot takes about one
    /// more
    #[arg(long, value_name = "N", default_value_t = 16.0, help_heading = SAMPLING, allow_negative_numbers = true)]
    pub(crate) spp: f64,

    /// Instead of a number of samples, the relative error to be reached,
    /// root mean square over the pixels, as far as it can be predicted
    #[arg(long, value_name = "E", conflicts_with = "spp", help_heading = SAMPLING, allow_negative_numbers = true)]
    pub(crate) target_error: Option<f64>,

    /// Seed of all samples; the same seed gives the same image
    #[arg(long, value_name = "N", default_value_t = 0, help_heading = SAMPLING)]
    pub(crate) seed: u32,

    /// Look the light up in its mips where the predicted relative error of a
    /// point exceeds X: less noise, some bias. never, always, or a number
    #[arg(long, value_name = "X", default_value = "never", help_heading = SAMPLING, allow_hyphen_values = true)]
    pub(crate) prefilter: String,

    /// Samples of the pilot per tile of 4 x 4 pixels
    #[arg(long, value_name = "N", default_value_t = 16, help_heading = SAMPLING,
          value_parser = clap::value_parser!(u32).range(4..=4096))]
    pub(crate) pilot_samples: u32,

    /// How samples are distributed
    #[arg(long, value_name = "HOW", default_value = "variance", help_heading = SAMPLING)]
    pub(crate) allocation: AllocationArg,

    /// How bandwidth is carried from the surface to the image
    #[arg(long, value_name = "HOW", default_value = "reflected", help_heading = SAMPLING)]
    pub(crate) geometry: GeometryArg,

    /// Samples per cycle, over two: 1 is the least that can work, 3.1416 the
    /// published rule
    #[arg(long, value_name = "K", default_value_t = 1.0, help_heading = SAMPLING, allow_negative_numbers = true)]
    pub(crate) sampling_rate: f32,

    /// How pixels between the shaded ones are filled
    #[arg(long, value_name = "HOW", default_value = "edge-aware", help_heading = SAMPLING)]
    pub(crate) upsample: UpsamplingArg,

    /// Average N frames with seeds from --seed on; the image gets a layer
    /// with the variance of a frame
    #[arg(long, value_name = "N", default_value_t = 1, help_heading = SAMPLING,
          value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
    pub(crate) frames: u32,

    /// Render each frame N times and report the median times
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
  brdfit render scene.json -o scene.exr --layers all --map where.png
Materials without an atlas get one first, which takes up to a second each; keep
it with `brdfit atlas` and name it in the scene.";
