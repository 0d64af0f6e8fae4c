//! The shading of the points of a list.

use std::ops::Range;

use rayon::prelude::*;
use wide::f32x4;

use crate::geometry::gbuffer::GBuffer;
use crate::geometry::vec3::Vec3;
use crate::lights::light_set::{LightSet, LookUp};
use crate::passes::allocation::SampleCounts;
use crate::passes::direct_lighting::{Batch, Gathering, LANES, Place, Request, Stage};
use crate::passes::material::ShadingMaterial;
use crate::passes::pass::Pass;
use crate::passes::pyramid::central_pixels;
use crate::passes::shading_list::ShadingPoint;

/// Samples that one job takes, at least: many batches.
const JOB: u64 = 4096;

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
    use crate::test_scenes::plane;

    #[test]
    fn jobs_cover_the_list_and_keep_materials_apart() {
        let point = |column| ShadingPoint { level: 0, material: u16::from(column >= 25), column, row: 0 };
        let points: Vec<ShadingPoint> = (0..60).map(point).collect();
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
