//! The reflectance models and the material part of the JSON documents.

#[cfg(feature = "serde")]
pub(crate) mod document;
pub(crate) mod fresnel;
pub(crate) mod ggx_material;
pub(crate) mod sgd;
pub(crate) mod sgd_channel;
pub(crate) mod sgd_f32;
pub(crate) mod sgd_material;
