//! Drawing texels of an image in proportion to their weights, in constant time.

/// Samples stay this far from the borders of a texel, in texels, so that rounding on the way to a direction and back does not
/// carry them into the neighbour.
const INSET: f32 = 1.0 / 4096.0;

/// One entry of an alias table: below the threshold its own number, above it another.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Entry {
    threshold: f32,
    alias: u32,
}

/// Alias tables over the rows of an image and over the texels of each row.
///
/// A row and a column are drawn from one number each, and what these leave is the place inside the texel: the 24 bits of a
/// single-precision number would not be enough for one table over all texels. Source: Walker, "An efficient method for
/// generating discrete random variables with general distributions", 1977, in the order of Vose, 1991.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct TexelTable {
    n: usize,
    rows: Vec<Entry>,
    /// One table per row.
    columns: Vec<Entry>,
}

impl TexelTable {
    /// The tables for `n x n` weights, row-major, not negative, with a sum above zero.
    pub(crate) fn new(n: usize, weights: &[f64]) -> Self {
        let sums: Vec<f64> = weights.chunks_exact(n).map(|row| row.iter().sum()).collect();
        let columns = weights.chunks_exact(n).flat_map(entries).collect();
        Self { n, rows: entries(&sums), columns }
    }

    /// A place of the unit square from two numbers in [0, 1): a texel with the probability of its weight, uniform inside.
    #[inline(always)]
    pub(crate) fn place(&self, [u, v]: [f32; 2]) -> [f32; 2] {
        let scale = 1.0 / self.n as f32;
        let (row, y) = draw(&self.rows, v);
        let (column, x) = draw(&self.columns[row * self.n..][..self.n], u);
        [(column as f32 + x) * scale, (row as f32 + y) * scale]
    }
}

/// A number of the table and the rest of `u` in (0, 1), uniform.
#[inline(always)]
fn draw(entries: &[Entry], u: f32) -> (usize, f32) {
    let scaled = u * entries.len() as f32;
    let own = (scaled as usize).min(entries.len() - 1);
    let rest = scaled - own as f32;
    let Entry { threshold, alias } = entries[own];
    let first = rest < threshold;
    let number = if first { own } else { alias as usize };
    let (above, width) = if first { (rest, threshold) } else { (rest - threshold, 1.0 - threshold) };
    (number, (above / width.max(f32::MIN_POSITIVE)).clamp(0.0, 1.0) * (1.0 - 2.0 * INSET) + INSET)
}

/// The alias table of one list of weights; without any weight, a uniform one, which is never reached.
fn entries(weights: &[f64]) -> Vec<Entry> {
    let n = weights.len();
    let sum: f64 = weights.iter().sum();
    let mut entries: Vec<Entry> = (0..n as u32).map(|alias| Entry { threshold: 1.0, alias }).collect();
    if sum <= 0.0 {
        return entries;
    }
    let mut left: Vec<f64> = weights.iter().map(|weight| weight / sum * n as f64).collect();
    let (mut small, mut large): (Vec<usize>, Vec<usize>) = (0..n).rev().partition(|&k| left[k] < 1.0);
    while let (Some(&low), Some(&high)) = (small.last(), large.last()) {
        small.pop();
        entries[low] = Entry { threshold: left[low] as f32, alias: high as u32 };
        left[high] -= 1.0 - left[low];
        if left[high] < 1.0 {
            large.pop();
            small.push(high);
        }
    }
    // what rounding leaves in `small` must not keep a number of weight zero
    let largest = (0..n).max_by(|&a, &b| weights[a].total_cmp(&weights[b])).unwrap_or(0);
    for low in small {
        if weights[low] == 0.0 {
            entries[low] = Entry { threshold: 0.0, alias: largest as u32 };
        }
    }
    entries
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        /// The lengths of [0, 1) that lead to each number are the probabilities.
        #[test]
        fn tables_have_the_probabilities(weights in prop::collection::vec(prop_oneof![Just(0.0), 0.0_f64..1.0, 0.0_f64..1e6], 1..40)) {
            let sum: f64 = weights.iter().sum();
            prop_assume!(sum > 0.0);
            let mut lengths = vec![0.0; weights.len()];
            for (own, cell) in entries(&weights).iter().enumerate() {
                lengths[own] += f64::from(cell.threshold) / weights.len() as f64;
                lengths[cell.alias as usize] += (1.0 - f64::from(cell.threshold)) / weights.len() as f64;
            }
            for (length, weight) in lengths.iter().zip(&weights) {
                prop_assert!((length - weight / sum).abs() < 1e-7);
                prop_assert!(*weight > 0.0 || *length == 0.0);
            }
        }

        #[test]
        fn places_lie_inside_texels_with_weight(u in 0.0_f32..1.0, v in 0.0_f32..1.0) {
            let weights = [0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 3.0, 0.0, 0.0, 1e-6, 0.0, 0.0, 0.0, 0.0];
            let [x, y] = TexelTable::new(4, &weights).place([u, v]).map(|x| x * 4.0);
            prop_assert!(weights[y as usize * 4 + x as usize] > 0.0);
            for offset in [x.fract(), y.fract()] {
                prop_assert!((1e-4..0.9999).contains(&offset));
            }
        }
    }
}
