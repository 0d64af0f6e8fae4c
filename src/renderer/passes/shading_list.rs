//! The flat list of the cells that are shaded.

use rayon::prelude::*;

use crate::geometry::gbuffer::GBuffer;
use crate::passes::decision::Decisions;
use crate::passes::pass::Pass;
use crate::passes::pyramid::SurfacePyramid;

/// A cell that is shaded.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct ShadingPoint {
    /// Level of the cell.
    pub(crate) level: u8,
    /// Material of the cell.
    pub(crate) material: u16,
    /// Column of the cell in its level.
    pub(crate) column: u16,
    /// Row of the cell in its level.
    pub(crate) row: u16,
}

/// The list, in an order that depends on nothing but the decisions: by material, level, row, column.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct ShadingList {
    /// The points.
    pub(crate) points: Vec<ShadingPoint>,
}

/// Lists all cells that are shaded.
pub(crate) struct ShadingListPass<'a> {
    pub(crate) gbuffer: &'a GBuffer,
    pub(crate) decisions: &'a Decisions,
    pub(crate) pyramid: &'a SurfacePyramid,
    /// Number of materials.
    pub(crate) materials: usize,
}

impl Pass for ShadingListPass<'_> {
    type Output = ShadingList;

    fn run(&self, list: &mut ShadingList) {
        let Self { gbuffer, decisions, pyramid, materials } = *self;
        let rows: Vec<(usize, usize)> = decisions
            .levels
            .iter()
            .enumerate()
            .flat_map(|(k, level)| (0..level.extent.height).map(move |row| (k, row)))
            .collect();
        let found: Vec<Vec<ShadingPoint>> = rows
            .into_par_iter()
            .with_min_len(16)
            .map(|(k, row)| {
                let level = &decisions.levels[k];
                let width = level.extent.width;
                let states = level.state[row * width..][..width].iter().enumerate();
                states
                    .filter(|(_, state)| state.is_shaded())
                    .map(|(column, _)| ShadingPoint {
                        level: k as u8,
                        material: pyramid.at(gbuffer, k, row * width + column).material,
                        column: column as u16,
                        row: row as u16,
                    })
                    .collect()
            })
            .collect();
        list.points.clear();
        for material in 0..materials {
            list.points.extend(found.iter().flatten().filter(|point| usize::from(point.material) == material));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::passes::decision::{EveryPixelPass, State};
    use crate::passes::pyramid::PyramidPass;
    use crate::test_scenes::plane;

    fn point(level: u8, material: u16, column: u16, row: u16) -> ShadingPoint {
        ShadingPoint { level, material, column, row }
    }

    #[test]
    fn the_list_is_sorted_by_material_level_row_and_column() {
        // 4 x 4 pixels, the left half of material 1; the lower right block of 2 x 2 is one cell, the pixel above its corner an orphan
        let mut gbuffer = plane(4, 4, 1.0);
        (0..16).filter(|pixel| pixel % 4 < 2).for_each(|pixel| gbuffer.material[pixel] = 1);
        let (mut pyramid, mut decisions) = (SurfacePyramid::default(), Decisions::default());
        PyramidPass { gbuffer: &gbuffer }.run(&mut pyramid);
        EveryPixelPass { gbuffer: &gbuffer }.run(&mut decisions);
        for pixel in [10, 11, 14, 15] {
            decisions.levels[0].state[pixel] = State::Interpolated;
        }
        decisions.levels[0].state[6] = State::Orphan;
        decisions.levels[1].state[3] = State::Leaf;
        let mut list = ShadingList::default();
        ShadingListPass { gbuffer: &gbuffer, decisions: &decisions, pyramid: &pyramid, materials: 2 }.run(&mut list);
        let right = [(2, 0), (3, 0), (2, 1), (3, 1)].map(|(column, row)| point(0, 0, column, row));
        let left = (0..8).map(|n| point(0, 1, n % 2, n / 2));
        let expected: Vec<ShadingPoint> = right.into_iter().chain([point(1, 0, 1, 1)]).chain(left).collect();
        assert_eq!(list.points, expected);
    }
}
