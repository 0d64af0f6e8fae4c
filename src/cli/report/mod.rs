//! Plots and previews of results.

pub(crate) mod atlas_preview;
pub(crate) mod shading_map;
pub(crate) mod slices;
