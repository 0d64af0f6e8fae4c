//! Documents and files: naming, atomic writing, resuming, summaries.

pub(crate) mod documents;
pub(crate) mod json;
pub(crate) mod output;
pub(crate) mod resume;
pub(crate) mod summary;
