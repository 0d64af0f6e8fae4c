//! Local bandwidth of two-dimensional signals by wavelets, and the bandwidth atlas of a material.
//!
//! The local bandwidth of a signal is the frequency below which 95 % of its local spectrum lies. [`Estimator`] reads it from the
//! Daubechies wavelet transform ([`Pyramid`]) of any image: environment maps, area lights, textures. [`LobeEstimator`] does so for the
//! outgoing lobes of a material on the angular map ([`AngularMap`]), at the resolution that each needs, and [`compute_atlas`] for
//! all lobes, which an [`Atlas`] holds as the texture that renderers sample. [`exr`], [`ktx2`], [`sidecar`] and [`preview()`] write
//! it, [`shader`] hands out the sampling functions.
//!
//! Bandwidths are in cycles per radian, or per sample where no mapping is known. Definitions: docs/theory.md, section 10; measured
//! errors: docs/accuracy.md. Source: Bagher et al., "Interactive rendering of acquired materials on dynamic geometry using
//! frequency analysis", 2013, section 2.3.
//!
//! ```
//! use brdfit_bandwidth::Estimator;
//!
//! // a grating of 0.1 cycles per sample
//! let image: Vec<f32> = (0..64 * 64).map(|n| (std::f32::consts::TAU * 0.1 * (n % 64) as f32).sin()).collect();
//! let map = Estimator::default().local_bandwidth(&image, 64, 64);
//! assert!((map[32 * 64 + 32] / 0.1).log2().abs() < 0.6);
//! ```
#![forbid(unsafe_code)]

mod atlas;
mod error;
pub mod exr;
mod half_up;
pub mod ktx2;
pub mod sidecar;

mod compute;
mod energy;
mod expand;
mod lobe;
mod lobe_grid;
mod lobe_map;
mod local;
mod mapping;
pub mod preview;
mod pyramid;
mod refine;
mod sampling;
mod shader;
mod spectrum;
mod vectorise;
mod wavelet;
mod window;

pub use atlas::{Atlas, AtlasChannels, LARGEST, LEVELS, Layout, Level, SIZE, TILE, TILES, UNITS, level_size};
pub use compute::{compute_atlas, incident_direction};
pub use error::AtlasError;
pub use half_up::half_up;
pub use lobe::{Lobe, LobeEstimator, LobeMemory, LobeOptions};
pub use lobe_grid::{LOBE_TEXELS, LobeGrid};
pub use local::{Estimator, samples_per_unit};
pub use mapping::{AngularMap, COS_RIM, direction_to_position, mapping_scale, position_to_direction};
pub use preview::{Disc, discs, png_bytes, preview};
pub use pyramid::{Bands, COARSEST, Pyramid, levels};
pub use sampling::AtlasPlace;
pub use shader::{ShaderLanguage, shader};
pub use spectrum::Rule;
pub use wavelet::{Border, HIGH, LOW, Real, analyse, synthesise};
