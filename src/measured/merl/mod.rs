//! The MERL binary container: reading, checking, scanning, writing.

pub(crate) mod file;
pub(crate) mod header;
pub(crate) mod health;
pub(crate) mod measurement;
pub(crate) mod scan;
pub(crate) mod write;
