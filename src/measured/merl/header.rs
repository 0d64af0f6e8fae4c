//! The container: a header of three little-endian integers and three planes of doubles, and nothing else.

use crate::error::ContainerFault;
use crate::grid::dimensions::{CHANNELS, Dimensions};

/// Size of the header in bytes: three `i32`. The doubles after it are therefore never aligned.
pub(crate) const HEADER_BYTES: usize = 12;

/// Largest dimension for which a header still looks like one.
const PLAUSIBLE: i32 = 4096;

/// Signatures of files that are commonly mistaken for MERL files, with their formats and remedies.
const OTHER_FORMATS: [(&[u8], &str, &str); 6] = [
    (&[0xfd, b'7', b'z', b'X', b'Z', 0], "an xz archive", "unpack it first (xz -d)"),
    (&[0x1f, 0x8b], "a gzip archive", "unpack it first (gzip -d)"),
    (b"BZh", "a bzip2 archive", "unpack it first (bzip2 -d)"),
    (&[0x28, 0xb5, 0x2f, 0xfd], "a zstd archive", "unpack it first (zstd -d)"),
    (b"PK\x03\x04", "a zip archive", "unpack it first (unzip)"),
    (b"version https://git-lfs", "a pointer to a file kept in git-lfs", "fetch the file itself (git lfs pull)"),
];

impl Dimensions {
    /// Exact size in bytes of a file with these dimensions.
    #[must_use]
    pub const fn file_bytes(self) -> u64 {
        HEADER_BYTES as u64 + (CHANNELS * self.cells()) as u64 * 8
    }

    /// The header of a file with these dimensions.
    pub(crate) fn header(self) -> [u8; HEADER_BYTES] {
        let mut header = [0; HEADER_BYTES];
        for (bytes, n) in header.chunks_exact_mut(4).zip(self.shape()) {
            bytes.copy_from_slice(&(n as u32).to_le_bytes());
        }
        header
    }
}

/// Whether a file begins with the header of a MERL file.
pub(crate) fn recognises(start: &[u8]) -> bool {
    [Dimensions::HALF_TURN, Dimensions::FULL_TURN].iter().any(|dimensions| start.starts_with(&dimensions.header()))
}

/// Checks the container: `start` holds the first bytes of the file (all, or at least the first 32), `size` is the
/// file's size in bytes.
///
/// # Errors
/// [`ContainerFault`], all but [`ContainerFault::Header`].
pub(crate) fn check(start: &[u8], size: u64) -> Result<Dimensions, ContainerFault> {
    if size == 0 {
        return Err(ContainerFault::Empty);
    }
    if let Some(&(_, format, advice)) = OTHER_FORMATS.iter().find(|(magic, ..)| start.starts_with(magic)) {
        return Err(ContainerFault::OtherFormat { format, wanted: "a MERL", advice });
    }
    let Some(header) = start.first_chunk::<HEADER_BYTES>() else {
        return Err(ContainerFault::Truncated { expected: HEADER_BYTES as u64, got: size, dimensions: None });
    };
    let integers = |read: fn([u8; 4]) -> i32| {
        let [a, b, c] = [0, 4, 8].map(|at| [header[at], header[at + 1], header[at + 2], header[at + 3]]);
        [read(a), read(b), read(c)]
    };
    let raw = integers(i32::from_le_bytes);
    if !is_plausible(raw) {
        let swapped = Some(integers(i32::from_be_bytes)).filter(|&d| is_plausible(d));
        return Err(ContainerFault::ImplausibleDimensions { dimensions: raw, swapped });
    }
    let Some(dimensions) = Dimensions::from_shape(raw.map(|n| n.unsigned_abs() as usize)) else {
        return Err(ContainerFault::UnsupportedDimensions { dimensions: raw });
    };
    let expected = dimensions.file_bytes();
    match size.cmp(&expected) {
        std::cmp::Ordering::Less => {
            Err(ContainerFault::Truncated { expected, got: size, dimensions: Some(dimensions) })
        }
        std::cmp::Ordering::Greater => {
            Err(ContainerFault::TrailingBytes { expected, got: size, dimensions: Some(dimensions) })
        }
        std::cmp::Ordering::Equal => Ok(dimensions),
    }
}

fn is_plausible(dimensions: [i32; 3]) -> bool {
    dimensions.iter().all(|n| (1..=PLAUSIBLE).contains(n))
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    #[test]
    fn header_of_the_common_grid() {
        assert_eq!(Dimensions::HALF_TURN.header(), [90, 0, 0, 0, 90, 0, 0, 0, 180, 0, 0, 0]);
        assert_eq!(Dimensions::FULL_TURN.header(), [90, 0, 0, 0, 90, 0, 0, 0, 104, 1, 0, 0]);
        assert_eq!(Dimensions::HALF_TURN.file_bytes(), 34_992_012);
        assert_eq!(Dimensions::FULL_TURN.file_bytes(), 69_984_012);
    }

    #[test]
    fn exact_sizes_are_accepted_for_both_grids() {
        for d in [Dimensions::HALF_TURN, Dimensions::FULL_TURN] {
            assert_eq!(check(&d.header(), d.file_bytes()).unwrap(), d);
        }
    }

    proptest! {
        /// Whatever the first bytes and the size are, the answer is a grid of exactly that size or an error.
        #[test]
        fn any_bytes_are_answered(start in prop::collection::vec(any::<u8>(), 0..40), size in any::<u64>()) {
            if let Ok(d) = check(&start, size) {
                prop_assert_eq!(d.file_bytes(), size);
            }
        }

        /// Near the two headers that exist, nothing else passes.
        #[test]
        fn one_changed_byte_is_noticed(at in 0..HEADER_BYTES, to in any::<u8>(), full in any::<bool>()) {
            let d = if full { Dimensions::FULL_TURN } else { Dimensions::HALF_TURN };
            let mut start = d.header();
            let unchanged = start[at] == to;
            start[at] = to;
            prop_assert_eq!(check(&start, d.file_bytes()).is_ok(), unchanged);
        }
    }
}
