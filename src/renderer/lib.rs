//! Adaptive hierarchical shading, driven by predicted bandwidth.
//!
//! A frame predicts the local bandwidth of the image and the variance of each pixel from the angular bandwidths of lights and
//! materials, shades where the prediction requires it and interpolates the rest (Bagher et al., "Interactive rendering of acquired materials
//! on dynamic geometry using frequency analysis", 2013). Equations and decisions: docs/theory.md, section 11; measured gains:
//! docs/performance.md.
//!
//! [`Scene`] makes a [`GBuffer`] from a [`SceneDocument`]. The G-buffer, its [`Material`]s and a [`LightSet`] (at most one
//! octahedral [`Light`] and any number of near lights) form a [`FrameInput`]. A [`Backend`] renders it and returns the buffers of
//! its passes as [`Layer`]s of a [`Film`].
//!
//! ```
//! use brdfit_brdf::Lambert;
//! use brdfit_renderer::{Backend, Cpu, FrameInput, LightSet, Material, Procedural, RenderOptions, Scene, SceneDocument};
//!
//! let document = SceneDocument::read(br#"{
//!     "camera": {"eye": [4, 0, 0], "target": [0, 0, 0], "vertical_fov": 40, "width": 32, "height": 32},
//!     "light": {"procedural": {"kind": "sky"}},
//!     "materials": {"chalk": {"source": {"lambert": [0.7, 0.7, 0.7]}}},
//!     "objects": [{"mesh": {"sphere": {}}, "material": "chalk"}]
//! }"#)?;
//! let gbuffer = Scene::load(&document, std::path::Path::new("."))?.gbuffer();
//! let (lights, chalk) = (LightSet::from(Procedural::Sky.light(64)), Lambert { albedo: [0.7; 3] });
//! let input = FrameInput::new(gbuffer, vec![Material::diffuse(&chalk)], lights)?;
//! let frame = Cpu.render(&mut Cpu.prepare(input), &RenderOptions::default())?;
//! assert_eq!(frame.radiance.len(), 32 * 32);
//! assert!(frame.statistics.shaded.iter().sum::<u64>() < frame.statistics.foreground);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
#![forbid(unsafe_code)]

#[cfg(test)]
#[path = "tests/checks/chi_square.rs"]
mod chi_square;
mod frame;
mod geometry;
mod images;
mod lights;
mod passes;
pub mod scene;
mod shapes;
#[cfg(test)]
mod test_scenes;

pub use frame::backend::{Backend, Frame};
pub use frame::cpu::{Cpu, CpuFrame};
pub use frame::error::FrameError;
pub use frame::input::FrameInput;
pub use frame::layers::{LayerGroup, finite_or_minus_one};
pub use frame::options::{Mode, OptionsError, RangedOption, RenderOptions};
pub use frame::statistics::{FrameStatistics, Times};
pub use geometry::gbuffer::{BACKGROUND, GBuffer, GBufferError, Surfaces, Viewpoint};
pub use geometry::octahedral;
pub use geometry::sobol;
pub use geometry::vec3::Vec3;
pub use images::exposure::{Exposure, luminance};
pub use images::film::{Film, FilmError, Radiance, shown};
pub use images::flip;
pub use images::layer::Layer;
pub use images::metrics::{psnr, relmse};
pub use lights::bandwidth::LightBandwidth;
pub use lights::environment_map::LatLong;
pub use lights::error::LightError;
pub use lights::light_set::{LightSet, NearLight};
pub use lights::octahedral::light::{LARGEST_RADIANCE, Light};
pub use lights::procedural::Procedural;
pub use passes::allocation::{Allocation, Budget, Prefilter};
pub use passes::image_bandwidth::{COARSEST_LEVEL, Geometry};
pub use passes::material::{Bandwidth, Material};
pub use passes::upsampling_stencil::Upsampling;
pub use scene::{Scene, SceneDocument, SceneError};
pub use shapes::camera::Camera;

/// The crate of [`Vec3`].
pub use nalgebra;
