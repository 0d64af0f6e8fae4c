//! Pictures that accompany results.

pub(crate) mod demo_picture;
pub(crate) mod slices;
