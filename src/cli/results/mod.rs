//! Result files: names, atomic writing, re-use, summaries.

pub(crate) mod documents;
pub(crate) mod folder;
pub(crate) mod json;
pub(crate) mod output;
pub(crate) mod shard;
pub(crate) mod summary;
