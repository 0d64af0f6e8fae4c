//! The interface of distributions of microfacet normals. An implementation yields a complete model,
//! which is evaluated, sampled, fitted and written to documents through [`crate::Microfacet`].

use crate::masking::masking::{Masking, MaskingLanes};
use crate::models::parameter::{Parameter, ParameterError};
use std::f64::consts::{FRAC_PI_2, PI};
use std::fmt::Debug;
use wide::{f32x8, f64x4};

/// An isotropic distribution of normals with `N` shape parameters and Smith's masking function that belongs to it.
///
/// `D(theta_h) = P22(tan^2 theta_h) / (pi cos^4 theta_h)` with `int P22(x) dx = 1` over `x` from 0 to infinity, so that the
/// integral of `D cos theta_h` over the hemisphere is one. The masking function is `G1 = 1 / (1 + Lambda)`, given as
/// `mu Lambda` with `mu = cot theta`, which stays finite up to grazing.
pub trait NormalDistribution<const N: usize>: Copy + Debug + PartialEq + Send + Sync + 'static {
    /// The name of the microfacet model with this distribution, as documents and options write it.
    const MODEL: &'static str;
    /// The same for titles and captions.
    const TITLE: &'static str;
    /// `c` of `f = rho_d / pi + rho_s F D G1 G1 / (c cos theta_i cos theta_o)`.
    const DIVISOR: f64;
    /// The shape parameters, each with the range and the transform of its unknown in the fit.
    const SHAPE: [Parameter; N];
    /// Default starting points of the fit of the distribution: shapes within the ranges.
    const STARTS: &'static [[f64; N]];
    /// Spacing, in the unknowns, of the table from which the search of the fit takes `G1`; `None` where `G1` itself costs less.
    const SEARCH_LATTICE: Option<[f64; N]> = None;
    /// Whether lobes towards fixed directions are evaluated in single precision. A closed form that is cheap does without.
    const SINGLE_PRECISION_LOBES: bool = true;

    /// `G1` made ready for many directions: often [`crate::G1Curve`].
    type Masking: Masking;
    /// `G1` of three channels in single precision: often [`crate::MaskingTable`].
    type MaskingLanes: MaskingLanes;
    /// The lobe in single precision.
    type Lanes: LobeLanes;

    /// The distribution with these shape parameters, in the order of [`Self::SHAPE`].
    ///
    /// # Errors
    /// The first parameter outside of the domain.
    fn from_shape(shape: [f64; N]) -> Result<Self, ParameterError>;

    /// The shape parameters.
    fn shape(&self) -> [f64; N];

    /// `P22` at `x = tan^2 theta_h`.
    fn p22(&self, x: f64) -> f64;

    /// Derivatives of `ln P22` (and of `ln D`) at `x = tan^2 theta_h` with respect to the shape parameters.
    fn ln_slopes(&self, x: f64) -> [f64; N];

    /// `ln (P22(x) / P22(0))` at four `x = tan^2 theta_h`, and its derivatives with respect to the unknowns of the fit
    /// (the transformed parameters, see [`Parameter::transform`]), for a shape that need not be valid.
    fn ln_shape(shape: &[f64; N], x: f64x4) -> (f64x4, [f64x4; N]);

    /// `mu Lambda` at `mu = cot theta > 0`.
    fn mu_lambda(&self, mu: f64) -> f64;

    /// `mu Lambda` and its derivatives with respect to the shape parameters at fixed `mu = cot theta > 0`.
    fn mu_lambda_with_slopes(&self, mu: f64) -> (f64, [f64; N]);

    /// The `x = tan^2 theta_h` below which a share `u` in [0, 1) of the normals lies, by the density `D cos theta_h`.
    fn quantile(&self, u: f64) -> f64;

    /// The least and the largest `tan^2 theta_h` between which half vectors are tabulated to be drawn.
    fn tan_square_range(&self) -> [f64; 2];

    /// Nodes and weights `(x, w)` with `int P22(x) phi(x) dx = sum w phi(x)` for smooth bounded `phi`.
    fn quadrature(&self) -> Vec<(f64, f64)>;

    /// The normalisation `K` of `P22`, for models that publish one.
    fn normalisation(&self) -> Option<f64> {
        None
    }

    /// The masking function, ready for many directions.
    fn masking(&self) -> Self::Masking;

    /// The masking functions of three channels in single precision.
    fn masking_lanes(channels: [&Self::Masking; 3]) -> Self::MaskingLanes;

    /// The lobe in single precision.
    fn lanes(&self) -> Self::Lanes;

    /// `D` in 1/sr at `x = tan^2 theta_h`.
    fn d_at_tan_square(&self, x: f64) -> f64 {
        let secant_square = 1.0 + x;
        self.p22(x) * secant_square * secant_square / PI
    }

    /// `D` in 1/sr at theta_h in radians, with full relative precision for small angles; zero at and below the horizon.
    fn d_at(&self, theta_h: f64) -> f64 {
        if !(0.0..FRAC_PI_2).contains(&theta_h) {
            return 0.0;
        }
        let (tan, cos) = (libm::tan(theta_h), libm::cos(theta_h));
        let square = cos * cos;
        self.p22(tan * tan) / (PI * square * square)
    }

    /// `G1` at theta in radians: 1 at the normal, 0 at and below the horizon.
    fn g1(&self, theta: f64) -> f64 {
        self.g1_from(libm::cos(theta), libm::sin(theta))
    }

    /// `G1` from the cosine and sine of theta.
    fn g1_from(&self, cos_theta: f64, sin_theta: f64) -> f64 {
        if cos_theta <= 0.0 {
            return 0.0;
        }
        if sin_theta <= 0.0 {
            return 1.0;
        }
        cos_theta / (cos_theta + sin_theta * self.mu_lambda(cos_theta / sin_theta))
    }

    /// `G1` at theta in radians and its derivatives with respect to the shape parameters.
    fn g1_with_slopes(&self, theta: f64) -> (f64, [f64; N]) {
        let (sin, cos) = (libm::sin(theta), libm::cos(theta));
        if cos <= 0.0 {
            return (0.0, [0.0; N]);
        }
        if sin <= 0.0 {
            return (1.0, [0.0; N]);
        }
        let (mu_lambda, slopes) = self.mu_lambda_with_slopes(cos / sin);
        let g1 = cos / (cos + sin * mu_lambda);
        let by_mu_lambda = -g1 * sin / (cos + sin * mu_lambda);
        (g1, slopes.map(|slope| by_mu_lambda * slope))
    }
}

/// The lobe of a distribution for eight half vectors in single precision. `rho_s height lobe / c` with the masking is the
/// specular part but for Fresnel's term.
pub trait LobeLanes: Clone + Debug + Send + Sync + 'static {
    /// The largest value that the lobe stands for, in the same unit as `D`.
    fn height(&self) -> f64;

    /// The lobe over its height, up to what [`Self::masked`] multiplies it by; `None` where it is zero for all eight.
    fn lobe(&self, tan_square: f32x8) -> Option<f32x8>;

    /// `scale D / height G1 G1 / (cos theta_i cos theta_o)` from the lobe, the scale and either `G1 / cos theta`.
    #[inline(always)]
    fn masked(&self, lobe: f32x8, scale: f32x8, g1_over_cos: [f32x8; 2], tan_square: f32x8) -> f32x8 {
        let secant = tan_square + 1.0;
        // in this order no product overflows: the last factor is large where the lobe is small
        lobe * scale * g1_over_cos[0] * g1_over_cos[1] * (secant * secant)
    }
}
