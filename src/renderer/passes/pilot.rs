//! The pilot: a few samples per tile of 4 x 4 pixels, from which bandwidth, mean and variance of the integrand are predicted.

use std::ops::Range;

use rayon::prelude::*;

use crate::geometry::gbuffer::{BACKGROUND, GBuffer};
use crate::geometry::sobol::seed;
use crate::images::exposure::luminance;
use crate::lights::bandwidth::LightBandwidth;
use crate::lights::octahedral_light::Light;
use crate::passes::direct_lighting::{Batch, LANES, LookUp, Place, Request, Technique};
use crate::passes::material::Material;

/// Pixels along the side of a tile.
pub const TILE: usize = 4;
/// What the printed estimate of variance takes for the bandwidth of the light where that is infinite, cycles per radian.
const PRINTED_LARGEST: f32 = 100.0;
/// Fewest samples of a point: two of either technique have a variance.
pub const LEAST_SAMPLES: u32 = 4;
/// The index of pixels without a pilot point.
pub(crate) const NONE: u32 = u32::MAX;

/// What the samples of one pilot point say, with a texture of 1.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Prediction {
    /// Angular bandwidth of what leaves the surface towards the eye, cycles per radian: the mean over the samples, weighted by
    /// their contribution, of the smaller of the bandwidths of light and lobe (paper 000, equation 5).
    pub bandwidth: f32,
    /// Luminance: the estimate of the pilot.
    pub mean: f32,
    /// Variance of one sample of the luminance.
    pub variance: f32,
    /// The bound of the variance as it is printed (paper 000, equation 9 without the factor), for comparison.
    pub printed: f32,
}

/// One path of the pilot, for transport operators that differ from pixel to pixel.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Path {
    /// Contribution to the luminance.
    pub(crate) contribution: f32,
    /// Bandwidth of the light, infinite at edges, and of the lobe, cycles per radian.
    pub(crate) light: f32,
    pub(crate) lobe: f32,
    /// Cosine of the angle of incidence.
    pub(crate) cos_theta_i: f32,
}

/// Predictions per tile and material.
#[derive(Clone, Debug, Default)]
pub struct Pilot {
    /// Pilot point of each pixel, or [`NONE`].
    pub(crate) of_pixel: Vec<u32>,
    /// One per tile and material present in it, sorted by material.
    pub(crate) predictions: Vec<Prediction>,
    /// The pixel that each point lies at.
    pub(crate) pixels: Vec<u32>,
    /// The paths of each point one after the other, where they were asked for.
    pub(crate) paths: Vec<Path>,
}

/// How the pilot samples.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct PilotOptions {
    /// Samples per point, at least [`LEAST_SAMPLES`].
    pub(crate) samples: u32,
    pub(crate) seed: u32,
    /// Whether paths are kept.
    pub(crate) keep_paths: bool,
}

impl Pilot {
    /// The prediction at a pixel; `None` in the background.
    pub fn at(&self, pixel: usize) -> Option<&Prediction> {
        self.predictions.get(self.of_pixel[pixel] as usize)
    }

    /// Samples that were taken.
    pub(crate) fn samples(&self, options: &PilotOptions) -> u64 {
        self.pixels.len() as u64 * u64::from(options.samples)
    }

    /// Chooses the points and takes their samples.
    pub(crate) fn compute(
        &mut self,
        gbuffer: &GBuffer,
        materials: &[Material<'_>],
        light: &Light,
        light_bandwidth: &LightBandwidth,
        options: &PilotOptions,
    ) {
        let groups = self.place(gbuffer, materials.len());
        self.predictions.clear();
        self.predictions.resize(self.pixels.len(), Prediction::default());
        let count = options.samples as usize;
        self.paths.clear();
        self.paths.resize(if options.keep_paths { self.pixels.len() * count } else { 0 }, Path::default());
        let per_batch = (LANES / count).max(1);
        let mut predictions = self.predictions.as_mut_slice();
        let mut paths = self.paths.as_mut_slice();
        let mut jobs = Vec::new();
        for (material, group) in groups.into_iter().enumerate() {
            for first in group.clone().step_by(per_batch) {
                let points = first..(first + per_batch).min(group.end);
                let (mine, rest) = predictions.split_at_mut(points.len());
                predictions = rest;
                let (my_paths, rest) = paths.split_at_mut(if options.keep_paths { points.len() * count } else { 0 });
                paths = rest;
                jobs.push((material, &self.pixels[points], mine, my_paths));
            }
        }
        jobs.into_par_iter().with_min_len(8).for_each_init(
            || (Batch::default(), Vec::new()),
            |(batch, requests), (material, pixels, predictions, paths)| {
                let pass = Pass { gbuffer, material: &materials[material], light, light_bandwidth, options };
                pass.predict(batch, requests, pixels, predictions, paths);
            },
        );
        self.average_neighbours(gbuffer);
    }

    /// Replaces mean and variance of each point by their means over those of the tiles around of the same material. Sixteen samples
    /// say little of a variance, and the reflection of a lamp may pass between two points. Bandwidths stay: they are means
    /// already, and follow edges.
    fn average_neighbours(&mut self, gbuffer: &GBuffer) {
        let (width, height) = (gbuffer.width, gbuffer.height);
        let averaged = |(point, &pixel): (usize, &u32)| {
            let (pixel, own) = (pixel as usize, self.predictions[point]);
            let (mut mean, mut variance, mut count) = (0.0, 0.0, 0.0);
            for y in around(pixel / width, height) {
                for x in around(pixel % width, width) {
                    let other = y * width + x;
                    if gbuffer.material[other] == gbuffer.material[pixel] {
                        let near = &self.predictions[self.of_pixel[other] as usize];
                        mean += near.mean;
                        variance += near.variance;
                        count += 1.0;
                    }
                }
            }
            Prediction { mean: mean / count, variance: variance / count, ..own }
        };
        self.predictions = self.pixels.par_iter().enumerate().with_min_len(256).map(averaged).collect();
    }

    /// Finds the points: per tile and material present the pixel nearest to the tile's centre. Returns the points of each
    /// material.
    fn place(&mut self, gbuffer: &GBuffer, materials: usize) -> Vec<Range<usize>> {
        let (width, height) = (gbuffer.width, gbuffer.height);
        let rows: Vec<Vec<(u16, u32)>> = (0..height.div_ceil(TILE))
            .into_par_iter()
            .map(|row| {
                let mut found = Vec::new();
                for column in 0..width.div_ceil(TILE) {
                    points_of_tile(gbuffer, row * TILE, column * TILE, &mut found);
                }
                found
            })
            .collect();
        let mut groups = vec![0..0; materials];
        let mut first = 0;
        self.pixels.clear();
        for (material, group) in groups.iter_mut().enumerate() {
            let of_material = |&&(of, _): &&(u16, u32)| usize::from(of) == material;
            self.pixels.extend(rows.iter().flatten().filter(of_material).map(|&(_, pixel)| pixel));
            *group = first..self.pixels.len();
            first = self.pixels.len();
        }
        self.spread(gbuffer);
        groups
    }

    /// Tells every pixel its point.
    fn spread(&mut self, gbuffer: &GBuffer) {
        let width = gbuffer.width;
        self.of_pixel.clear();
        self.of_pixel.resize(gbuffer.material.len(), NONE);
        for (point, &pixel) in self.pixels.iter().enumerate() {
            let (x, y) = (pixel as usize % width, pixel as usize / width);
            for row in tile_range(y, gbuffer.height) {
                for column in tile_range(x, width) {
                    let other = row * width + column;
                    if gbuffer.material[other] == gbuffer.material[pixel as usize] {
                        self.of_pixel[other] = point as u32;
                    }
                }
            }
        }
    }
}

/// Places along one axis in the tile of a pixel and in both tiles beside it, where they exist.
fn around(at: usize, end: usize) -> impl Iterator<Item = usize> {
    [at.checked_sub(TILE), Some(at), Some(at + TILE)].into_iter().flatten().filter(move |&place| place < end)
}

/// The pixels along one axis of the tile that a pixel lies in.
fn tile_range(at: usize, end: usize) -> Range<usize> {
    let first = at / TILE * TILE;
    first..(first + TILE).min(end)
}

/// Adds, for each material in the tile, the pixel that is nearest to the tile's centre, the first in row order on a tie.
fn points_of_tile(gbuffer: &GBuffer, top: usize, left: usize, found: &mut Vec<(u16, u32)>) {
    let mine = found.len();
    let mut distances = [0_usize; TILE * TILE];
    for y in top..(top + TILE).min(gbuffer.height) {
        for x in left..(left + TILE).min(gbuffer.width) {
            let pixel = y * gbuffer.width + x;
            let material = gbuffer.material[pixel];
            if material == BACKGROUND {
                continue;
            }
            // twice the distance from the centre, squared
            let off = |at: usize, first: usize| (2 * (at - first)).abs_diff(TILE - 1).pow(2);
            let distance = off(x, left) + off(y, top);
            match found[mine..].iter().position(|&(of, _)| of == material) {
                Some(n) if distance < distances[n] => {
                    found[mine + n].1 = pixel as u32;
                    distances[n] = distance;
                }
                Some(_) => {}
                None => {
                    distances[found.len() - mine] = distance;
                    found.push((material, pixel as u32));
                }
            }
        }
    }
}

/// What points of one material need.
struct Pass<'a> {
    gbuffer: &'a GBuffer,
    material: &'a Material<'a>,
    light: &'a Light,
    light_bandwidth: &'a LightBandwidth,
    options: &'a PilotOptions,
}

/// Running sums over the samples of a point.
#[derive(Clone, Copy, Default)]
struct Sums {
    /// Sum and sum of squares of the contributions of either technique.
    first: [f64; 2],
    second: [f64; 2],
    bandwidth: f64,
    printed: f64,
}

impl Pass<'_> {
    fn predict(
        &self,
        batch: &mut Batch,
        requests: &mut Vec<Request>,
        pixels: &[u32],
        predictions: &mut [Prediction],
        paths: &mut [Path],
    ) {
        let count = self.options.samples;
        // more samples than a batch holds: one point, several batches
        let parts = (count as usize).div_ceil(LANES) as u32;
        let mut sums = [Sums::default(); LANES / LEAST_SAMPLES as usize];
        let sums = &mut sums[..pixels.len()];
        let counts = [count.div_ceil(2), count / 2];
        for part in 0..parts {
            requests.clear();
            requests.extend(pixels.iter().map(|&pixel| self.request(pixel, counts, part, parts)));
            batch.gather(self.material.shading.as_ref(), self.light, LookUp::Exact, requests);
            for (n, sums) in sums.iter_mut().enumerate() {
                let paths = if paths.is_empty() { &mut [] } else { &mut paths[n * count as usize..][..count as usize] };
                self.add(batch, n, &requests[n], sums, paths);
            }
        }
        for (prediction, sums) in predictions.iter_mut().zip(sums) {
            *prediction = sums.prediction(counts);
        }
    }

    fn request(&self, pixel: u32, counts: [u32; 2], part: u32, parts: u32) -> Request {
        let (x, y) = (pixel as usize % self.gbuffer.width, pixel as usize / self.gbuffer.width);
        let seed = |technique: Technique| seed([x as u32, y as u32], technique as u32, self.options.seed);
        Request {
            place: Place { normal: self.gbuffer.normal[pixel as usize], view: self.gbuffer.view[pixel as usize] },
            seeds: [seed(Technique::PilotBrdf), seed(Technique::PilotLight)],
            counts,
            taken: counts.map(|count| count * part / parts..count * (part + 1) / parts),
        }
    }

    /// Adds the samples of a request.
    fn add(&self, batch: &Batch, request: usize, of: &Request, sums: &mut Sums, paths: &mut [Path]) {
        for technique in 0..2 {
            let first = if technique == 0 { 0 } else { of.counts[0] } + of.taken[technique].start;
            for (n, lane) in batch.ranges[request][technique].clone().enumerate() {
                let at = |arrays: &[Vec<f32>; 3]| arrays.each_ref().map(|component| component[lane]);
                let arriving = luminance(at(&batch.product));
                let x = arriving * batch.weight[lane];
                if x <= 0.0 {
                    continue;
                }
                let lobe = self.material.bandwidth(at(&batch.i), at(&batch.o));
                let light = self.light_bandwidth.at(at(&batch.world).into());
                let x_wide = f64::from(x);
                sums.first[technique] += x_wide;
                sums.second[technique] += x_wide * x_wide;
                sums.bandwidth += x_wide * f64::from(lobe.min(light));
                let bound = (light.min(PRINTED_LARGEST) + lobe) * arriving * arriving / batch.density[lane];
                sums.printed += f64::from(bound);
                if let Some(path) = paths.get_mut(first as usize + n) {
                    *path = Path { contribution: x, light, lobe, cos_theta_i: batch.i[2][lane] };
                }
            }
        }
    }
}

impl Sums {
    /// Mean, variance and bandwidth. The variance is that of one sample: the number of samples times the variance of their
    /// estimate, in which the sums of both techniques are independent. Stratified points make it too high, up to
    /// `n_k / (n_k - 1)` times.
    fn prediction(&self, counts: [u32; 2]) -> Prediction {
        let mean: f64 = self.first.iter().sum();
        let of_technique = |k: usize| {
            let n = f64::from(counts[k]);
            let spread = (self.second[k] - self.first[k] * self.first[k] / n).max(0.0);
            n / (n - 1.0).max(1.0) * spread
        };
        let samples = f64::from(counts[0] + counts[1]);
        Prediction {
            bandwidth: if mean > 0.0 { (self.bandwidth / mean) as f32 } else { 0.0 },
            mean: mean as f32,
            variance: (samples * (of_technique(0) + of_technique(1))) as f32,
            printed: self.printed as f32,
        }
    }
}
