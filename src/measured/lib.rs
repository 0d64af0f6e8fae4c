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
//! use brdfit_measured::{Dimensions, MerlFile, SamplePosition};
//!
//! let grey = MerlFile::from_fn("grey", Dimensions::HALF_TURN, |_, _, _, _| 0.5 / std::f64::consts::PI)?;
//! grey.scan().check(grey.path())?;
//! let slices = grey.slices(SamplePosition::Edge);
//! assert!((slices.measured_h[0][10].unwrap() - 0.159).abs() < 1e-3);
//! # Ok::<(), brdfit_measured::MerlError>(())
//! ```

mod brdf;
mod error;
mod grid;
mod merl;
mod slices;

pub use brdf::MeasuredBrdf;
pub use error::{MerlError, Place};
pub use grid::albedo::AlbedoPlan;
pub use grid::cell_measures::{Grid, PANEL_ANGLE, Row, cosine_drop};
pub use grid::dimensions::{CHANNEL_NAMES, CHANNEL_SCALE, CHANNELS, Dimensions, NotAMerlGrid, cosines};
pub use grid::mask::CellMask;
pub use grid::sample_position::SamplePosition;
pub use grid::samples::MIN_COSINE;
pub use merl::file::MerlFile;
pub use merl::health::{AlbedoHealth, Angles, ChannelHealth, Health, HealthCheck, Region, Regions};
pub use merl::scan::{ChannelScan, Scan, Tally};
pub use merl::write::write_merl;
pub use slices::Slices;
