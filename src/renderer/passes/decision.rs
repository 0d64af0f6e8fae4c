//! The decision pyramid: which cells are shaded, which are interpolated from coarser ones.

use rayon::prelude::*;

use crate::geometry::gbuffer::{BACKGROUND, GBuffer};
use crate::passes::image_bandwidth::{BandwidthBuffer, COARSEST_LEVEL, NO_LEVEL};
use crate::passes::pyramid::{Cells, Extent};
use crate::passes::upsampling_stencil::{Coarser, Parents, Upsampling};

/// Cells that one thread takes at a time, at least.
const SPLIT: usize = 4096;

/// What becomes of a cell.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[repr(u8)]
pub enum State {
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
    pub fn is_shaded(self) -> bool {
        matches!(self, Self::Leaf | Self::Orphan)
    }
}

/// The decisions of one level.
#[derive(Clone, Debug, Default)]
pub struct DecisionLevel {
    /// Columns and rows.
    pub extent: Extent,
    /// Of every cell.
    pub state: Vec<State>,
    /// Refined cells that get the mean of what was shaded below them.
    pub(crate) pulled: Vec<bool>,
    /// Level that the cell allows, graded; [`NO_LEVEL`] where it is empty.
    allowed: Vec<u8>,
    /// Where interpolated cells get their values from.
    pub(crate) parents: Vec<Parents>,
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
        self.parents.clear();
        self.parents.resize(count, Parents::default());
    }
}

/// The decisions of all levels, pixels first.
#[derive(Clone, Debug, Default)]
pub struct Decisions {
    /// Levels 0 to 5.
    pub levels: [DecisionLevel; COARSEST_LEVEL + 1],
}

impl Decisions {
    /// Decides for all cells: levels upwards, leaves downwards, what can be pulled upwards, orphans downwards.
    pub(crate) fn compute(
        &mut self,
        gbuffer: &GBuffer,
        cells: &Cells,
        buffer: &BandwidthBuffer,
        upsampling: Upsampling,
    ) {
        for (k, level) in self.levels.iter_mut().enumerate() {
            level.clear(Extent::of_level(gbuffer, k));
        }
        self.levels[0].allowed.copy_from_slice(&buffer.level);
        self.grade();
        self.divide(gbuffer, cells);
        self.mark_pulled(gbuffer, cells);
        for k in (0..COARSEST_LEVEL).rev() {
            self.find_parents(gbuffer, cells, k, upsampling);
        }
    }

    /// Every pixel is shaded by itself.
    pub(crate) fn all_pixels(&mut self, gbuffer: &GBuffer) {
        for (k, level) in self.levels.iter_mut().enumerate() {
            level.clear(Extent::of_level(gbuffer, k));
        }
        for (state, &material) in self.levels[0].state.iter_mut().zip(&gbuffer.material) {
            *state = if material == BACKGROUND { State::Empty } else { State::Leaf };
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
    fn divide(&mut self, gbuffer: &GBuffer, cells: &Cells) {
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
                let small_enough = || usize::from(allowed[index]) >= k && cells.at(gbuffer, k, index).coherent;
                *state = match above {
                    State::Leaf | State::Interpolated => State::Interpolated,
                    _ if k == 0 || small_enough() => State::Leaf,
                    _ => State::Refined,
                };
            });
        }
    }

    /// From the pixels up: refined cells with shaded or pulled children of their material.
    fn mark_pulled(&mut self, gbuffer: &GBuffer, cells: &Cells) {
        for k in 1..=COARSEST_LEVEL {
            let (below, above) = self.levels.split_at_mut(k);
            let (children, level) = (&below[k - 1], &mut above[0]);
            let (width, state) = (level.extent.width, &level.state);
            level.pulled.par_iter_mut().enumerate().with_min_len(SPLIT).for_each(|(index, pulled)| {
                if state[index] == State::Refined {
                    let material = cells.level(k)[index].material;
                    *pulled = children_of(index, width, children.extent).any(|child| {
                        (children.state[child] == State::Leaf || children.pulled[child])
                            && cells.at(gbuffer, k - 1, child).material == material
                    });
                }
            });
        }
    }

    /// The parents of the cells of a level that are to be interpolated; those without become orphans.
    fn find_parents(&mut self, gbuffer: &GBuffer, cells: &Cells, k: usize, upsampling: Upsampling) {
        let (finer, coarser) = self.levels.split_at_mut(k + 1);
        let (level, above) = (&mut finer[k], &coarser[0]);
        let has_value = |index: usize| above.has_value(index);
        let above = Coarser { extent: above.extent, cells: cells.level(k + 1), has_value };
        let width = level.extent.width;
        let rows = level.state.par_chunks_mut(width).zip(level.parents.par_chunks_mut(width));
        rows.enumerate().for_each(|(y, (states, parents))| {
            for x in 0..width {
                if states[x] != State::Interpolated {
                    continue;
                }
                let cell = cells.at(gbuffer, k, y * width + x);
                match Parents::find(&cell, [x, y], k, &above, gbuffer, upsampling) {
                    Some(found) => parents[x] = found,
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
