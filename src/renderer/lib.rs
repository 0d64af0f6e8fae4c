//! Adaptive hierarchical shading, driven by predicted bandwidth.
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
