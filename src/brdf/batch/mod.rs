//! Many evaluations at once, in single precision: pairs of directions, fixed outgoing directions, draws.

pub(crate) mod batch_brdf;
pub(crate) mod fixed_outgoing;
pub(crate) mod ggx_mixture;
pub(crate) mod half_vector_sampler;
pub(crate) mod half_vector_table;
pub(crate) mod microfacet_batch;
pub(crate) mod microfacet_channel;
pub(crate) mod microfacet_towards;
