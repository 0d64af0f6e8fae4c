//! One frame: the passes in order, and their buffers as layers.

pub(crate) mod pass_layers;
pub(crate) mod renderer;
