//! Everything that can be wrong with a MERL file, each with what to do about it.

use std::fmt;
use std::io;
use std::path::{Path, PathBuf};

use crate::grid::dimensions::{CHANNEL_NAMES, Dimensions};

/// Why a file could not be used. Each message is one line that names the file, what is wrong and what to do.
///
/// The first five say that the input could not be read at all; the others say that what was read is not a usable MERL
/// file ([`MerlError::is_invalid_input`]).
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum MerlError {
    /// There is no such file.
    #[error("{}: no such file; check the path", path.display())]
    NotFound {
        /// The file as it was named.
        path: PathBuf,
    },
    /// The file exists, and this user may not read it.
    #[error("{}: permission denied; make the file readable for this user", path.display())]
    PermissionDenied {
        /// The file as it was named.
        path: PathBuf,
    },
    /// The path is a folder.
    #[error("{}: is a folder, not a MERL file; name the .binary files in it", path.display())]
    IsDirectory {
        /// The folder as it was named.
        path: PathBuf,
    },
    /// The path is a pipe, a socket or a device.
    #[error("{}: is a pipe or a device, which cannot be mapped into memory; copy it to a regular file first", path.display())]
    NotARegularFile {
        /// The path as it was named.
        path: PathBuf,
    },
    /// The operating system failed to read or to map the file.
    #[error("{}: cannot be read ({source}); check the disk and the path", path.display())]
    Io {
        /// The file as it was named.
        path: PathBuf,
        /// What the operating system said.
        source: io::Error,
    },
    /// The file has no bytes.
    #[error("{}: the file is empty (0 bytes); fetch it again", path.display())]
    Empty {
        /// The file as it was named.
        path: PathBuf,
    },
    /// The file is compressed, or in another container whose first bytes are known.
    #[error("{}: is {format}, not a MERL file; {advice}", path.display())]
    OtherFormat {
        /// The file as it was named.
        path: PathBuf,
        /// What it is, with an article.
        format: &'static str,
        /// What to do.
        advice: &'static str,
    },
    /// The file ends before its header or its three planes do.
    #[error("{}: truncated: {got} of {expected} bytes{}; fetch it again", path.display(), Needed(*dimensions))]
    Truncated {
        /// The file as it was named.
        path: PathBuf,
        /// Size in bytes that the header, or the header's dimensions, call for.
        expected: u64,
        /// Size in bytes that was found.
        got: u64,
        /// The dimensions, where the header was complete.
        dimensions: Option<Dimensions>,
    },
    /// The file goes on after its three planes.
    #[error(
        "{}: trailing bytes: {}, {got} instead of {expected} bytes{}; fetch it again, or cut what was appended",
        path.display(), got - expected, Needed(Some(*dimensions))
    )]
    TrailingBytes {
        /// The file as it was named.
        path: PathBuf,
        /// Size in bytes that the dimensions call for.
        expected: u64,
        /// Size in bytes that was found.
        got: u64,
        /// The dimensions of the header.
        dimensions: Dimensions,
    },
    /// The first twelve bytes cannot be three dimensions.
    #[error(
        "{}: implausible dimensions {} x {} x {}: {}",
        path.display(), dimensions[0], dimensions[1], dimensions[2], implausible(*swapped)
    )]
    ImplausibleDimensions {
        /// The file as it was named.
        path: PathBuf,
        /// The header, read as little-endian integers.
        dimensions: [i32; 3],
        /// The header read as big-endian integers, where that is plausible.
        swapped: Option<[i32; 3]>,
    },
    /// The dimensions are possible, and are not those of a MERL file.
    #[error(
        "{}: unsupported dimensions {} x {} x {} (theta_h x theta_d x phi_d); resample to 90 x 90 x 180 or 90 x 90 x 360",
        path.display(), dimensions[0], dimensions[1], dimensions[2]
    )]
    UnsupportedDimensions {
        /// The file as it was named.
        path: PathBuf,
        /// The header.
        dimensions: [i32; 3],
    },
    /// No cell is finite and non-negative in all three planes.
    #[error("{}: no valid cells: no cell holds a measurement in all three planes; the file cannot be used", path.display())]
    NoValidCells {
        /// The file as it was named.
        path: PathBuf,
    },
    /// Some values are not numbers.
    #[error("{}: values that are not a number (NaN): {count}, first at {first}; write -1 where there is no measurement", path.display())]
    NotANumber {
        /// The file as it was named.
        path: PathBuf,
        /// How many, over all planes.
        count: usize,
        /// Where the first one in the order of the file is.
        first: Place,
    },
    /// Some values are infinite.
    #[error("{}: infinite values: {count}, first at {first}; write -1 where there is no measurement", path.display())]
    Infinite {
        /// The file as it was named.
        path: PathBuf,
        /// How many, over all planes and of either sign.
        count: usize,
        /// Where the first one in the order of the file is.
        first: Place,
    },
}

impl MerlError {
    /// Whether the input was read and is wrong, in contrast to input that could not be read.
    #[must_use]
    pub fn is_invalid_input(&self) -> bool {
        !matches!(
            self,
            Self::NotFound { .. }
                | Self::PermissionDenied { .. }
                | Self::IsDirectory { .. }
                | Self::NotARegularFile { .. }
                | Self::Io { .. }
        )
    }

    /// A short stable name of the variant for reports, for instance `truncated`.
    #[must_use]
    pub fn kind(&self) -> &'static str {
        match self {
            Self::NotFound { .. } => "not-found",
            Self::PermissionDenied { .. } => "permission-denied",
            Self::IsDirectory { .. } => "is-directory",
            Self::NotARegularFile { .. } => "not-a-regular-file",
            Self::Io { .. } => "io",
            Self::Empty { .. } => "empty",
            Self::OtherFormat { .. } => "other-format",
            Self::Truncated { .. } => "truncated",
            Self::TrailingBytes { .. } => "trailing-bytes",
            Self::ImplausibleDimensions { .. } => "implausible-dimensions",
            Self::UnsupportedDimensions { .. } => "unsupported-dimensions",
            Self::NoValidCells { .. } => "no-valid-cells",
            Self::NotANumber { .. } => "not-a-number",
            Self::Infinite { .. } => "infinite",
        }
    }

    /// The file that the error is about, as it was named.
    #[must_use]
    pub fn path(&self) -> &Path {
        match self {
            Self::NotFound { path }
            | Self::PermissionDenied { path }
            | Self::IsDirectory { path }
            | Self::NotARegularFile { path }
            | Self::Io { path, .. }
            | Self::Empty { path }
            | Self::OtherFormat { path, .. }
            | Self::Truncated { path, .. }
            | Self::TrailingBytes { path, .. }
            | Self::ImplausibleDimensions { path, .. }
            | Self::UnsupportedDimensions { path, .. }
            | Self::NoValidCells { path }
            | Self::NotANumber { path, .. }
            | Self::Infinite { path, .. } => path,
        }
    }

    /// Sorts what the operating system said while opening or mapping `path`.
    pub(crate) fn from_io(path: &Path, source: io::Error) -> Self {
        let path = path.to_path_buf();
        match source.kind() {
            io::ErrorKind::NotFound | io::ErrorKind::NotADirectory => Self::NotFound { path },
            io::ErrorKind::PermissionDenied => Self::PermissionDenied { path },
            io::ErrorKind::IsADirectory => Self::IsDirectory { path },
            _ => Self::Io { path, source },
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
        for (from, kind) in [
            (io::ErrorKind::NotFound, "not-found"),
            (io::ErrorKind::NotADirectory, "not-found"),
            (io::ErrorKind::PermissionDenied, "permission-denied"),
            (io::ErrorKind::IsADirectory, "is-directory"),
            (io::ErrorKind::OutOfMemory, "io"),
        ] {
            let error = MerlError::from_io(Path::new("x.binary"), from.into());
            assert_eq!((error.kind(), error.is_invalid_input()), (kind, false));
            assert!(error.to_string().starts_with("x.binary: "), "{error}");
        }
    }
}
