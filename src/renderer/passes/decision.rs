//! The decision pyramid: which cells are shaded, which are interpolated from coarser ones.

use rayon::prelude::*;

use crate::geometry::gbuffer::{BACKGROUND, GBuffer};
use crate::passes::image_bandwidth::{COARSEST_LEVEL, NO_LEVEL};
use crate::passes::pass::Pass;
use crate::passes::pyramid::{Extent, SurfacePyramid};
use crate::passes::upsampling_stencil::{Coarser, Stencil, Upsampling};

/// Cells that one thread takes at a time, at least.
const SPLIT: usize = 4096;

/// State of a cell.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[repr(u8)]
pub(crate) enum State {
    /// No surface.
    #[default]
    Empty,
    /// Shaded: small enough for what varies in it.
    Leaf,
    /// Too coarse: its children decide.
    Refined,
    /// Lies below a cell that is shaded, gets its value from the level above.
    Interpolated,
    /// Should be interpolated and has no parents to be interpolated from: shaded.
    Orphan,
    /// As an orphan, but too coarse to be shaded: its children try again.
    Invalid,
}

impl State {
    /// Whether the cell is on the list of shading points.
    pub(crate) fn is_shaded(self) -> bool {
        matches!(self, Self::Leaf | Self::Orphan)
    }
}

/// The decisions of one level.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct DecisionLevel {
    /// Columns and rows.
    pub(crate) extent: Extent,
    /// Of every cell.
    pub(crate) state: Vec<State>,
    /// Refined cells that get the mean of what was shaded below them.
    pub(crate) pulled: Vec<bool>,
    /// Level that the cell allows, graded; [`NO_LEVEL`] where it is empty.
    allowed: Vec<u8>,
    /// Stencils of the interpolated cells.
    pub(crate) stencils: Vec<Stencil>,
}

impl DecisionLevel {
    /// Whether a cell has a value when finer cells are interpolated.
    #[inline]
    pub(crate) fn has_value(&self, index: usize) -> bool {
        match self.state[index] {
            State::Leaf | State::Orphan | State::Interpolated => true,
            State::Refined => self.pulled[index],
            State::Empty | State::Invalid => false,
        }
    }

    fn clear(&mut self, extent: Extent) {
        self.extent = extent;
        let count = extent.count();
        self.state.clear();
        self.state.resize(count, State::Empty);
        self.pulled.clear();
        self.pulled.resize(count, false);
        self.allowed.clear();
        self.allowed.resize(count, NO_LEVEL);
        self.stencils.clear();
        self.stencils.resize(count, Stencil::default());
    }
}

/// The decisions of all levels, pixels first.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Decisions {
    /// Levels 0 to 5.
    pub(crate) levels: [DecisionLevel; COARSEST_LEVEL + 1],
}

/// Decides for all cells: levels upwards, leaves downwards, what can be pulled upwards, orphans downwards.
pub(crate) struct DecisionPass<'a> {
    pub(crate) gbuffer: &'a GBuffer,
    pub(crate) pyramid: &'a SurfacePyramid,
    /// Coarsest level at which each pixel may be shaded; [`NO_LEVEL`] in the background.
    pub(crate) levels: &'a [u8],
    pub(crate) upsampling: Upsampling,
}

impl Pass for DecisionPass<'_> {
    type Output = Decisions;

    fn run(&self, decisions: &mut Decisions) {
        let Self { gbuffer, pyramid, levels, upsampling } = *self;
        decisions.clear(gbuffer);
        decisions.levels[0].allowed.copy_from_slice(levels);
        decisions.grade();
        decisions.divide(gbuffer, pyramid);
        decisions.mark_pulled(gbuffer, pyramid);
        for k in (0..COARSEST_LEVEL).rev() {
            decisions.find_stencils(gbuffer, pyramid, k, upsampling);
        }
    }
}

/// Every pixel is shaded by itself.
pub(crate) struct EveryPixelPass<'a> {
    pub(crate) gbuffer: &'a GBuffer,
}

impl Pass for EveryPixelPass<'_> {
    type Output = Decisions;

    fn run(&self, decisions: &mut Decisions) {
        decisions.clear(self.gbuffer);
        for (state, &material) in decisions.levels[0].state.iter_mut().zip(&self.gbuffer.material) {
            *state = if material == BACKGROUND { State::Empty } else { State::Leaf };
        }
    }
}

impl Decisions {
    fn clear(&mut self, gbuffer: &GBuffer) {
        for (k, level) in self.levels.iter_mut().enumerate() {
            level.clear(Extent::of_level(gbuffer, k));
        }
    }

    /// The levels that cells allow: the minimum of their children, then neighbours differ by one at most.
    fn grade(&mut self) {
        for k in 1..=COARSEST_LEVEL {
            let (below, above) = self.levels.split_at_mut(k);
            let (children, level) = (&below[k - 1], &mut above[0]);
            let Extent { width, height } = level.extent;
            let least = |index: usize| {
                children_of(index, width, children.extent)
                    .fold(NO_LEVEL, |least, child| least.min(children.allowed[child]))
            };
            let least: Vec<u8> = (0..width * height).into_par_iter().with_min_len(SPLIT).map(least).collect();
            let graded = |(index, allowed): (usize, &mut u8)| {
                let (x, y) = (index % width, index / width);
                let columns = x.saturating_sub(1)..(x + 2).min(width);
                let around = (y.saturating_sub(1)..(y + 2).min(height)).fold(NO_LEVEL, |around, y| {
                    least[y * width..][columns.clone()].iter().fold(around, |around, &other| around.min(other))
                });
                *allowed = if least[index] == NO_LEVEL { NO_LEVEL } else { least[index].min(around.saturating_add(1)) };
            };
            level.allowed.par_iter_mut().enumerate().with_min_len(SPLIT).for_each(graded);
        }
    }

    /// From the coarsest level down: leaves, what lies below them, and what is refined.
    fn divide(&mut self, gbuffer: &GBuffer, pyramid: &SurfacePyramid) {
        for k in (0..=COARSEST_LEVEL).rev() {
            let (finer, coarser) = self.levels.split_at_mut(k + 1);
            let (level, above) = (&mut finer[k], coarser.first());
            let (width, allowed) = (level.extent.width, &level.allowed);
            level.state.par_iter_mut().enumerate().with_min_len(SPLIT).for_each(|(index, state)| {
                if allowed[index] == NO_LEVEL {
                    return;
                }
                let above = above.map_or(State::Refined, |above| {
                    above.state[(index / width / 2) * above.extent.width + index % width / 2]
                });
                let small_enough = || usize::from(allowed[index]) >= k && pyramid.at(gbuffer, k, index).coherent;
                *state = match above {
                    State::Leaf | State::Interpolated => State::Interpolated,
                    _ if k == 0 || small_enough() => State::Leaf,
                    _ => State::Refined,
                };
            });
        }
    }

    /// From the pixels up: refined cells with shaded or pulled children of their material.
    fn mark_pulled(&mut self, gbuffer: &GBuffer, pyramid: &SurfacePyramid) {
        for k in 1..=COARSEST_LEVEL {
            let (below, above) = self.levels.split_at_mut(k);
            let (children, level) = (&below[k - 1], &mut above[0]);
            let (width, state) = (level.extent.width, &level.state);
            level.pulled.par_iter_mut().enumerate().with_min_len(SPLIT).for_each(|(index, pulled)| {
                if state[index] == State::Refined {
                    let material = pyramid.level(k)[index].material;
                    *pulled = children_of(index, width, children.extent).any(|child| {
                        (children.state[child] == State::Leaf || children.pulled[child])
                            && pyramid.at(gbuffer, k - 1, child).material == material
                    });
                }
            });
        }
    }

    /// The stencils of the cells of a level that are to be interpolated; those without parents become orphans.
    fn find_stencils(&mut self, gbuffer: &GBuffer, pyramid: &SurfacePyramid, k: usize, upsampling: Upsampling) {
        let (finer, coarser) = self.levels.split_at_mut(k + 1);
        let (level, above) = (&mut finer[k], &coarser[0]);
        let has_value = |index: usize| above.has_value(index);
        let above = Coarser { extent: above.extent, cells: pyramid.level(k + 1), has_value };
        let width = level.extent.width;
        let rows = level.state.par_chunks_mut(width).zip(level.stencils.par_chunks_mut(width));
        rows.enumerate().for_each(|(y, (states, stencils))| {
            for x in 0..width {
                if states[x] != State::Interpolated {
                    continue;
                }
                let cell = pyramid.at(gbuffer, k, y * width + x);
                match Stencil::find(&cell, [x, y], k, &above, gbuffer, upsampling) {
                    Some(found) => stencils[x] = found,
                    None if k == 0 || (k <= 2 && cell.coherent) => states[x] = State::Orphan,
                    None => states[x] = State::Invalid,
                }
            }
        });
    }
}

/// The children of a cell, in row order.
pub(crate) fn children_of(index: usize, width: usize, children: Extent) -> impl Iterator<Item = usize> {
    let (x, y) = (2 * (index % width), 2 * (index / width));
    [(x, y), (x + 1, y), (x, y + 1), (x + 1, y + 1)]
        .into_iter()
        .filter(move |&(x, y)| x < children.width && y < children.height)
        .map(move |(x, y)| y * children.width + x)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::passes::pyramid::PyramidPass;
    use crate::test_scenes::plane;

    use State::{Interpolated, Invalid, Leaf, Orphan, Refined};

    /// The decisions for a plane of 8 x 8 pixels.
    fn decisions(gbuffer: &GBuffer, levels: &[u8]) -> Decisions {
        let mut pyramid = SurfacePyramid::default();
        PyramidPass { gbuffer }.run(&mut pyramid);
        let mut decisions = Decisions::default();
        DecisionPass { gbuffer, pyramid: &pyramid, levels, upsampling: Upsampling::EdgeAware }.run(&mut decisions);
        decisions
    }

    #[test]
    fn levels_are_the_minimum_below_and_one_more_than_the_least_around() {
        // one pixel in the corner that must be shaded by itself
        let mut levels = [5; 64];
        levels[0] = 0;
        let decisions = decisions(&plane(8, 8, 1.0), &levels);
        assert_eq!(decisions.levels[0].allowed, levels);
        assert_eq!(
            decisions.levels[1].allowed,
            [
                [0, 1, 5, 5], //
                [1, 1, 5, 5],
                [5, 5, 5, 5],
                [5, 5, 5, 5]
            ]
            .concat()
        );
        assert_eq!(decisions.levels[2].allowed, [0, 1, 1, 1]);
        for k in 3..=5 {
            assert_eq!(decisions.levels[k].allowed, [0], "level {k}");
        }
    }

    #[test]
    fn pixels_of_the_background_count_for_no_cell() {
        let mut gbuffer = plane(8, 8, 1.0);
        let mut levels = [3; 64];
        for pixel in (0..64).filter(|pixel| pixel % 8 < 2) {
            (gbuffer.material[pixel], levels[pixel]) = (BACKGROUND, NO_LEVEL);
        }
        let decisions = decisions(&gbuffer, &levels);
        assert_eq!(decisions.levels[1].allowed[..4], [NO_LEVEL, 3, 3, 3]);
        assert_eq!(decisions.levels[2].allowed, [3; 4]);
        assert_eq!(decisions.levels[1].state[0], State::Empty);
    }

    #[test]
    fn leaves_are_the_largest_cells_that_are_allowed() {
        let mut levels = [5; 64];
        levels[0] = 0;
        let decisions = decisions(&plane(8, 8, 1.0), &levels);
        for k in 2..=5 {
            assert!(decisions.levels[k].state.iter().all(|&state| state == Refined), "level {k}");
        }
        let mut cells = [Leaf; 16];
        cells[0] = Refined;
        assert_eq!(decisions.levels[1].state, cells);
        let mut pixels = [Interpolated; 64];
        for pixel in [0, 1, 8, 9] {
            pixels[pixel] = Leaf;
        }
        assert_eq!(decisions.levels[0].state, pixels);
        // what was shaded below refined cells is pulled up into them
        assert!(decisions.levels[1].pulled[0] && !decisions.levels[1].pulled[1]);
        assert!((2..=5).all(|k| decisions.levels[k].pulled.iter().all(|&pulled| pulled)));
    }

    #[test]
    fn cells_whose_centre_lies_outside_of_the_image_are_refined() {
        // levels 4 and 5 have their centre at pixels 7 and 8, 15 and 16
        let decisions = decisions(&plane(8, 8, 1.0), &[5; 64]);
        let states = [5, 4, 3, 2].map(|k| decisions.levels[k].state[0]);
        assert_eq!(states, [Refined, Refined, Leaf, Interpolated]);
        let shaded = |level: &DecisionLevel| level.state.iter().filter(|state| state.is_shaded()).count();
        assert_eq!(decisions.levels.each_ref().map(shaded), [0, 0, 0, 1, 0, 0]);
    }

    #[test]
    fn pixels_and_coherent_cells_without_parents_are_orphans() {
        // below a leaf of material 0 a block of 2 x 2 pixels of material 1 and a pixel of material 2
        let mut gbuffer = plane(8, 8, 1.0);
        for pixel in [6, 7, 14, 15] {
            gbuffer.material[pixel] = 1;
        }
        gbuffer.material[63] = 2;
        let decisions = decisions(&gbuffer, &[5; 64]);
        assert_eq!(decisions.levels[3].state, [Leaf]);
        assert_eq!(decisions.levels[2].state, [Interpolated; 4]);
        let mut cells = [Interpolated; 16];
        cells[3] = Orphan;
        assert_eq!(decisions.levels[1].state, cells);
        let mut pixels = [Interpolated; 64];
        pixels[63] = Orphan;
        assert_eq!(decisions.levels[0].state, pixels);
    }

    #[test]
    fn incoherent_cells_without_parents_leave_it_to_their_children() {
        // pixels (5, 1) and (6, 1) of material 1, the upper half of the centre of the upper right cell of level 2
        let mut gbuffer = plane(8, 8, 1.0);
        (gbuffer.material[8 + 5], gbuffer.material[8 + 6]) = (1, 1);
        let decisions = decisions(&gbuffer, &[5; 64]);
        assert_eq!(decisions.levels[2].state, [Interpolated, Invalid, Interpolated, Interpolated]);
        // beside it a cell of material 0 still finds the parent to its left, in the corner there is none
        assert_eq!(decisions.levels[1].state[..4], [Interpolated, Interpolated, Interpolated, Invalid]);
        let pixel = |x: usize, y: usize| decisions.levels[0].state[y * 8 + x];
        assert_eq!([(5, 1), (6, 1), (7, 0)].map(|(x, y)| pixel(x, y)), [Orphan; 3]);
        assert_eq!([(5, 0), (6, 0), (7, 1), (0, 0)].map(|(x, y)| pixel(x, y)), [Interpolated; 4]);
    }
}
