//! For each cell without a value the nearest cell that has one: an exact Euclidean distance transform.
//!
//! The transform is separable (Felzenszwalb & Huttenlocher, "Distance Transforms of Sampled Functions", Theory of
//! Computing 8, 2012): squared distances along the innermost axis, then their lower envelope along each other axis. Only
//! rows that miss a value are looked at, all their cells at once, outwards until no farther row can be nearer.

/// Squared length of a step along each axis, in units of 1e-4: (1, 1.01, 1.02) squared. The unequal steps prefer one axis
/// over another where distances would tie.
const STEP_SQUARES: [i32; 3] = [10_000, 10_201, 10_404];

/// A squared distance above all that occur; with a whole axis added it still fits.
const FAR: i32 = 1 << 30;

/// The nearest member of `valid` for each cell that is not one, as (cell, source) in increasing order of the cells;
/// `None` where there is no member. The last axis is contiguous. Of sources at the same distance the one taken depends on
/// `valid` alone.
///
/// # Panics
/// If the size is not that of the shape, or an axis has more than 256 cells.
pub(crate) fn nearest(shape: [usize; 3], valid: &[bool]) -> Option<Vec<(usize, usize)>> {
    let [slabs, rows, width] = shape;
    assert!(valid.len() == slabs * rows * width && shape.iter().all(|&n| n <= 256), "{} cells, {shape:?}", valid.len());
    if !valid.contains(&true) {
        return None;
    }
    let (squares, along_row) = along_rows(valid, width);
    let gaps: Vec<_> = valid.chunks_exact(width).map(gap).collect();

    let mut squares_in_slab = squares.clone();
    let mut along_slab: Vec<u8> = (0..valid.len()).map(|cell| (cell / width % rows) as u8).collect();
    let mut search = Search::default();
    for (row, gap) in gaps.iter().enumerate().filter(|(_, gap)| !gap.is_empty()) {
        let slab = row / rows * rows;
        search.run(&squares, |d| (slab + d) * width, [row - slab, rows], STEP_SQUARES[1], gap.clone());
        let cells = row * width + gap.start..row * width + gap.end;
        squares_in_slab[cells.clone()].copy_from_slice(&search.best);
        for (along, &from) in along_slab[cells].iter_mut().zip(&search.from) {
            *along = from as u8;
        }
    }

    let mut found = Vec::new();
    for (row, gap) in gaps.iter().enumerate().filter(|(_, gap)| !gap.is_empty()) {
        let (h, d) = (row / rows, row % rows);
        search.run(&squares_in_slab, |h| (h * rows + d) * width, [h, slabs], STEP_SQUARES[0], gap.clone());
        for (p, &from) in gap.clone().zip(&search.from).filter(|&(p, _)| !valid[row * width + p]) {
            let slab = from as usize * rows;
            let source_row = slab + usize::from(along_slab[(slab + d) * width + p]);
            found.push((row * width + p, source_row * width + usize::from(along_row[source_row * width + p])));
        }
    }
    Some(found)
}

/// From the first to the last cell of a row that is not valid.
fn gap(row: &[bool]) -> std::ops::Range<usize> {
    let first = row.iter().position(|valid| !valid).unwrap_or(0);
    first..row.iter().rposition(|valid| !valid).map_or(first, |last| last + 1)
}

/// Squared distance of each cell to the nearest valid one of its row, and the place of that one.
fn along_rows(valid: &[bool], width: usize) -> (Vec<i32>, Vec<u8>) {
    let mut squares = vec![FAR; valid.len()];
    let mut places = vec![0; valid.len()];
    for ((valid, squares), places) in
        valid.chunks_exact(width).zip(squares.chunks_exact_mut(width)).zip(places.chunks_exact_mut(width))
    {
        let mut sweep = |columns: &mut dyn Iterator<Item = usize>| {
            let mut last = None;
            for p in columns {
                if valid[p] {
                    last = Some(p);
                }
                if let Some(place) = last {
                    let square = STEP_SQUARES[2] * (p.abs_diff(place) as i32).pow(2);
                    if square < squares[p] {
                        (squares[p], places[p]) = (square, place as u8);
                    }
                }
            }
        };
        sweep(&mut (0..width));
        sweep(&mut (0..width).rev());
    }
    (squares, places)
}

/// The lower envelope along one axis, for many neighbouring cells of a row at once.
#[derive(Default)]
struct Search {
    best: Vec<i32>,
    from: Vec<i32>,
}

impl Search {
    /// For the columns `gap` of the row at place `at` of `count`: the least of squared distance and squared step over the
    /// rows of the axis, the `n`th of which starts at `start(n)`, and that row's place. Nearer rows win ties, then lower.
    fn run(
        &mut self,
        squares: &[i32],
        start: impl Fn(usize) -> usize,
        [at, count]: [usize; 2],
        step_square: i32,
        gap: std::ops::Range<usize>,
    ) {
        let row = |n: usize| &squares[start(n)..][gap.clone()];
        self.best.clear();
        self.best.extend_from_slice(row(at));
        self.from.clear();
        self.from.resize(gap.len(), at as i32);
        for steps in 1..count {
            let far = step_square * (steps as i32).pow(2);
            if self.best.iter().max().is_none_or(|&worst| worst <= far) {
                break;
            }
            let sides = [at.checked_sub(steps), Some(at + steps).filter(|&n| n < count)];
            for n in sides.into_iter().flatten() {
                for ((best, from), &square) in self.best.iter_mut().zip(&mut self.from).zip(row(n)) {
                    let nearer = square + far < *best;
                    *best = if nearer { square + far } else { *best };
                    *from = if nearer { n as i32 } else { *from };
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn square(shape: [usize; 3], a: usize, b: usize) -> i32 {
        let place = |cell: usize| [cell / shape[2] / shape[1], cell / shape[2] % shape[1], cell % shape[2]];
        let (a, b) = (place(a), place(b));
        (0..3).map(|n| STEP_SQUARES[n] * (a[n].abs_diff(b[n]) as i32).pow(2)).sum()
    }

    /// scipy.ndimage.distance_transform_edt, by scripts/fixtures/make_fill.py: each source is as near as the oracle's, and where no
    /// other is as near, it is the oracle's.
    #[test]
    fn agrees_with_scipy() {
        #[derive(serde::Deserialize)]
        struct Case {
            shape: [usize; 3],
            valid: String,
            sources: Vec<usize>,
        }
        let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../data-fixtures/fill.json");
        let golden: serde_json::Value = serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap();
        let cases: Vec<Case> = serde_json::from_value(golden["cases"].clone()).unwrap();
        assert!(cases.len() >= 4);
        for Case { shape, valid, sources } in cases {
            let valid: Vec<bool> = valid.bytes().map(|byte| byte == b'1').collect();
            let found = nearest(shape, &valid).unwrap();
            assert_eq!(found.len(), valid.iter().filter(|valid| !*valid).count());
            for (cell, source) in found {
                assert!(valid[source] && !valid[cell]);
                let expected = square(shape, cell, sources[cell]);
                assert_eq!(square(shape, cell, source), expected, "{shape:?} {cell}");
                let ties = (0..valid.len()).filter(|&other| valid[other] && square(shape, cell, other) == expected);
                assert!(ties.count() > 1 || source == sources[cell], "{shape:?} {cell}");
            }
        }
    }

    proptest! {
        #[test]
        fn no_valid_cell_is_nearer(
            shape in (1..9_usize, 1..9_usize, 1..12_usize).prop_map(|(a, b, c)| [a, b, c]),
            draws in prop::collection::vec(0..100_u8, 9 * 9 * 12),
            share in 0..100_u8,
        ) {
            let cells: usize = shape.iter().product();
            let valid: Vec<bool> = draws[..cells].iter().map(|&draw| draw < share).collect();
            match nearest(shape, &valid) {
                None => prop_assert!(!valid.contains(&true)),
                Some(found) => {
                    let missing: Vec<usize> = (0..cells).filter(|&cell| !valid[cell]).collect();
                    prop_assert_eq!(found.iter().map(|pair| pair.0).collect::<Vec<_>>(), missing);
                    for (cell, source) in found {
                        prop_assert!(valid[source]);
                        let least = (0..cells).filter(|&n| valid[n]).map(|n| square(shape, cell, n)).min();
                        prop_assert_eq!(Some(square(shape, cell, source)), least);
                    }
                }
            }
        }
    }
}
