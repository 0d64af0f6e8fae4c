//! Special functions, dual numbers, logarithm and exponential, directions, eight lanes at a time.

pub(crate) mod direction;
pub(crate) mod dual;
pub(crate) mod fraction_nodes;
pub(crate) mod gamma;
pub(crate) mod log_exp;
pub(crate) mod simd;
