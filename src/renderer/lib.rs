//! Adaptive hierarchical shading, driven by predicted bandwidth.
//!
//! A frame predicts from the angular bandwidths of light and materials how fast its image varies and how noisy each pixel's
//! integral is, shades where that asks for it and interpolates the rest (Bagher et al., "Interactive rendering of acquired materials
//! on dynamic geometry using frequency analysis", 2013). Equations and decisions: docs/theory.md, section 11; measured gains:
//! docs/performance.md.
//!
//! [`Scene`] makes a [`GBuffer`] from a [`SceneDocument`]; a [`Light`] is an octahedral image with its [`LightBandwidth`]; a [`Material`] is
//! a [`brdfit_brdf::Brdf`] with its [`brdfit_bandwidth::Atlas`]. [`Renderer::render`] runs the passes over a [`View`] of these and keeps
//! their buffers, which [`Renderer::add_to`] turns into layers of a [`Film`].
//!
//! ```
//! use brdfit_bandwidth::{Atlas, AtlasChannels, Layout, SIZE};
//! use brdfit_brdf::Lambert;
//! use brdfit_renderer::{
//!     Differentials, LightBandwidth, Material, Procedural, RenderOptions, Renderer, Scene, SceneDocument, View,
//! };
//!
//! let document = SceneDocument::read(br#"{
//!     "camera": {"eye": [4, 0, 0], "target": [0, 0, 0], "vertical_fov": 40, "width": 32, "height": 32},
//!     "light": {"procedural": {"kind": "sky"}},
//!     "materials": {"chalk": {"source": {"lambert": [0.7, 0.7, 0.7]}}},
//!     "objects": [{"mesh": {"sphere": {}}, "material": "chalk"}]
//! }"#)?;
//! let gbuffer = Scene::load(&document, std::path::Path::new("."))?.gbuffer();
//! let mut differentials = Differentials::default();
//! differentials.compute(&gbuffer);
//! let light = Procedural::Sky.light(64);
//! let light_bandwidth = LightBandwidth::new(&light);
//! // a diffuse material has no bandwidth of its own
//! let atlas = Atlas::from_level0(Layout::Isotropic, AtlasChannels::Max, vec![0.0; SIZE * SIZE])?;
//! let chalk = Lambert { albedo: [0.7; 3] };
//! let materials = [Material::new(&chalk, &atlas)];
//! let view = View {
//!     gbuffer: &gbuffer,
//!     differentials: &differentials,
//!     materials: &materials,
//!     light: &light,
//!     light_bandwidth: &light_bandwidth,
//! };
//! let (image, statistics) = Renderer::default().render(&view, &RenderOptions::default());
//! assert_eq!(image.len(), 32 * 32);
//! assert!(statistics.shaded.iter().sum::<u64>() < statistics.foreground);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
#![forbid(unsafe_code)]

mod alias;
mod allocation;
mod bandwidth_buffer;
mod cells;
mod decision;
mod differentials;
mod environment;
mod exposure;
mod film;
pub mod flip;
mod gather;
mod gbuffer;
mod interpolation;
mod layers;
mod light;
mod light_bandwidth;
mod light_batch;
mod light_error;
mod light_level;
mod maps;
mod material;
mod metrics;
pub mod octahedral;
mod parents;
mod pass_layers;
mod pilot;
pub mod points;
mod procedural;
mod renderer;
pub mod scene;
mod shading_list;
#[cfg(test)]
mod test_scenes;
pub mod transport;

pub use allocation::{Allocation, Budget, SAMPLES};
pub use bandwidth_buffer::{BandwidthBuffer, COARSEST_LEVEL, Geometry};
pub use cells::{Cell, Cells, Extent};
pub use decision::{DecisionLevel, Decisions, State};
pub use differentials::Differentials;
pub use environment::LatLong;
pub use exposure::{Exposure, luminance};
pub use film::{Film, FilmError, Radiance, shown, to_png};
pub use gbuffer::{BACKGROUND, GBuffer};
pub use interpolation::Values;
pub use light::{LARGEST_RADIANCE, LUMINANCE, Light};
pub use light_bandwidth::LightBandwidth;
pub use light_error::LightError;
pub use maps::{Panel, side_by_side};
pub use material::Material;
pub use metrics::{psnr, relmse};
pub use parents::Upsampling;
pub use pass_layers::Pass;
pub use pilot::{LEAST_SAMPLES, Pilot, Prediction, TILE};
pub use procedural::Procedural;
pub use renderer::{FrameStatistics, Mode, Prefilter, RenderOptions, Renderer, Times, View};
pub use scene::{Scene, SceneDocument, SceneError};
pub use shading_list::{ShadingList, ShadingPoint};

/// Points and directions of the world, single precision.
pub type Vec3 = nalgebra::Vector3<f32>;
