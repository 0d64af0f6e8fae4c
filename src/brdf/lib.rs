//! Isotropic BRDFs: directions and half/difference angles, the [`Brdf`] trait, the SGD microfacet model with its distribution,
//! exact and approximate Smith masking and generalised Schlick Fresnel term, and the special function underneath.
//!
//! Conventions: angles in radians, BRDF values in 1/sr, the local normal is +z, f64 for fitting and oracles, f32 for rendering.
//! The equations with their sources are in `docs/theory.md`.
#![forbid(unsafe_code)]

mod batch;
mod brdf;
mod distributions;
mod masking;
mod math;
mod models;

pub use batch::fixed_outgoing::{Directions, Lobes};
pub use batch::half_vector_sampler::{HalfVectorSampler, HalfVectors};
pub use batch::half_vector_table::HalfVectorTable;
pub use batch::shading::Shading;
pub use brdf::{Brdf, Lambert, Symmetry, cosine_sample};
pub use distributions::ggx::Ggx;
pub use distributions::shifted_gamma::ShiftedGamma;
pub use masking::closed_form::G1ClosedForm;
pub use masking::curve::G1Curve;
pub use masking::smith::SmithG1;
pub use math::direction::{Direction, HalfDifference, direction, reflect};
pub use math::gamma::{ln_upper_gamma, upper_gamma};
pub use math::simd::by_eights;
#[cfg(feature = "serde")]
pub use models::document::{MaterialChannel, MaterialDocument, MaterialError};
pub use models::fresnel::Fresnel;
pub use models::ggx_material::GgxBrdf;
pub use models::sgd::{Configuration, ParameterError, Sgd, SgdParameters, directional_albedo};
pub use models::sgd_f32::RenderSgd;
pub use models::sgd_material::SgdMaterial;
