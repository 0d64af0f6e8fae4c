//! The passes of a frame: each reads whole buffers and writes others.

pub(crate) mod allocation;
pub(crate) mod decision;
pub(crate) mod direct_lighting;
pub(crate) mod image_bandwidth;
pub(crate) mod material;
pub(crate) mod pass;
pub(crate) mod pilot;
pub(crate) mod pyramid;
pub(crate) mod resolve;
pub(crate) mod shading;
pub(crate) mod shading_list;
pub(crate) mod upsampling;
pub(crate) mod upsampling_stencil;
