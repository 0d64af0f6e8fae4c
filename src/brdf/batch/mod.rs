//! Many evaluations at once, in single precision: pairs of directions, fixed outgoing directions, draws.

pub(crate) mod fixed_outgoing;
pub(crate) mod ggx_shading;
pub(crate) mod half_vector_sampler;
pub(crate) mod half_vector_table;
pub(crate) mod sgd_lobes;
pub(crate) mod sgd_shading;
pub(crate) mod shading;
