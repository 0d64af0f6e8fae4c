//! Distributions of microfacet normals.

pub(crate) mod ggx;
pub(crate) mod normal_distribution;
pub(crate) mod shifted_gamma;
