//! The reflectance models, their registry, and the material part of the JSON documents.

pub(crate) mod configuration;
#[cfg(feature = "serde")]
pub(crate) mod document;
pub(crate) mod fresnel;
pub(crate) mod ggx;
pub(crate) mod material_parameters;
pub(crate) mod microfacet;
pub(crate) mod microfacet_material;
pub(crate) mod model;
#[cfg(feature = "serde")]
pub(crate) mod named_values;
pub(crate) mod parameter;
pub(crate) mod registry;
pub(crate) mod sgd;
