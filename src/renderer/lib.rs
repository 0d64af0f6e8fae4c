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

mod frame;
mod geometry;
mod images;
mod lights;
mod passes;
pub mod scene;
mod shapes;
#[cfg(test)]
mod test_scenes;

pub use frame::pass_layers::Pass;
pub use frame::renderer::{FrameStatistics, Mode, Prefilter, RenderOptions, Renderer, Times, View};
pub use geometry::differentials::Differentials;
pub use geometry::gbuffer::{BACKGROUND, GBuffer};
pub use geometry::octahedral;
pub use geometry::sobol;
pub use images::exposure::{Exposure, luminance};
pub use images::film::{Film, FilmError, Radiance, shown};
pub use images::flip;
pub use images::metrics::{psnr, relmse};
pub use lights::bandwidth::LightBandwidth;
pub use lights::environment_map::LatLong;
pub use lights::error::LightError;
pub use lights::octahedral_light::{LARGEST_RADIANCE, LUMINANCE, Light};
pub use lights::procedural::Procedural;
pub use passes::allocation::{Allocation, Budget, SAMPLES};
pub use passes::decision::{DecisionLevel, Decisions, State};
pub use passes::image_bandwidth::{BandwidthBuffer, COARSEST_LEVEL, Geometry};
pub use passes::material::Material;
pub use passes::pilot::{LEAST_SAMPLES, Pilot, Prediction, TILE};
pub use passes::pyramid::{Cell, Cells, Extent};
pub use passes::shading::{ShadingList, ShadingPoint};
pub use passes::transport;
pub use passes::upsampling::Values;
pub use passes::upsampling_stencil::Upsampling;
pub use scene::{Scene, SceneDocument, SceneError};
pub use shapes::camera::Camera;

/// Points and directions of the world, single precision.
pub type Vec3 = nalgebra::Vector3<f32>;
