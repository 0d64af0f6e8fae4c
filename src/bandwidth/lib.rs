//! Local bandwidth of two-dimensional signals by wavelets, and the bandwidth atlas of a material.
//!
//! The atlas of a BRDF, sampled for a pair of directions:
//!
//! ```
//! use brdfit_bandwidth::{AtlasChannels, AtlasPlace, Layout, LobeGrid, LobeOptions, compute_atlas};
//! use brdfit_brdf::GgxMaterial;
//!
//! let material = GgxMaterial::without_fresnel([0.1; 3], [0.5; 3], 0.2)?;
//! let options = LobeOptions { max_resolution: 256, ..LobeOptions::default() };
//! let grid = LobeGrid::default();
//! let (atlas, _) = compute_atlas(&material, Layout::Isotropic, AtlasChannels::Max, &grid, &options)?;
//! let (to_light, to_eye) = ([0.6, 0.0, 0.8], [-0.6, 0.0, 0.8]);
//! let place = AtlasPlace::new(atlas.layout(), to_light, to_eye);
//! let [cycles_per_radian, ..] = atlas.nearest(&place, 0);
//! assert!((1.0..5.0).contains(&cycles_per_radian));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! The local bandwidth of a signal is the frequency below which 95 % of its local spectrum lies. [`Estimator`] estimates it from the
//! Daubechies wavelet transform ([`Pyramid`]) of any image: environment maps, area lights, textures. [`LobeEstimator`] does so for the
//! outgoing lobes of a material on the angular map ([`AngularMap`]), at the resolution that each needs, and [`compute_atlas`] for
//! all lobes; an [`Atlas`] holds them as the texture that renderers sample. `exr` and `ktx2` write it (feature `files`, on by
//! default), [`sidecar`] describes it, [`shader`] provides the shader functions that sample it.
//!
//! Bandwidths are in cycles per radian, or per sample where no mapping is known. Definitions: docs/theory.md, section 10; measured
//! errors: docs/accuracy.md. Source: Bagher et al. 2013, "Interactive rendering of acquired materials on dynamic geometry using
//! frequency analysis", section 2.3.
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
#[cfg(feature = "files")]
mod files;
mod lobe;
mod wavelet;

pub use atlas::compute::{compute_atlas, incident_direction};
pub use atlas::error::AtlasError;
pub use atlas::f16_round_up::f16_rounded_up;
pub use atlas::sampling::AtlasPlace;
pub use atlas::shader::{ShaderLanguage, shader};
pub use atlas::sidecar;
pub use atlas::texture::{Atlas, AtlasChannels, LARGEST, LEVELS, Layout, Level, SIZE, TILE, TILES, UNITS, level_size};
#[cfg(feature = "files")]
pub use files::{exr, ktx2};
pub use lobe::estimate::{Lobe, LobeEstimator, LobeMemory, LobeOptions};
pub use lobe::grid::{LOBE_TEXELS, LobeGrid};
pub use lobe::mapping::{AngularMap, COS_RIM, direction_to_position, mapping_scale, position_to_direction};
pub use wavelet::daubechies::{Border, HIGH, LOW, Real, analyse, synthesise};
pub use wavelet::local_bandwidth::{Estimator, samples_per_unit};
pub use wavelet::pyramid::{Bands, COARSEST, Pyramid, level_count};
pub use wavelet::spectrum::Rule;
