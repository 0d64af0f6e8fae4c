//! Documents and files: names, atomic writing, what an earlier run left, summaries.

pub(crate) mod documents;
pub(crate) mod folder;
pub(crate) mod json;
pub(crate) mod output;
pub(crate) mod shard;
pub(crate) mod summary;
