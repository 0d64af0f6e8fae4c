//! Isotropic BRDFs: directions and half/difference angles, the [`Brdf`] trait, the SGD microfacet model with its distribution,
//! exact and approximate Smith masking and generalised Schlick Fresnel term, and the special function underneath.
//!
//! Conventions: angles in radians, BRDF values in 1/sr, the local normal is +z, f64 for fitting and oracles, f32 for rendering.
//! The equations with their sources are in `docs/theory.md`.
#![forbid(unsafe_code)]

mod brdf;
mod direction;
mod dual;
mod fresnel;
mod g1_closed_form;
mod g1_curve;
mod gamma;
mod ggx;
mod ggx_brdf;
mod ggx_shading;
mod half_vector_sampler;
mod half_vector_table;
mod lanes;
mod lobes;
mod log_exp;
mod masking_table;
mod material;
#[cfg(feature = "serde")]
mod material_document;
mod render;
mod sgd;
mod sgd_channel;
mod sgd_lobes;
mod sgd_shading;
mod shading;
mod shifted_gamma;
mod smith;

pub use brdf::{Brdf, Lambert, cosine_sample};
pub use direction::{Direction, HalfDifference, direction, reflect};
pub use fresnel::Fresnel;
pub use g1_closed_form::G1ClosedForm;
pub use g1_curve::G1Curve;
pub use gamma::{ln_upper_gamma, upper_gamma};
pub use ggx::Ggx;
pub use ggx_brdf::GgxBrdf;
pub use half_vector_sampler::{HalfVectorSampler, HalfVectors};
pub use half_vector_table::HalfVectorTable;
pub use lanes::by_eights;
pub use lobes::{Directions, Lobes};
pub use material::SgdMaterial;
#[cfg(feature = "serde")]
pub use material_document::{MaterialChannel, MaterialDocument, MaterialError};
pub use render::RenderSgd;
pub use sgd::{Configuration, ParameterError, Sgd, SgdParameters, directional_albedo};
pub use shading::Shading;
pub use shifted_gamma::ShiftedGamma;
pub use smith::SmithG1;
