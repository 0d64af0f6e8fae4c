//! One frame: its input and options, the passes in order, and their buffers as layers.

pub(crate) mod backend;
mod buffers;
pub(crate) mod cpu;
pub(crate) mod error;
pub(crate) mod input;
pub(crate) mod layers;
pub(crate) mod options;
#[cfg(test)]
mod replay;
pub(crate) mod statistics;
