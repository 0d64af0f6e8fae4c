//! The wavelet transform and the local bandwidth that is read from it.

pub(crate) mod daubechies;
pub(crate) mod energy;
pub(crate) mod energy_interpolation;
pub(crate) mod local_bandwidth;
pub(crate) mod pyramid;
pub(crate) mod simd_dispatch;
pub(crate) mod spectrum;
