//! Command-line arguments, not yet validated; the plans in `jobs` and the subcommands validate them.

pub(crate) mod atlas;
pub(crate) mod cli;
pub(crate) mod compare;
pub(crate) mod demo;
pub(crate) mod embedded_materials;
pub(crate) mod fit;
mod headings;
pub(crate) mod measured;
pub(crate) mod ranges;
pub(crate) mod render;
pub(crate) mod texts;
pub(crate) mod value_enums;
