//! The flat list of shading points, and their shading.

use std::ops::Range;

use rayon::prelude::*;
use wide::f32x4;

use crate::Vec3;
use crate::geometry::gbuffer::GBuffer;
use crate::lights::light_set::{LightSet, LookUp};
use crate::passes::decision::Decisions;
use crate::passes::direct_lighting::{Batch, Gathering, LANES, Place, Request, Stage};
use crate::passes::material::Material;
use crate::passes::pyramid::{Cells, central_pixels};

/// Samples that one job takes, at least: many batches.
const JOB: u64 = 4096;

/// A cell that is shaded.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ShadingPoint {
    /// Level of the cell.
    pub level: u8,
    /// Material of the cell.
    pub material: u16,
    /// Column of the cell in its level.
    pub column: u16,
    /// Row of the cell in its level.
    pub row: u16,
    /// Samples that it takes.
    pub samples: u32,
    /// Whether the light is looked up in its mips: less noise, some bias.
    pub filtered: bool,
}

/// The list, in an order that depends on nothing but the decisions: by material, level, row, column.
#[derive(Clone, Debug, Default)]
pub struct ShadingList {
    /// The points.
    pub points: Vec<ShadingPoint>,
}

impl ShadingList {
    /// Lists all cells that are shaded.
    pub(crate) fn collect(&mut self, gbuffer: &GBuffer, decisions: &Decisions, cells: &Cells, materials: usize) {
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
                        material: cells.at(gbuffer, k, row * width + column).material,
                        column: column as u16,
                        row: row as u16,
                        samples: 0,
                        filtered: false,
                    })
                    .collect()
            })
            .collect();
        self.points.clear();
        for material in 0..materials {
            self.points.extend(found.iter().flatten().filter(|point| usize::from(point.material) == material));
        }
    }

    /// Samples of all points.
    pub fn samples(&self) -> u64 {
        self.points.iter().map(|point| u64::from(point.samples)).sum()
    }
}

/// What shading needs beside the list.
pub(crate) struct Shade<'a> {
    pub(crate) gbuffer: &'a GBuffer,
    pub(crate) materials: &'a [Material<'a>],
    pub(crate) lights: &'a LightSet,
    pub(crate) seed: u32,
}

impl Shade<'_> {
    /// Radiance of each point towards the eye, with a texture of 1, in the order of the list; the last component is 1.
    pub(crate) fn shade(&self, list: &ShadingList, radiance: &mut Vec<f32x4>) {
        radiance.clear();
        radiance.resize(list.points.len(), f32x4::ZERO);
        let mut jobs = Vec::new();
        let mut rest = radiance.as_mut_slice();
        for range in self.jobs(&list.points) {
            let (mine, others) = rest.split_at_mut(range.len());
            rest = others;
            jobs.push((&list.points[range], mine));
        }
        jobs.into_par_iter().for_each_init(Job::default, |job, (points, radiance)| job.run(self, points, radiance));
    }

    /// Divides the list into parts of one material with about the same number of samples.
    fn jobs(&self, points: &[ShadingPoint]) -> Vec<Range<usize>> {
        let mut jobs = Vec::new();
        let (mut first, mut samples) = (0, 0);
        for (n, point) in points.iter().enumerate() {
            if n > first && (samples >= JOB || point.material != points[first].material) {
                jobs.push(first..n);
                (first, samples) = (n, 0);
            }
            samples += u64::from(point.samples);
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
    fn run(&mut self, shade: &Shade<'_>, points: &[ShadingPoint], radiance: &mut [f32x4]) {
        let Some(first) = points.first() else { return };
        for look_up in [LookUp::Exact, LookUp::Filtered] {
            let with = shade.gathering(first.material, look_up);
            let mut lanes = 0;
            for (n, point) in points.iter().enumerate() {
                if point.filtered != (look_up == LookUp::Filtered) {
                    continue;
                }
                let mut taken = 0;
                let place = shade.place(point);
                while taken < point.samples {
                    let until = point.samples.min(taken + (LANES - lanes) as u32);
                    self.requests.push(Request { place, samples: point.samples, taken: taken..until });
                    self.of.push(n);
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
