//! The grid of theta_h, theta_d and phi_d: shape, sample positions, cells, measures.

pub(crate) mod albedo;
pub(crate) mod cell_measures;
pub(crate) mod dimensions;
pub(crate) mod fill;
pub(crate) mod mask;
pub(crate) mod sample_position;
pub(crate) mod samples;
