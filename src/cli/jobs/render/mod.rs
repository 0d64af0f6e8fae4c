//! The job of `brdfit render`: checked plan, scene, frame, files, statistics.

pub(crate) mod files;
pub(crate) mod frame;
pub(crate) mod options;
pub(crate) mod plan;
pub(crate) mod scene;
pub(crate) mod stats;
