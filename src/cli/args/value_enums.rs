//! The words that options take, and what each of them stands for.

use brdfit_bandwidth::exr::Samples;
use brdfit_bandwidth::{AtlasChannels, Layout, ShaderLanguage};
use brdfit_fit::{Anchor, Constraint, Loss, Step2Solver};
use brdfit_measured::SamplePosition;
use brdfit_renderer::{Allocation, Geometry, Mode, Upsampling};
use clap::ValueEnum;

/// Documents that have a schema.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum SchemaName {
    /// <name>.json of `brdfit fit`
    Fit,
    /// summary.json of `brdfit fit`
    Summary,
    /// What `brdfit info --format json` prints
    Info,
    /// <name>.atlas.json of `brdfit atlas`
    Atlas,
    /// What `brdfit render` reads
    Scene,
    /// What `brdfit render --stats` writes
    Render,
}

/// How data are printed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum Format {
    /// For people
    Text,
    /// For programs
    Json,
}

/// Declares the words of an option and what each of them stands for.
macro_rules! words {
    ($(#[$doc:meta])* $name:ident => $target:ty { $($(#[$help:meta])* $word:ident => $value:path,)* }) => {
        $(#[$doc])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
        pub(crate) enum $name {
            $($(#[$help])* $word,)*
        }

        impl From<$name> for $target {
            fn from(word: $name) -> Self {
                match word {
                    $($name::$word => $value,)*
                }
            }
        }
    };
}

words! {
    /// `--sample-position`
    PositionArg => SamplePosition {
        /// At the lower edge of the cell
        Edge => SamplePosition::Edge,
        /// In the middle of the cell
        Centre => SamplePosition::Centre,
    }
}

words! {
    /// `--loss`
    LossArg => Loss {
        /// Difference of ln(1 + f cos), weighted
        Log1pCos => Loss::Log1pCos,
        /// Difference of sqrt(f cos), independent of the scale of f
        SqrtCos => Loss::SqrtCos,
        /// Plain least squares
        L2 => Loss::L2,
    }
}

words! {
    /// `--anchor`
    AnchorArg => Anchor {
        /// What the measured peak implies
        Peak => Anchor::Peak,
        /// The peak of the fitted distribution
        Distribution => Anchor::Distribution,
    }
}

words! {
    /// `--step2-solver`
    SolverArg => Step2Solver {
        /// Exact, by non-negative least squares
        Convex => Step2Solver::Convex,
        /// Levenberg-Marquardt
        Lm => Step2Solver::LevenbergMarquardt,
    }
}

words! {
    /// `--layout`
    LayoutArg => Layout {
        /// 256 elevations of the light
        Isotropic => Layout::Isotropic,
        /// 16 x 16 directions of the light
        Hemisphere => Layout::Hemisphere,
    }
}

words! {
    /// `--channels`
    ChannelsArg => AtlasChannels {
        /// The maximum over the colours
        Max => AtlasChannels::Max,
        /// Red, green, blue and their maximum
        Rgba => AtlasChannels::Rgba,
    }
}

words! {
    /// `--exr-samples`
    SamplesArg => Samples {
        /// 16 bits, rounded up
        Half => Samples::Half,
        /// 32 bits, as computed
        Float => Samples::Float,
    }
}

words! {
    /// The argument of `export`
    LanguageArg => ShaderLanguage {
        /// For WebGPU
        Wgsl => ShaderLanguage::Wgsl,
        /// For OpenGL, WebGL 2 and Vulkan
        Glsl => ShaderLanguage::Glsl,
    }
}

/// `--formats`
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum ContainerArg {
    /// Texture with mip levels, half precision
    Ktx2,
    /// OpenEXR, one part per level
    Exr,
}

/// `--constraint`: a constraint, or a preset that sets more than it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum ConstraintArg {
    /// 0 <= F <= 1
    Physical,
    /// F >= 0
    NonNegative,
    /// Nothing
    Free,
    /// The published procedure
    Paper,
}

impl ConstraintArg {
    /// The constraint itself.
    pub(crate) fn constraint(self) -> Constraint {
        match self {
            Self::Physical => Constraint::Physical,
            Self::NonNegative => Constraint::NonNegative,
            Self::Free | Self::Paper => Constraint::Free,
        }
    }
}

words! {
    /// `--mode`
    ModeArg => Mode {
        /// Which pixels are shaded and with how many samples
        Adaptive => Mode::Adaptive,
        /// Which pixels are shaded; all with the same number of samples
        AdaptivePixels => Mode::AdaptivePixels,
        /// How many samples; every pixel is shaded
        AdaptiveCounts => Mode::AdaptiveCounts,
        /// None: every pixel with the same number of samples
        Reference => Mode::Reference,
    }
}

words! {
    /// `--geometry`
    GeometryArg => Geometry {
        /// By the speed of the mirror direction over the image
        Reflected => Geometry::Reflected,
        /// By the operators of figure 4 with a band limit that shortens the whole spectrum
        Operators => Geometry::Operators,
        /// By the operators as they are printed
        OperatorsLiteral => Geometry::OperatorsPublished,
    }
}

words! {
    /// `--allocation`
    AllocationArg => Allocation {
        /// By the variance that the pilot measured
        Variance => Allocation::Variance,
        /// By the published bound, equation 9
        Eq9 => Allocation::Published,
        /// The same for every point
        Even => Allocation::Even,
    }
}

words! {
    /// `--upsample`
    UpsamplingArg => Upsampling {
        /// By tangent planes and normals, Catmull-Rom on smooth surfaces
        EdgeAware => Upsampling::EdgeAware,
        /// By the published Gaussians
        Paper => Upsampling::Published,
    }
}

/// `--background`
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum BackgroundArg {
    /// The light
    Light,
    /// Nothing
    Black,
}

/// `--layers`
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum LayerArg {
    /// All of them
    All,
    /// Position, normal, view, albedo, uv, depth, material, curvature
    Gbuffer,
    /// Bandwidth of the light in the mirror direction
    Light,
    /// Mean, variance and bandwidth that the pilot found
    Pilot,
    /// Image-space bandwidth and level
    Bandwidth,
    /// State of the cells of each level
    Decision,
    /// Level and samples of the shading points
    List,
    /// Radiance before the texture
    Upsampled,
}
