//! The two steps of the fit and their parts.

pub(crate) mod channel_report;
pub(crate) mod closed_form_fit;
pub(crate) mod distribution_fit;
pub(crate) mod distribution_problem;
pub(crate) mod fresnel_constraints;
pub(crate) mod fresnel_fit;
pub(crate) mod masking_table;
pub(crate) mod nnls;
pub(crate) mod slice_rows;
pub(crate) mod two_step;
