//! The values of options and what they mean.

use brdfit_bandwidth::exr::Samples;
use brdfit_bandwidth::{AtlasChannels, Layout};
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
    /// Output of `brdfit info --format json`
    Info,
    /// <name>.atlas.json of `brdfit atlas`
    Atlas,
    /// Scene that `brdfit render` reads
    Scene,
    /// Statistics of `brdfit render --stats`
    Render,
}

/// Output format.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum Format {
    /// Human-readable text
    Text,
    /// JSON
    Json,
}

/// Declares the values of an option and what each of them means.
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
        /// Lower edge of the cell
        Edge => SamplePosition::Edge,
        /// Centre of the cell
        Centre => SamplePosition::Centre,
    }
}

words! {
    /// `--loss`
    LossArg => Loss {
        /// Weighted difference of ln(1 + f cos)
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
        /// Measured peak
        Peak => Anchor::Peak,
        /// Peak of the fitted distribution
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
        /// 256 elevations of the incident direction
        Isotropic => Layout::Isotropic,
        /// 16 x 16 incident directions over the hemisphere
        Hemisphere => Layout::Hemisphere,
    }
}

words! {
    /// `--channels`
    ChannelsArg => AtlasChannels {
        /// Maximum over red, green and blue
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
    /// No constraint
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
        /// Adaptive pixels and adaptive sample counts
        Adaptive => Mode::Adaptive,
        /// Adaptive pixels, equal sample counts
        AdaptivePixels => Mode::AdaptivePixels,
        /// Every pixel, adaptive sample counts
        AdaptiveCounts => Mode::AdaptiveCounts,
        /// Every pixel, equal sample counts, no prediction
        Reference => Mode::Reference,
    }
}

words! {
    /// `--geometry`
    GeometryArg => Geometry {
        /// Speed of the mirror direction over the image
        Reflected => Geometry::Reflected,
        /// Published operators (Bagher 2013, figure 4) with a band limit on the whole spectrum
        Operators => Geometry::Operators,
        /// Published operators as printed
        OperatorsLiteral => Geometry::OperatorsPublished,
    }
}

words! {
    /// `--allocation`
    AllocationArg => Allocation {
        /// Variance that the pilot measured
        Variance => Allocation::Variance,
        /// Published bound (Bagher 2013, equation 9)
        Eq9 => Allocation::Published,
        /// Equal for all points
        Even => Allocation::Even,
    }
}

words! {
    /// `--upsample`
    UpsamplingArg => Upsampling {
        /// Weights from tangent planes and normals, Catmull-Rom on smooth surfaces
        EdgeAware => Upsampling::EdgeAware,
        /// Published Gaussian weights (Bagher 2013, section 3.2)
        Paper => Upsampling::Published,
    }
}

/// `--background`
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum BackgroundArg {
    /// Radiance of the light
    Light,
    /// No radiance
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
    /// Mean, variance and bandwidth estimated by the pilot
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
