//! A MERL file in memory: mapped from disk, or made by a program.

use std::borrow::Cow;
use std::path::{Path, PathBuf};

use crate::cells::Cells;
use crate::error::{MeasurementError, Unreadable};
use crate::grid::dimensions::{CHANNEL_SCALE, CHANNELS, Dimensions};
use crate::mapped_file::MappedFile;
use crate::merl::header::{self, HEADER_BYTES};
use crate::merl::write::write_merl;

/// A MERL file, read-only. Pages that are not accessed are not read from disk.
#[derive(Debug)]
pub struct MerlFile {
    file: MappedFile,
    dimensions: Dimensions,
}

impl MerlFile {
    /// Maps a file into memory and checks its container: the dimensions and the exact size. The values are not looked
    /// at; [`MerlFile::scan`] does that. The file must stay as it is while it is open, see [`crate::open`], which opens files
    /// of all formats.
    ///
    /// # Errors
    /// Input that cannot be read, or a container that is not that of a MERL file.
    pub fn open(path: &Path) -> Result<Self, MeasurementError> {
        Self::of_mapped(MappedFile::open(path)?)
    }

    /// Takes the bytes of a whole file, with the checks of [`MerlFile::open`]; `path` serves messages only.
    ///
    /// # Errors
    /// As [`MerlFile::open`] where the container is concerned.
    pub fn from_bytes(path: impl Into<PathBuf>, bytes: Vec<u8>) -> Result<Self, MeasurementError> {
        Self::of_mapped(MappedFile::from_bytes(path, bytes))
    }

    pub(crate) fn of_mapped(file: MappedFile) -> Result<Self, MeasurementError> {
        match header::check(&file, file.len() as u64) {
            Ok(dimensions) => Ok(Self { file, dimensions }),
            Err(fault) => Err(MeasurementError::new(file.path(), fault)),
        }
    }

    /// Makes a file in memory from `value(channel, theta_h bin, theta_d bin, phi_d bin)`, in 1/sr, negative where there
    /// is no measurement; `path` serves messages only.
    ///
    /// # Errors
    /// [`Unreadable::Io`] if a value is not finite.
    pub fn from_fn(
        path: impl Into<PathBuf>,
        dimensions: Dimensions,
        value: impl FnMut(usize, usize, usize, usize) -> f64,
    ) -> Result<Self, MeasurementError> {
        let path = path.into();
        let mut bytes = Vec::with_capacity(usize::try_from(dimensions.file_bytes()).unwrap_or(0));
        match write_merl(&mut bytes, dimensions, value) {
            Ok(()) => Ok(Self { file: MappedFile::from_bytes(path, bytes), dimensions }),
            Err(source) => Err(MeasurementError::new(&path, Unreadable::Io(source))),
        }
    }

    /// The path as it was given.
    #[must_use]
    pub fn path(&self) -> &Path {
        self.file.path()
    }

    /// The grid of the file.
    #[must_use]
    pub fn dimensions(&self) -> Dimensions {
        self.dimensions
    }

    /// The whole file, header included.
    #[must_use]
    pub fn bytes(&self) -> &[u8] {
        &self.file
    }

    /// As [`MappedFile::expect_all`].
    pub(crate) fn expect_all(&self) {
        self.file.expect_all();
    }

    /// The three planes, one after the other.
    #[inline]
    pub(crate) fn planes(&self) -> &[[u8; 8]] {
        self.file[HEADER_BYTES..].as_chunks().0
    }

    /// The values of all cells.
    #[must_use]
    pub fn cells(&self) -> Cells<'_> {
        Cells::new(self.dimensions, Cow::Borrowed(self.planes()), CHANNEL_SCALE)
    }

    /// One colour plane as it is stored: one little-endian double per cell.
    ///
    /// # Panics
    /// If `channel` is not 0, 1 or 2.
    #[must_use]
    #[inline]
    pub fn plane(&self, channel: usize) -> &[[u8; 8]] {
        assert!(channel < CHANNELS, "channel {channel} of {CHANNELS}");
        let cells = self.dimensions.cells();
        &self.planes()[channel * cells..][..cells]
    }

    /// A number as it is stored.
    ///
    /// # Panics
    /// If the channel or the cell does not exist.
    #[must_use]
    #[inline]
    pub fn raw(&self, channel: usize, cell: usize) -> f64 {
        f64::from_le_bytes(self.plane(channel)[cell])
    }

    /// A BRDF value in 1/sr; negative or not finite where the file holds no measurement.
    ///
    /// # Panics
    /// If the channel or the cell does not exist.
    #[must_use]
    #[inline]
    pub fn value(&self, channel: usize, cell: usize) -> f64 {
        self.raw(channel, cell) * CHANNEL_SCALE[channel]
    }

    /// The three BRDF values of a cell in 1/sr, or `None` where it is not valid: a cell is valid if all three are finite
    /// and not negative.
    ///
    /// # Panics
    /// If the cell does not exist.
    #[must_use]
    #[inline]
    pub fn rgb(&self, cell: usize) -> Option<[f64; CHANNELS]> {
        let raw: [f64; CHANNELS] = std::array::from_fn(|channel| self.raw(channel, cell));
        raw.iter()
            .all(|&x| is_measurement(x))
            .then(|| std::array::from_fn(|channel| raw[channel] * CHANNEL_SCALE[channel]))
    }

    /// Whether a cell is valid: finite and not negative in all three planes. Such a cell may still lie below the horizon
    /// ([`crate::Grid::usable`]).
    ///
    /// # Panics
    /// If the cell does not exist.
    #[must_use]
    #[inline]
    pub fn is_valid(&self, cell: usize) -> bool {
        self.rgb(cell).is_some()
    }

    /// Nearest-cell look-up at angles in radians: the value in 1/sr of the cell that contains them, as [`Self::value`].
    ///
    /// # Panics
    /// If the channel does not exist.
    #[must_use]
    pub fn value_at(&self, channel: usize, theta_h: f64, theta_d: f64, phi_d: f64) -> f64 {
        let d = self.dimensions;
        self.value(channel, d.index(d.theta_h_bin(theta_h), d.theta_d_bin(theta_d), d.phi_d_bin(phi_d)))
    }
}

/// Whether a stored number is a measurement: finite and not negative; negative zero is one.
#[inline]
pub(crate) fn is_measurement(raw: f64) -> bool {
    (0.0..f64::INFINITY).contains(&raw)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn planes_are_scaled_and_addressed_in_order() {
        let d = Dimensions::HALF_TURN;
        let f = |c: usize, h: usize, t: usize, p: usize| (c * 1000 + h * 100 + t * 10 + p) as f64;
        let file = MerlFile::from_fn("x", d, f).unwrap();
        for (h, t, p) in [(0, 0, 0), (0, 0, 1), (0, 1, 0), (1, 0, 0), (89, 89, 179), (13, 57, 101)] {
            let cell = d.index(h, t, p);
            for c in 0..3 {
                let expected = f(c, h, t, p);
                assert!((file.value(c, cell) - expected).abs() <= 1e-15 * expected);
                // The stored number, by the layout alone.
                let at = 12 + 8 * (c * 90 * 90 * 180 + cell);
                let stored = f64::from_le_bytes(file.bytes()[at..at + 8].try_into().unwrap());
                assert_eq!(stored, file.raw(c, cell));
                assert_eq!(stored, expected / [1.0 / 1500.0, 1.15 / 1500.0, 1.66 / 1500.0][c]);
            }
        }
        assert_eq!(file.plane(2).len(), d.cells());
    }

    #[test]
    fn validity_asks_all_three_planes() {
        let d = Dimensions::HALF_TURN;
        let bad = |c: usize, _: usize, _: usize, p: usize| if p < 3 && c == p { -1.0 } else { 0.0 };
        let file = MerlFile::from_fn("x", d, bad).unwrap();
        let valid: Vec<bool> = (0..5).map(|cell| file.is_valid(cell)).collect();
        assert_eq!(valid, [false, false, false, true, true]);
        assert!(file.value(0, 0) < 0.0);
    }

    #[test]
    fn measurements_are_finite_and_not_negative() {
        for x in [0.0, -0.0, 5e-324, 1.0, f64::MAX] {
            assert!(is_measurement(x), "{x}");
        }
        for x in [-5e-324, -1.0, f64::INFINITY, f64::NEG_INFINITY, f64::NAN, -f64::NAN] {
            assert!(!is_measurement(x), "{x}");
        }
    }

    #[test]
    fn look_up_takes_the_cell_that_contains_the_angles() {
        let d = Dimensions::HALF_TURN;
        let file = MerlFile::from_fn("x", d, |_, h, t, p| (h * 90 * 180 + t * 180 + p) as f64).unwrap();
        let degrees =
            |h: f64, t: f64, p: f64| file.value_at(0, h.to_radians(), t.to_radians(), p.to_radians()).round() as usize;
        assert_eq!(degrees(0.0, 0.0, 0.0), 0);
        assert_eq!(degrees(2.5, 33.3, 44.4), d.index(15, 33, 44));
        assert_eq!(degrees(2.5, 33.3, 44.4 - 180.0), d.index(15, 33, 44));
        assert_eq!(degrees(90.0, 90.0, 179.9), d.index(89, 89, 179));
    }
}
