//! The values of all cells of a grid.

use std::borrow::Cow;

use crate::grid::dimensions::{CHANNELS, Dimensions};

/// One number per channel and cell, with a scale per channel that makes BRDF values of them: borrowed from a mapped file, or
/// computed.
#[derive(Clone, Debug)]
pub struct Cells<'a> {
    dimensions: Dimensions,
    /// Three planes of little-endian doubles.
    stored: Cow<'a, [[u8; 8]]>,
    scale: [f64; CHANNELS],
}

impl<'a> Cells<'a> {
    /// The three planes of a file, one after the other.
    ///
    /// # Panics
    /// If their number is not that of the grid.
    pub(crate) fn new(dimensions: Dimensions, stored: Cow<'a, [[u8; 8]]>, scale: [f64; CHANNELS]) -> Self {
        assert_eq!(stored.len(), CHANNELS * dimensions.cells(), "three planes of {dimensions}");
        Self { dimensions, stored, scale }
    }

    /// The grid.
    #[must_use]
    pub fn dimensions(&self) -> Dimensions {
        self.dimensions
    }

    /// A BRDF value in 1/sr; negative or not finite where there is no measurement.
    ///
    /// # Panics
    /// If the channel or the cell does not exist.
    #[must_use]
    #[inline]
    pub fn value(&self, channel: usize, cell: usize) -> f64 {
        f64::from_le_bytes(self.stored[channel * self.dimensions.cells() + cell]) * self.scale[channel]
    }
}
