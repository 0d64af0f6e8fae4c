//! A set of cells, one bit each.

/// A set of cells of a plane, one bit per cell in the order of the file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct CellMask {
    words: Vec<u64>,
    cells: usize,
}

impl CellMask {
    /// The empty set over `cells` cells.
    #[must_use]
    pub fn empty(cells: usize) -> Self {
        Self { words: vec![0; cells.div_ceil(64)], cells }
    }

    /// The set of the cells for which `member` says true.
    #[must_use]
    pub fn from_fn(cells: usize, mut member: impl FnMut(usize) -> bool) -> Self {
        let mut mask = Self::empty(cells);
        for (w, word) in mask.words.iter_mut().enumerate() {
            for bit in 0..64.min(cells - 64 * w) {
                *word |= u64::from(member(64 * w + bit)) << bit;
            }
        }
        mask
    }

    /// Number of cells in the plane, members or not.
    #[must_use]
    pub fn cells(&self) -> usize {
        self.cells
    }

    /// Whether a cell is a member.
    ///
    /// # Panics
    /// If the cell lies outside the plane.
    #[must_use]
    #[inline]
    pub fn contains(&self, cell: usize) -> bool {
        assert!(cell < self.cells, "cell {cell} of {}", self.cells);
        self.words[cell / 64] >> (cell % 64) & 1 == 1
    }

    /// Number of members.
    #[must_use]
    pub fn count(&self) -> usize {
        self.words.iter().map(|word| word.count_ones() as usize).sum()
    }

    /// The cells that are members of both sets.
    ///
    /// # Panics
    /// If the sets are over planes of different sizes.
    #[must_use]
    pub fn and(&self, other: &Self) -> Self {
        assert_eq!(self.cells, other.cells, "masks of planes of different sizes");
        let words = self.words.iter().zip(&other.words).map(|(a, b)| a & b).collect();
        Self { words, cells: self.cells }
    }

    /// The members in increasing order.
    pub fn iter(&self) -> impl Iterator<Item = usize> + '_ {
        self.words.iter().enumerate().flat_map(|(w, &word)| {
            let mut rest = word;
            std::iter::from_fn(move || {
                let bit = rest.trailing_zeros();
                rest &= rest.wrapping_sub(1);
                (bit < 64).then_some(64 * w + bit as usize)
            })
        })
    }

    /// The words, 64 cells each, lowest bit first; bits past the last cell are 0.
    pub(crate) fn words_mut(&mut self) -> &mut [u64] {
        &mut self.words
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    proptest! {
        #[test]
        fn agrees_with_a_vector_of_bools(a in prop::collection::vec(any::<bool>(), 0..300), seed in any::<u64>()) {
            let b: Vec<bool> = (0..a.len()).map(|i| seed.rotate_left(i as u32) & 1 == 1).collect();
            let (ma, mb) = (CellMask::from_fn(a.len(), |i| a[i]), CellMask::from_fn(a.len(), |i| b[i]));
            let members: Vec<usize> = (0..a.len()).filter(|&i| a[i]).collect();
            prop_assert_eq!(ma.count(), members.len());
            prop_assert_eq!(ma.iter().collect::<Vec<_>>(), members);
            prop_assert!((0..a.len()).all(|i| ma.contains(i) == a[i]));
            prop_assert_eq!(ma.and(&mb), CellMask::from_fn(a.len(), |i| a[i] && b[i]));
        }
    }
}
