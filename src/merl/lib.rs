//! Measured isotropic BRDFs in the MERL binary format: container, index maps, validity, slices, health.
//!
//! A MERL file holds three planes (R, G, B) of 90 x 90 x 180 or 90 x 90 x 360 values over the angles theta_h, theta_d
//! and phi_d. [`MerlFile::open`] maps it into memory and checks the container; nothing else is read until it is asked
//! for. [`MerlFile::slices`] reads the two slices that a fit needs; [`MerlFile::scan`] reads everything once (hash,
//! validity, counts); [`MeasuredBrdf`] is the material that it describes; [`Grid`] and [`AlbedoPlan`] hold the geometry that files of the same shape share.
//!
//! Values are linear BRDF values in 1/sr of unknown primaries: no gamma, no colour management. Angles are in radians.
//!
//! ```
//! use brdfit_merl::{Dimensions, MerlFile, SamplePosition};
//!
//! let grey = MerlFile::from_fn("grey", Dimensions::HALF_TURN, |_, _, _, _| 0.5 / std::f64::consts::PI)?;
//! grey.scan().check(grey.path())?;
//! let slices = grey.slices(SamplePosition::Edge);
//! assert!((slices.measured_h[0][10].unwrap() - 0.159).abs() < 1e-3);
//! # Ok::<(), brdfit_merl::MerlError>(())
//! ```

mod albedo;
mod dimensions;
mod error;
mod file;
mod fill;
mod grid;
mod header;
mod health;
mod mask;
mod measured;
mod position;
mod samples;
mod scan;
mod slices;
mod write;

pub use albedo::AlbedoPlan;
pub use dimensions::{CHANNEL_NAMES, CHANNEL_SCALE, CHANNELS, Dimensions, NotAMerlGrid, cosines};
pub use error::{MerlError, Place};
pub use file::MerlFile;
pub use grid::{Grid, PANEL_ANGLE, Row};
pub use health::{AlbedoHealth, Angles, ChannelHealth, Health, HealthCheck, Region, Regions};
pub use mask::CellMask;
pub use measured::MeasuredBrdf;
pub use position::SamplePosition;
pub use samples::MIN_COSINE;
pub use scan::{ChannelScan, Scan, Tally};
pub use slices::Slices;
pub use write::write_merl;
