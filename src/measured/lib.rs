//! Measured isotropic BRDFs: files of several formats behind one trait, their slices, cells, health, and evaluation.
//!
//! [`open`] recognises the format of a file and checks its container; all else is read on demand. [`Measurement`] provides
//! what a fit, an atlas or a report needs, independent of the format; [`FORMATS`] lists them.
//!
//! ```
//! use brdfit_brdf::direction;
//! use std::path::Path;
//!
//! # let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../data-fixtures/ggx_rgb.bsdf");
//! # let path = path.as_path();
//! let measurement = brdfit_measured::open(path, None)?;
//! let slices = measurement.slices(); // what a fit reads
//! println!("retro-reflection in red: {:?} per steradian", slices.measured_h[0][0]);
//! let brdf = measurement.brdf()?; // what a renderer evaluates
//! let f = brdf.value(&direction(0.5, 0.0), &direction(0.6, 3.0));
//! assert!(f[0] > 0.0);
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
mod rgl;
mod slices;

pub use brdf::MeasuredBrdf;
pub use cells::Cells;
pub use error::{ContainerFault, MeasurementError, Place, Reason, Unreadable, ValueFault};
pub use formats::{FORMATS, extensions, open};
pub use grid::albedo::AlbedoPlan;
pub use grid::cell_measures::{Grid, PANEL_ANGLE, Row, cosine_drop};
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
