//! Measured isotropic BRDFs: files of several formats behind one trait, their slices, cells, health, and the material itself.
//!
//! [`open`] recognises the format of a file and checks its container; nothing else is read until it is asked for. What a fit,
//! an atlas or a report needs is in [`Measurement`], and no user of this crate has to know a format; [`FORMATS`] lists them.
//!
//! ```no_run
//! use std::path::Path;
//!
//! let measurement = brdfit_measured::open(Path::new("gold.binary"), None)?;
//! let slices = measurement.slices(); // what a fit reads
//! let brdf = measurement.brdf()?; // what a renderer evaluates
//! # Ok::<(), brdfit_measured::MeasurementError>(())
//! ```
//!
//! Values are linear BRDF values in 1/sr of unknown primaries: no gamma, no colour management. Angles are in radians.

mod brdf;
mod cells;
mod error;
mod formats;
mod grid;
mod hash;
mod info;
mod mapped_file;
mod measurement;
mod merl;
mod slices;

pub use brdf::MeasuredBrdf;
pub use cells::Cells;
pub use error::{ContainerFault, MeasurementError, Place, Reason, Unreadable, ValueFault};
pub use formats::{FORMATS, extensions, open};
pub use grid::albedo::AlbedoPlan;
pub use grid::cell_measures::{Grid, PANEL_ANGLE, Row};
pub use grid::dimensions::{CHANNEL_NAMES, CHANNEL_SCALE, CHANNELS, Dimensions, NotAMerlGrid, cosines};
pub use grid::mask::CellMask;
pub use grid::sample_position::SamplePosition;
pub use grid::samples::MIN_COSINE;
pub use info::{ChannelRange, Info, Summary, TableShape};
pub use measurement::{Described, Format, Measurement, Source, Survey};
pub use merl::file::MerlFile;
pub use merl::health::{AlbedoHealth, Angles, ChannelHealth, Health, HealthCheck, HealthChecks, Region, Regions};
pub use merl::scan::{ChannelScan, Scan, Tally};
pub use merl::write::write_merl;
pub use slices::Slices;
