//! The flat list of shading points, and their shading.

use std::ops::Range;

use rayon::prelude::*;
use wide::f32x4;

use crate::geometry::gbuffer::GBuffer;
use crate::geometry::vec3::Vec3;
use crate::lights::light_set::{LightSet, LookUp};
use crate::passes::allocation::SampleCounts;
use crate::passes::decision::Decisions;
use crate::passes::direct_lighting::{Batch, Gathering, LANES, Place, Request, Stage};
use crate::passes::material::ShadingMaterial;
use crate::passes::pass::Pass;
use crate::passes::pyramid::{SurfacePyramid, central_pixels};

/// Samples that one job takes, at least: many batches.
const JOB: u64 = 4096;

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

/// Shades the points of a list.
pub(crate) struct ShadingPass<'a> {
    pub(crate) gbuffer: &'a GBuffer,
    pub(crate) materials: &'a [ShadingMaterial<'a>],
    pub(crate) lights: &'a LightSet,
    pub(crate) seed: u32,
    pub(crate) points: &'a [ShadingPoint],
    /// Samples of each point.
    pub(crate) counts: &'a SampleCounts,
}

impl Pass for ShadingPass<'_> {
    /// Radiance of each point towards the eye, with a texture of 1, in the order of the list; the last component is 0.
    type Output = Vec<f32x4>;

    fn run(&self, radiance: &mut Vec<f32x4>) {
        radiance.clear();
        radiance.resize(self.points.len(), f32x4::ZERO);
        let mut jobs = Vec::new();
        let mut rest = radiance.as_mut_slice();
        for range in self.jobs() {
            let (mine, others) = rest.split_at_mut(range.len());
            rest = others;
            jobs.push((range, mine));
        }
        jobs.into_par_iter().for_each_init(Job::default, |job, (range, radiance)| job.run(self, range, radiance));
    }
}

impl ShadingPass<'_> {
    /// Divides the list into parts of one material with about the same number of samples.
    fn jobs(&self) -> Vec<Range<usize>> {
        let points = self.points;
        let mut jobs = Vec::new();
        let (mut first, mut samples) = (0, 0);
        for (n, point) in points.iter().enumerate() {
            if n > first && (samples >= JOB || point.material != points[first].material) {
                jobs.push(first..n);
                (first, samples) = (n, 0);
            }
            samples += u64::from(self.counts.samples[n]);
        }
        if first < points.len() {
            jobs.push(first..points.len());
        }
        jobs
    }

    /// Where a point gathers light: at its pixel, or at the mean of the four around the centre of its cell. The sequences of points
    /// are those of the pixel to the lower right of the centre.
    fn place(&self, point: &ShadingPoint) -> Place {
        let (k, gbuffer) = (usize::from(point.level), self.gbuffer);
        let (column, row) = (usize::from(point.column), usize::from(point.row));
        let of_pixel = |pixel: usize| [(pixel % gbuffer.width) as u32, (pixel / gbuffer.width) as u32];
        if k == 0 {
            let n = row * gbuffer.width + column;
            let (position, normal, view) = (gbuffer.position[n], gbuffer.normal[n], gbuffer.view[n]);
            return Place { position, normal, view, pixel: of_pixel(n) };
        }
        let four = central_pixels(gbuffer, k, column, row).expect("only coherent cells are shaded");
        let sum = |vectors: &[Vec3]| four.iter().fold(Vec3::zeros(), |sum, &pixel| sum + vectors[pixel]);
        Place {
            position: 0.25 * sum(&gbuffer.position),
            normal: sum(&gbuffer.normal).normalize(),
            view: sum(&gbuffer.view).normalize(),
            pixel: of_pixel(four[3]),
        }
    }

    fn gathering(&self, material: u16, look_up: LookUp) -> Gathering<'_> {
        Gathering {
            shading: self.materials[usize::from(material)].shading.as_ref(),
            lights: self.lights,
            look_up,
            stage: Stage::Shading,
            seed: self.seed,
            least_per_light: 0,
        }
    }
}

/// A thread at work on parts of the list.
#[derive(Default)]
struct Job {
    batch: Batch,
    requests: Vec<Request>,
    /// The point of each request.
    of: Vec<usize>,
}

impl Job {
    /// Shades a part of the list, of one material.
    fn run(&mut self, pass: &ShadingPass<'_>, part: Range<usize>, radiance: &mut [f32x4]) {
        let first = part.start;
        for look_up in [LookUp::Exact, LookUp::Filtered] {
            let with = pass.gathering(pass.points[first].material, look_up);
            let mut lanes = 0;
            for n in part.clone() {
                if pass.counts.prefiltered[n] != (look_up == LookUp::Filtered) {
                    continue;
                }
                let (mut taken, samples) = (0, pass.counts.samples[n]);
                let place = pass.place(&pass.points[n]);
                while taken < samples {
                    let until = samples.min(taken + (LANES - lanes) as u32);
                    self.requests.push(Request { place, samples, taken: taken..until });
                    self.of.push(n - first);
                    lanes += (until - taken) as usize;
                    taken = until;
                    if lanes == LANES {
                        self.flush(&with, radiance);
                        lanes = 0;
                    }
                }
            }
            self.flush(&with, radiance);
        }
    }

    /// Takes the samples that have been requested and adds them to their points.
    fn flush(&mut self, with: &Gathering<'_>, radiance: &mut [f32x4]) {
        if self.requests.is_empty() {
            return;
        }
        self.batch.gather(with, &self.requests);
        for (n, &point) in self.of.iter().enumerate() {
            let [r, g, b] = self.batch.sum(n);
            radiance[point] += f32x4::from([r, g, b, 0.0]);
        }
        self.requests.clear();
        self.of.clear();
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

    #[test]
    fn jobs_cover_the_list_and_keep_materials_apart() {
        let points: Vec<ShadingPoint> = (0..60).map(|n| point(0, u16::from(n >= 25), n, 0)).collect();
        let counts = SampleCounts { samples: vec![1000; 60], prefiltered: vec![false; 60] };
        let gbuffer = plane(60, 1, 1.0);
        let lights = LightSet::default();
        let pass = ShadingPass {
            gbuffer: &gbuffer,
            materials: &[],
            lights: &lights,
            seed: 0,
            points: &points,
            counts: &counts,
        };
        // five points are the first to have 4096 samples
        let expected: Vec<Range<usize>> = (0..12).map(|n| 5 * n..5 * n + 5).collect();
        assert_eq!(pass.jobs(), expected);
    }
}
