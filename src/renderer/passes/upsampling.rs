//! From the shading points to all pixels: values pulled up into refined cells, then interpolated from coarse to fine.

use rayon::prelude::*;
use wide::f32x4;

use crate::geometry::gbuffer::GBuffer;
use crate::passes::decision::{Decisions, State, children_of};
use crate::passes::image_bandwidth::COARSEST_LEVEL;
use crate::passes::pyramid::Cells;
use crate::passes::shading::ShadingList;

/// Least cosine between normals in the weight of a pulled child.
const LEAST_COSINE: f32 = 0.01;

/// Radiance with a texture of 1 of every cell of every level.
#[derive(Clone, Debug, Default)]
pub struct Values {
    /// Levels 0 to 5, row-major; red, green, blue and something.
    pub(crate) levels: [Vec<f32x4>; COARSEST_LEVEL + 1],
}

impl Values {
    /// Puts the shaded values in their places and interpolates all others.
    pub(crate) fn compute(
        &mut self,
        gbuffer: &GBuffer,
        cells: &Cells,
        decisions: &Decisions,
        list: &ShadingList,
        radiance: &[f32x4],
    ) {
        for (values, level) in self.levels.iter_mut().zip(&decisions.levels) {
            values.resize(level.extent.count(), f32x4::ZERO);
        }
        for (point, &radiance) in list.points.iter().zip(radiance) {
            let k = usize::from(point.level);
            let index = usize::from(point.row) * decisions.levels[k].extent.width + usize::from(point.column);
            self.levels[k][index] = radiance;
        }
        for k in 1..=COARSEST_LEVEL {
            self.pull(gbuffer, cells, decisions, k);
        }
        for k in (0..COARSEST_LEVEL).rev() {
            self.push(decisions, k);
        }
    }

    /// Refined cells of a level take the weighted mean of their children.
    fn pull(&mut self, gbuffer: &GBuffer, cells: &Cells, decisions: &Decisions, k: usize) {
        let (level, below) = (&decisions.levels[k], &decisions.levels[k - 1]);
        let (finer, coarser) = self.levels.split_at_mut(k);
        let (children, values) = (&finer[k - 1], &mut coarser[0]);
        let width = level.extent.width;
        values.par_iter_mut().enumerate().with_min_len(1024).for_each(|(index, value)| {
            if !level.pulled[index] {
                return;
            }
            let cell = &cells.level(k)[index];
            let (mut sum, mut total) = (f32x4::ZERO, 0.0);
            for child in children_of(index, width, below.extent) {
                if below.state[child] != State::Leaf && !below.pulled[child] {
                    continue;
                }
                let child_cell = cells.at(gbuffer, k - 1, child);
                if child_cell.material == cell.material {
                    let weight = child_cell.normal.dot(&cell.normal).max(LEAST_COSINE).powi(8);
                    sum += children[child] * weight;
                    total += weight;
                }
            }
            *value = sum / total;
        });
    }

    /// Interpolated cells of a level take their values from the level above.
    fn push(&mut self, decisions: &Decisions, k: usize) {
        let (level, above) = (&decisions.levels[k], &decisions.levels[k + 1]);
        let (finer, coarser) = self.levels.split_at_mut(k + 1);
        let (values, parents) = (&mut finer[k], &coarser[0]);
        let width = level.extent.width;
        values.par_chunks_mut(width).enumerate().for_each(|(y, values)| {
            let states = &level.state[y * width..][..width];
            let weights = &level.parents[y * width..][..width];
            for (x, value) in values.iter_mut().enumerate() {
                if states[x] == State::Interpolated {
                    *value = weights[x].value([x, y], above.extent.width, parents);
                }
            }
        });
    }
}
