//! The subcommands, one file each.

pub(crate) mod atlas;
pub(crate) mod compare;
pub(crate) mod completions;
pub(crate) mod demo;
pub(crate) mod export;
pub(crate) mod fit;
pub(crate) mod info;
pub(crate) mod man;
pub(crate) mod merge;
pub(crate) mod render;
pub(crate) mod schema;
pub(crate) mod synth;
