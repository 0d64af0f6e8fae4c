//! Up-sampling from shading points to pixels: values are pulled up into refined cells, then interpolated from coarse to fine.

use rayon::prelude::*;
use wide::f32x4;

use crate::geometry::gbuffer::GBuffer;
use crate::passes::decision::{Decisions, State, children_of};
use crate::passes::image_bandwidth::COARSEST_LEVEL;
use crate::passes::pass::Pass;
use crate::passes::pyramid::SurfacePyramid;
use crate::passes::shading_list::ShadingPoint;

/// Least cosine between normals in the weight of a pulled child.
const LEAST_COSINE: f32 = 0.01;

/// Radiance with a texture of 1 of every cell of every level.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct CellRadiance {
    /// Levels 0 to 5, row-major; red, green, blue, unused; zeros where a cell has no value.
    pub(crate) levels: [Vec<f32x4>; COARSEST_LEVEL + 1],
}

/// Puts the shaded values in their places and interpolates all others.
pub(crate) struct UpsamplingPass<'a> {
    pub(crate) gbuffer: &'a GBuffer,
    pub(crate) pyramid: &'a SurfacePyramid,
    pub(crate) decisions: &'a Decisions,
    pub(crate) points: &'a [ShadingPoint],
    /// Radiance of each point.
    pub(crate) shaded: &'a [f32x4],
}

impl Pass for UpsamplingPass<'_> {
    type Output = CellRadiance;

    fn run(&self, radiance: &mut CellRadiance) {
        let Self { gbuffer, pyramid, decisions, .. } = *self;
        for (values, level) in radiance.levels.iter_mut().zip(&decisions.levels) {
            values.clear();
            values.resize(level.extent.count(), f32x4::ZERO);
        }
        for (point, &shaded) in self.points.iter().zip(self.shaded) {
            let k = usize::from(point.level);
            let index = usize::from(point.row) * decisions.levels[k].extent.width + usize::from(point.column);
            radiance.levels[k][index] = shaded;
        }
        for k in 1..=COARSEST_LEVEL {
            radiance.pull(gbuffer, pyramid, decisions, k);
        }
        for k in (0..COARSEST_LEVEL).rev() {
            radiance.push(decisions, k);
        }
    }
}

impl CellRadiance {
    /// Refined cells of a level take the weighted mean of their children.
    fn pull(&mut self, gbuffer: &GBuffer, pyramid: &SurfacePyramid, decisions: &Decisions, k: usize) {
        let (level, below) = (&decisions.levels[k], &decisions.levels[k - 1]);
        let (finer, coarser) = self.levels.split_at_mut(k);
        let (children, values) = (&finer[k - 1], &mut coarser[0]);
        let width = level.extent.width;
        values.par_iter_mut().enumerate().with_min_len(1024).for_each(|(index, value)| {
            if !level.pulled[index] {
                return;
            }
            let cell = &pyramid.level(k)[index];
            let (mut sum, mut total) = (f32x4::ZERO, 0.0);
            for child in children_of(index, width, below.extent) {
                if below.state[child] != State::Leaf && !below.pulled[child] {
                    continue;
                }
                let child_cell = pyramid.at(gbuffer, k - 1, child);
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
            let stencils = &level.stencils[y * width..][..width];
            for (x, value) in values.iter_mut().enumerate() {
                if states[x] == State::Interpolated {
                    *value = stencils[x].value([x, y], above.extent.width, parents);
                }
            }
        });
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::passes::decision::DecisionPass;
    use crate::passes::pyramid::PyramidPass;
    use crate::passes::shading_list::{ShadingList, ShadingListPass};
    use crate::passes::upsampling_stencil::Upsampling;
    use crate::test_scenes::plane;

    /// Radiance of all pixels where each shading point has the value that `value` gives for it and the centre of its cell, in pixels.
    fn upsampled(
        gbuffer: &GBuffer,
        levels: &[u8],
        upsampling: Upsampling,
        value: impl Fn(&ShadingPoint, [f32; 2]) -> f32,
    ) -> Vec<f32> {
        let (mut pyramid, mut decisions) = (SurfacePyramid::default(), Decisions::default());
        let (mut list, mut radiance) = (ShadingList::default(), CellRadiance::default());
        PyramidPass { gbuffer }.run(&mut pyramid);
        DecisionPass { gbuffer, pyramid: &pyramid, levels, upsampling }.run(&mut decisions);
        let (pyramid, decisions) = (&pyramid, &decisions);
        ShadingListPass { gbuffer, decisions, pyramid, materials: 2 }.run(&mut list);
        let centre = |at: u16, level: u8| (f32::from(at) + 0.5) * f32::from(1_u16 << level);
        let shaded = |point: &ShadingPoint| {
            let centre = [point.column, point.row].map(|at| centre(at, point.level));
            f32x4::splat(value(point, centre))
        };
        let shaded: Vec<f32x4> = list.points.iter().map(shaded).collect();
        UpsamplingPass { gbuffer, pyramid, decisions, points: &list.points, shaded: &shaded }.run(&mut radiance);
        radiance.levels[0].iter().map(|value| value.to_array()[0]).collect()
    }

    const BOTH: [Upsampling; 2] = [Upsampling::EdgeAware, Upsampling::Published];

    #[test]
    fn a_constant_is_reproduced() {
        let gbuffer = plane(53, 41, 1.0);
        // leaves of all levels side by side
        let levels: Vec<u8> = (0..53 * 41).map(|pixel| ((pixel % 53) / 8).min(5) as u8).collect();
        for upsampling in BOTH {
            let pixels = upsampled(&gbuffer, &levels, upsampling, |_, _| 3.0);
            assert!(pixels.iter().all(|&value| (value - 3.0).abs() < 1e-5), "{upsampling:?}");
        }
    }

    #[test]
    fn a_linear_field_is_reproduced_away_from_the_border() {
        let gbuffer = plane(96, 96, 1.0);
        let field = |[x, y]: [f32; 2]| 100.0 + 2.0 * x - 0.5 * y;
        // shaded once per 8 x 8 pixels
        let pixels = upsampled(&gbuffer, &[3; 96 * 96], Upsampling::EdgeAware, |_, centre| field(centre));
        for (pixel, &value) in pixels.iter().enumerate() {
            let [x, y] = [pixel % 96, pixel / 96];
            if [x, y].iter().all(|at| (28..68).contains(at)) {
                let expected = field([x as f32 + 0.5, y as f32 + 0.5]);
                assert!((value - expected).abs() < 1e-3, "({x}, {y}): {value} {expected}");
            }
        }
    }

    #[test]
    fn materials_do_not_mix() {
        let mut gbuffer = plane(40, 40, 1.0);
        let material = |pixel: usize| u16::from(pixel % 40 + pixel / 40 > 37);
        (0..1600).for_each(|pixel| gbuffer.material[pixel] = material(pixel));
        for upsampling in BOTH {
            let pixels = upsampled(&gbuffer, &[5; 1600], upsampling, |point, _| f32::from(point.material));
            for (pixel, &value) in pixels.iter().enumerate() {
                assert!((value - f32::from(material(pixel))).abs() < 1e-5, "{upsampling:?} {pixel}: {value}");
            }
        }
    }
}
