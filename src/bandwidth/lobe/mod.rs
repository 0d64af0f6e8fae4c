//! Outgoing lobes on the angular map and the map of their bandwidth.

pub(crate) mod estimate;
pub(crate) mod grid;
pub(crate) mod map;
pub(crate) mod mapping;
pub(crate) mod sampled;
pub(crate) mod transform;
pub(crate) mod window_choice;
pub(crate) mod window_filter;
