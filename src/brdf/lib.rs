//! Isotropic BRDFs: microfacet models with Smith's exact masking, their evaluation, gradients and importance sampling.
//!
//! The result of a fit, evaluated and sampled:
//!
//! ```
//! use brdfit_brdf::{MaterialParameters, ModelName, direction};
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! // rho_d, rho_s, alpha, f0, f1 of R, G and B; MaterialParameters::read takes them from a document
//! let channels = [0.4, 0.2, 0.1].map(|rho_d| vec![rho_d, 0.5, 0.2, 0.3, 0.0]);
//! let material = MaterialParameters::new(ModelName::Ggx, channels)?.brdf();
//! let (i, o) = (direction(0.5, 0.0), direction(0.6, 3.0)); // polar angle and azimuth, radians
//! let [red, _, _] = material.value(&i, &o); // in 1/sr
//! if let Some(o) = material.sample(&i, [0.3, 0.7, 0.1]) {
//!     let weight = material.value(&i, &o)[0] * o.z / material.pdf(&i, &o); // averages to the albedo
//!     assert!(weight > 0.0 && red > 0.0);
//! }
//! # Ok(())
//! # }
//! ```
//!
//! Conventions: angles in radians, BRDF values in 1/sr, the local normal is +z, f64 for fitting and oracles, f32 for rendering.
//! The equations with their sources are in `docs/theory.md`.
//!
//! # Known and drawn directions, random numbers
//!
//! All samplers share one contract. One direction is **known**, the other is **drawn**; BRDFs are reciprocal, so it
//! does not matter which of them is called i. [`Brdf::sample`] knows i and draws o; [`BatchBrdf::sample`], made for renderers, knows
//! the direction o towards the eye and draws i. Densities are per solid angle of the drawn direction. A draw that ends at or below
//! the horizon is a sample of value zero and must be counted.
//!
//! Random numbers lie in [0, 1), uniform and independent of each other within a draw. [`Brdf::sample`] takes three: azimuth, radius,
//! choice between the techniques. [`BatchBrdf::sample`] takes two: the first chooses between the techniques and, stretched, serves as the
//! radius, so that stratified numbers stay stratified in each; the second is the azimuth.
//!
//! # Adding a model
//!
//! A microfacet model is a distribution of normals: a file that implements [`NormalDistribution`], and its line among the
//! [`ModelName`]s. [`Model`] is the interface of models for all other code.
#![forbid(unsafe_code)]

mod batch;
mod brdf;
mod distributions;
mod masking;
mod math;
mod models;

pub use batch::batch_brdf::BatchBrdf;
pub use batch::fixed_outgoing::{Directions, FixedOutgoing};
pub use batch::ggx_mixture::GgxMixture;
pub use batch::half_vector_sampler::{HalfVectorSampler, HalfVectors};
pub use batch::half_vector_table::HalfVectorTable;
pub use brdf::{Brdf, Lambert, Symmetry};
pub use distributions::ggx::{Ggx, GgxLanes, GgxMaskingLanes};
pub use distributions::normal_distribution::{LobeLanes, NormalDistribution};
pub use distributions::shifted_gamma::{ShiftedGamma, ShiftedGammaLanes};
pub use masking::closed_form::G1ClosedForm;
pub use masking::curve::G1Curve;
pub use masking::masking::{Masking, MaskingLanes};
pub use masking::table::MaskingTable;
pub use math::direction::{Direction, HalfDifference, cosine_sample, direction, reflect};
pub use math::gamma::{ln_upper_gamma, upper_gamma};
pub use math::simd::by_eights;
pub use models::configuration::Configuration;
#[cfg(feature = "serde")]
pub use models::document::{MaterialError, SCHEMA_VERSION};
pub use models::fresnel::Fresnel;
pub use models::ggx::GgxMaterial;
pub use models::material_parameters::{ChannelError, MaterialParameters};
pub use models::microfacet::{Microfacet, MicrofacetParameters};
pub use models::microfacet_material::MicrofacetMaterial;
pub use models::model::{CellRow, ChannelModel, FourCells, GridModel, Model};
#[cfg(feature = "serde")]
pub use models::named_values::NamedValues;
pub use models::parameter::{Parameter, ParameterError, Transform};
pub use models::registry::{DistributionVisitor, ModelName, UnknownModel};
pub use models::sgd::{Sgd, SgdMaterial, SgdParameters};
pub use {nalgebra, wide};
