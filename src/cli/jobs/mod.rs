//! Validated plans and the work on one input.

pub(crate) mod atlas_job;
pub(crate) mod atlas_plan;
pub(crate) mod batch;
pub(crate) mod demo_picture;
pub(crate) mod fit_job;
pub(crate) mod fit_plan;
pub(crate) mod inputs;
pub(crate) mod material_source;
pub(crate) mod render;
pub(crate) mod synthetic_noise;
