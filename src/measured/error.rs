//! Errors of measured files, each with its remedy.

use std::fmt;
use std::io;
use std::path::{Path, PathBuf};

use crate::grid::dimensions::{CHANNEL_NAMES, Dimensions};
use crate::grid::sample_position::SamplePosition;

/// Error of a measured file: the file and the reason. The message is one line, `FILE: fault; remedy`.
#[derive(Debug, thiserror::Error)]
#[error("{}: {reason}", path.display())]
pub struct MeasurementError {
    path: PathBuf,
    reason: Reason,
}

/// Reasons for rejecting a measured file, grouped by remedy.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Reason {
    /// The file could not be read: check the path, the permissions, the disk.
    #[error(transparent)]
    Unreadable(#[from] Unreadable),
    /// The file is not a whole file of its format: fetch it again, or unpack it.
    #[error(transparent)]
    Container(#[from] ContainerFault),
    /// One field of a file that consists of named fields is missing or wrong: fetch it again.
    #[error("field {name}: {fault}")]
    Field {
        /// The field's name.
        name: String,
        /// Fault and remedy.
        fault: String,
    },
    /// The file is whole and of a kind that is not supported: take another file, or convert it.
    #[error("{what}; {advice}")]
    Unsupported {
        /// What it holds.
        what: String,
        /// The remedy.
        advice: &'static str,
    },
    /// The file is whole, and its values are not those of a measurement.
    #[error(transparent)]
    Values(#[from] ValueFault),
    /// The format fixes where its samples lie: leave the option out.
    #[error(
        "{format} files have their samples at the {fixed}, not at the {asked}; omit --sample-position (sample_position)"
    )]
    SamplePosition {
        /// The format's name.
        format: &'static str,
        /// The position of the samples.
        fixed: SamplePosition,
        /// The requested position.
        asked: SamplePosition,
    },
}

/// A file that could not be read.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Unreadable {
    /// There is no such file.
    #[error("no such file; check the path")]
    NotFound,
    /// The file exists, and this user may not read it.
    #[error("permission denied; make the file readable for this user")]
    PermissionDenied,
    /// The path is a folder.
    #[error("is a folder, not a measured file; name the files in it")]
    IsDirectory,
    /// The path is a pipe, a socket or a device.
    #[error("is a pipe or a device, which cannot be mapped into memory; copy it to a regular file first")]
    NotARegularFile,
    /// The operating system failed to read or to map the file.
    #[error("cannot be read ({0}); check the disk and the path")]
    Io(io::Error),
}

/// A file that is not a whole file of its format.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum ContainerFault {
    /// The file has no bytes.
    #[error("the file is empty (0 bytes); fetch it again")]
    Empty,
    /// The file is compressed, or in another container whose first bytes are known.
    #[error("is {format}, not {wanted} file; {advice}")]
    OtherFormat {
        /// What it is, with an article.
        format: &'static str,
        /// The format that it was read as, with an article.
        wanted: &'static str,
        /// The remedy.
        advice: &'static str,
    },
    /// The file ends before its header or its contents do.
    #[error("truncated: {got} of {expected} bytes{}; fetch it again", Needed(*dimensions))]
    Truncated {
        /// Size in bytes that the header, or what it announces, calls for.
        expected: u64,
        /// Size in bytes that was found.
        got: u64,
        /// The dimensions, where the file has a grid and its header was complete.
        dimensions: Option<Dimensions>,
    },
    /// The file has trailing bytes.
    #[error(
        "trailing bytes: {}, {got} instead of {expected} bytes{}; fetch it again, or truncate it",
        got - expected, Needed(*dimensions)
    )]
    TrailingBytes {
        /// Size in bytes that the header calls for.
        expected: u64,
        /// Size in bytes that was found.
        got: u64,
        /// The dimensions of the header, where the file has a grid.
        dimensions: Option<Dimensions>,
    },
    /// The first twelve bytes cannot be three dimensions.
    #[error("implausible dimensions {} x {} x {}: {}", dimensions[0], dimensions[1], dimensions[2], implausible(*swapped))]
    ImplausibleDimensions {
        /// The header, read as little-endian integers.
        dimensions: [i32; 3],
        /// The header read as big-endian integers, where that is plausible.
        swapped: Option<[i32; 3]>,
    },
    /// The dimensions are possible, and are not those of a MERL file.
    #[error(
        "unsupported dimensions {} x {} x {} (theta_h x theta_d x phi_d); resample to 90 x 90 x 180 or 90 x 90 x 360",
        dimensions[0], dimensions[1], dimensions[2]
    )]
    UnsupportedDimensions {
        /// The header.
        dimensions: [i32; 3],
    },
    /// The list of contents cannot be followed.
    #[error("{what}; fetch it again")]
    Header {
        /// The fault.
        what: String,
    },
}

/// Values that no measurement has.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum ValueFault {
    /// No cell is finite and non-negative in all three planes.
    #[error("no valid cells: none has a measurement in all three planes")]
    NoValidCells,
    /// Some values are not numbers.
    #[error("values that are not a number (NaN): {count}, first at {first}; write -1 where there is no measurement")]
    NotANumber {
        /// Count over all planes.
        count: usize,
        /// Position of the first one in the order of the file.
        first: Place,
    },
    /// Some values are infinite.
    #[error("infinite values: {count}, first at {first}; write -1 where there is no measurement")]
    Infinite {
        /// Count over all planes and both signs.
        count: usize,
        /// Position of the first one in the order of the file.
        first: Place,
    },
}

impl MeasurementError {
    /// What is wrong with the file at `path`.
    pub(crate) fn new(path: &Path, reason: impl Into<Reason>) -> Self {
        Self { path: path.to_path_buf(), reason: reason.into() }
    }

    /// The file that the error is about, as it was named.
    #[must_use]
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// The reason.
    #[must_use]
    pub fn reason(&self) -> &Reason {
        &self.reason
    }

    /// Whether the input was read and is wrong, in contrast to input that could not be read.
    #[must_use]
    pub fn is_invalid_input(&self) -> bool {
        !matches!(self.reason, Reason::Unreadable(_))
    }
}

impl From<io::Error> for Unreadable {
    /// Sorts what the operating system said while opening or mapping a file.
    fn from(source: io::Error) -> Self {
        match source.kind() {
            io::ErrorKind::NotFound | io::ErrorKind::NotADirectory => Self::NotFound,
            io::ErrorKind::PermissionDenied => Self::PermissionDenied,
            io::ErrorKind::IsADirectory => Self::IsDirectory,
            _ => Self::Io(source),
        }
    }
}

/// A value of a file: its plane and its cell.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Place {
    /// Index of the colour plane, 0 to 2.
    pub channel: usize,
    /// Bins (theta_h, theta_d, phi_d).
    pub bins: (usize, usize, usize),
}

impl fmt::Display for Place {
    /// The plane, the bins, and the angles of the cell's lower edge in degrees.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (h, d, p) = self.bins;
        let theta_h = Dimensions::HALF_TURN.theta_h_edge(h).to_degrees();
        let channel = CHANNEL_NAMES[self.channel];
        write!(
            f,
            "plane {channel}, theta_h bin {h} ({theta_h:.2} deg), theta_d bin {d} ({d} deg), phi_d bin {p} ({p} deg)"
        )
    }
}

/// What a size in bytes belongs to.
struct Needed(Option<Dimensions>);

impl fmt::Display for Needed {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.0 {
            Some(dimensions) => write!(f, " for three planes of {dimensions}"),
            None => f.write_str(" in the header alone"),
        }
    }
}

/// The advice that goes with implausible dimensions.
fn implausible(swapped: Option<[i32; 3]>) -> String {
    match swapped {
        Some([a, b, c]) => format!("big-endian they would be {a} x {b} x {c}; convert the whole file to little-endian"),
        None => "this is not a MERL binary file; check that it is the right one".to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_the_system_says_is_sorted() {
        for (from, part) in [
            (io::ErrorKind::NotFound, "no such file"),
            (io::ErrorKind::NotADirectory, "no such file"),
            (io::ErrorKind::PermissionDenied, "permission denied"),
            (io::ErrorKind::IsADirectory, "is a folder"),
            (io::ErrorKind::OutOfMemory, "cannot be read"),
        ] {
            let error = MeasurementError::new(Path::new("x.binary"), Unreadable::from(io::Error::from(from)));
            assert!(!error.is_invalid_input());
            assert!(error.to_string().starts_with(&format!("x.binary: {part}")), "{error}");
        }
    }
}
