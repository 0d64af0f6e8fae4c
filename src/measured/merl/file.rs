//! A MERL file in memory: mapped from disk, or made by a program.

use std::fs::File;
use std::ops::Deref;
use std::path::{Path, PathBuf};

use memmap2::Mmap;

use crate::error::MerlError;
use crate::grid::dimensions::{CHANNEL_SCALE, CHANNELS, Dimensions};
use crate::merl::header::{self, HEADER_BYTES};
use crate::merl::write::write_merl;

/// A MERL file, read-only. What is not looked at is not read from the disk.
#[derive(Debug)]
pub struct MerlFile {
    path: PathBuf,
    dimensions: Dimensions,
    bytes: Bytes,
}

/// The whole file, header included.
#[derive(Debug)]
enum Bytes {
    Mapped(Mmap),
    Owned(Vec<u8>),
}

impl Deref for Bytes {
    type Target = [u8];

    fn deref(&self) -> &[u8] {
        match self {
            Self::Mapped(map) => map,
            Self::Owned(bytes) => bytes,
        }
    }
}

impl MerlFile {
    /// Maps a file into memory and checks its container: the dimensions and the exact size. The values are not looked
    /// at; [`MerlFile::scan`] does that.
    ///
    /// The file must stay as it is while it is open. If another process cuts it, reading the missing part ends this
    /// process (SIGBUS on Unix); if another process writes to it, old and new values may be seen mixed.
    ///
    /// # Errors
    /// Input that cannot be read, or a container that is not that of a MERL file: every variant of [`MerlError`] but
    /// the three about values.
    pub fn open(path: &Path) -> Result<Self, MerlError> {
        let failed = |source| MerlError::from_io(path, source);
        // Asked before opening, because opening a pipe would wait for its writer.
        let kind = std::fs::metadata(path).map_err(failed)?.file_type();
        if kind.is_dir() {
            return Err(MerlError::IsDirectory { path: path.to_path_buf() });
        }
        if !kind.is_file() {
            return Err(MerlError::NotARegularFile { path: path.to_path_buf() });
        }
        let file = File::open(path).map_err(failed)?;
        let size = file.metadata().map_err(failed)?.len();
        if size == 0 {
            return Err(MerlError::Empty { path: path.to_path_buf() });
        }
        let map = map(&file).map_err(failed)?;
        let dimensions = header::check(path, &map, map.len() as u64)?;
        Ok(Self { path: path.to_path_buf(), dimensions, bytes: Bytes::Mapped(map) })
    }

    /// Takes the bytes of a whole file, with the checks of [`MerlFile::open`]; `path` serves messages only.
    ///
    /// # Errors
    /// As [`MerlFile::open`] where the container is concerned.
    pub fn from_bytes(path: impl Into<PathBuf>, bytes: Vec<u8>) -> Result<Self, MerlError> {
        let path = path.into();
        let dimensions = header::check(&path, &bytes, bytes.len() as u64)?;
        Ok(Self { path, dimensions, bytes: Bytes::Owned(bytes) })
    }

    /// Makes a file in memory from `value(channel, theta_h bin, theta_d bin, phi_d bin)`, in 1/sr, negative where there
    /// is no measurement; `path` serves messages only.
    ///
    /// # Errors
    /// [`MerlError::Io`] if a value is not finite.
    pub fn from_fn(
        path: impl Into<PathBuf>,
        dimensions: Dimensions,
        value: impl FnMut(usize, usize, usize, usize) -> f64,
    ) -> Result<Self, MerlError> {
        let path = path.into();
        let mut bytes = Vec::with_capacity(usize::try_from(dimensions.file_bytes()).unwrap_or(0));
        match write_merl(&mut bytes, dimensions, value) {
            Ok(()) => Ok(Self { path, dimensions, bytes: Bytes::Owned(bytes) }),
            Err(source) => Err(MerlError::Io { path, source }),
        }
    }

    /// The path as it was given.
    #[must_use]
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// The grid of the file.
    #[must_use]
    pub fn dimensions(&self) -> Dimensions {
        self.dimensions
    }

    /// The whole file, header included.
    #[must_use]
    pub fn bytes(&self) -> &[u8] {
        &self.bytes
    }

    /// Tells the system that the whole file is about to be read: one call instead of a page fault per 64 kB. A hint, so
    /// that it does not matter where it fails (Linux before 5.14) or does not exist.
    pub(crate) fn expect_all(&self) {
        #[cfg(target_os = "linux")]
        if let Bytes::Mapped(map) = &self.bytes {
            let _ = map.advise(memmap2::Advice::PopulateRead);
        }
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
        &self.bytes[HEADER_BYTES..].as_chunks().0[channel * cells..][..cells]
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

/// Whether a stored number is a measurement: finite and not negative. Negative zero is one.
#[inline]
pub(crate) fn is_measurement(raw: f64) -> bool {
    (0.0..f64::INFINITY).contains(&raw)
}

/// Maps a whole regular file for reading.
fn map(file: &File) -> std::io::Result<Mmap> {
    // SAFETY: the map is read-only and lives as long as the slice that is borrowed from it, and its length is the file's
    // at the time of the call. Every bit pattern is valid for the bytes and the doubles that are read. What remains is
    // what no check in this process can exclude: another process may write to the file (the bytes seen then change under
    // a shared reference, which the language does not allow for) or cut it (reading past the new end raises SIGBUS). All
    // sizes come from the length of the map and nothing that was read once is relied on to read the same again, so a
    // concurrent write leads to wrong values, not to an access outside the map. The documentation of `MerlFile::open`
    // asks for files that stay as they are.
    #[allow(unsafe_code)]
    unsafe {
        Mmap::map(file)
    }
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
