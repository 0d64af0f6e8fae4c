//! Images in files, displayed values, differences between images.

pub(crate) mod exposure;
pub(crate) mod false_colour;
pub(crate) mod film;
pub mod flip;
pub(crate) mod layer;
pub(crate) mod metrics;
