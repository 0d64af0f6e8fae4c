//! The interface of measured files of any format.

use std::fmt;
use std::path::{Path, PathBuf};

use brdfit_brdf::Brdf;

use crate::cells::Cells;
use crate::error::MeasurementError;
use crate::grid::dimensions::Dimensions;
use crate::grid::mask::CellMask;
use crate::grid::sample_position::SamplePosition;
use crate::info::Info;
use crate::mapped_file::MappedFile;
use crate::merl::health::HealthChecks;
use crate::slices::Slices;

/// A measured material: an open file of any of [`crate::FORMATS`], or what a program made.
///
/// Opening reads what describes the file; values are read when they are asked for. Slices and cells lie on the grid of
/// [`Measurement::dimensions`] with their samples at `source().sample_position`; [`Measurement::brdf`] is the material as it
/// was measured, without that grid where the format has none.
pub trait Measurement: fmt::Debug + Send + Sync {
    /// The file and how it is read.
    fn source(&self) -> &Source;

    /// The grid of slices and cells.
    fn dimensions(&self) -> Dimensions;

    /// Reads the whole file once: its hash and which cells hold a measurement. Values that are not finite count as missing
    /// where `accept_non_finite`.
    ///
    /// # Errors
    /// [`crate::Reason::Values`] for values that no measurement has, or no measurement at all.
    fn survey(&self, accept_non_finite: bool) -> Result<Survey, MeasurementError>;

    /// The two slices that a fit reads.
    fn slices(&self) -> Slices;

    /// The values of all cells in 1/sr, for errors over the whole grid; `None` where the measurement cannot give them.
    fn cells(&self) -> Option<Cells<'_>>;

    /// The material as a BRDF, defined for every pair of directions above the horizon.
    ///
    /// # Errors
    /// [`crate::Reason::Values`] if no direction above the horizon was measured.
    fn brdf(&self) -> Result<Box<dyn Brdf>, MeasurementError>;

    /// The report on the file. Files with invalid values are described, too.
    fn info(&self, checks: &HealthChecks) -> Described;
}

/// Origin of a measurement.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Source {
    /// The file, as it was named.
    pub path: PathBuf,
    /// [`Format::id`] of its format.
    pub format: &'static str,
    /// Position of a sample of slices and cells within its cell.
    pub sample_position: SamplePosition,
}

/// Result of one pass over a whole file.
#[derive(Clone, Debug)]
pub struct Survey {
    /// SHA-256 of the file in lower-case hexadecimal.
    pub sha256: String,
    /// The cells that hold a measurement in all three planes.
    pub valid: CellMask,
}

impl Survey {
    /// Number of valid cells over the number of cells.
    #[must_use]
    pub fn valid_fraction(&self) -> f64 {
        self.valid.count() as f64 / self.valid.cells() as f64
    }
}

/// The state of a file, and why it is refused where it is.
#[derive(Debug)]
pub struct Described {
    /// The state.
    pub info: Info,
    /// Errors of the values.
    pub fault: Option<MeasurementError>,
}

/// Opens a file as a measurement, with the requested position of its samples.
pub(crate) type Open = fn(MappedFile, Option<SamplePosition>) -> Result<Box<dyn Measurement>, MeasurementError>;

/// A file format of measured BRDFs: one entry of [`crate::FORMATS`].
#[derive(Debug)]
pub struct Format {
    /// Its name in documents, for instance `merl`.
    pub id: &'static str,
    /// Its name in texts, for instance `MERL`.
    pub name: &'static str,
    /// Extensions of its files in folders, without the dot.
    pub extensions: &'static [&'static str],
    /// Whether a file that begins with these bytes (all, or at least 32) is of this format.
    pub(crate) probe: fn(&[u8]) -> bool,
    /// Checks the container and makes the measurement. A position is what the user asked for: a format that fixes its own
    /// refuses another one.
    pub(crate) open: Open,
}

impl Format {
    /// Whether files of this format have the extension of `path`.
    #[must_use]
    pub fn has_extension(&self, path: &Path) -> bool {
        path.extension()
            .and_then(|extension| extension.to_str())
            .is_some_and(|extension| self.extensions.contains(&extension))
    }
}
