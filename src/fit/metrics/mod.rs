//! Errors of a fitted model on the cells of a measurement.

pub(crate) mod data_errors;
pub(crate) mod grid_model;
