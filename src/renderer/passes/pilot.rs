//! The pilot: a few samples per tile of 4 x 4 pixels, from which bandwidth, mean and variance of the integrand are predicted.

use std::ops::Range;

use rayon::prelude::*;

use crate::geometry::gbuffer::{BACKGROUND, GBuffer};
use crate::images::exposure::luminance;
use crate::lights::light_set::{LightSet, LookUp};
use crate::passes::direct_lighting::{Batch, Gathering, LANES, Place, Reflected, Request, Stage};
use crate::passes::material::Material;

/// Pixels along the side of a tile.
pub const TILE: usize = 4;
/// What the printed estimate of variance takes for the bandwidth of the light where that is infinite, cycles per radian.
const PRINTED_LARGEST: f32 = 100.0;
/// Fewest samples of a point: two of the BRDF and two of a light have a variance.
pub const LEAST_SAMPLES: u32 = 4;
/// Fewest samples of a light, for the same reason.
const LEAST_PER_LIGHT: u32 = 2;
/// Bandwidth of `cos theta_i` times what the geometry between a surface and a near light makes of its radiance, cycles per radian of
/// the direction to the light. The kernel that all planar lights share, `d^2 / (pi (d^2 + x^2)^2)` at the distance d, has 95 %
/// of its energy below `0.4636 / d` cycles per world unit, which the estimator of the atlas would read as 0.65 to 0.87; the rest is a margin.
pub(crate) const GEOMETRY_BANDWIDTH: f32 = 1.0;
/// Factor of the bandwidth of near lights, a margin of one level: interpolation needs more than Nyquist's rate.
pub(crate) const NEAR_MARGIN: f32 = 2.0;
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
    /// Of near lights: bandwidth over the position of the surface, cycles per world unit, because the direction to the light follows
    /// it. 0 under distant light.
    pub by_position: f32,
    /// Of near lights: bandwidth over the direction of the normal, cycles per radian. 0 under distant light.
    pub by_normal: f32,
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
    /// To the light, world units.
    pub(crate) distance: f32,
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
    /// The paths of each point one after the other, where they were asked for: of each sample one per light.
    pub(crate) paths: Vec<Path>,
    /// Samples of all points.
    samples: u64,
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
    pub(crate) fn samples(&self) -> u64 {
        self.samples
    }

    /// Chooses the points and takes their samples.
    pub(crate) fn compute(
        &mut self,
        gbuffer: &GBuffer,
        materials: &[Material<'_>],
        lights: &LightSet,
        options: &PilotOptions,
    ) {
        let groups = self.place(gbuffer, materials.len());
        self.predictions.clear();
        self.predictions.resize(self.pixels.len(), Prediction::default());
        let passes: Vec<Pass<'_>> =
            materials.iter().map(|material| Pass { gbuffer, material, lights, options }).collect();
        let count = passes.first().map_or(0, |pass| pass.gathering().total(options.samples)) as usize;
        self.samples = self.pixels.len() as u64 * count as u64;
        let kept = if options.keep_paths { count * (lights.techniques() - 1) } else { 0 };
        self.paths.clear();
        self.paths.resize(self.pixels.len() * kept, Path::default());
        let per_batch = (LANES / count.max(1)).max(1);
        let mut predictions = self.predictions.as_mut_slice();
        let mut paths = self.paths.as_mut_slice();
        let mut jobs = Vec::new();
        for (pass, group) in passes.iter().zip(groups) {
            for first in group.clone().step_by(per_batch) {
                let points = first..(first + per_batch).min(group.end);
                let (mine, rest) = predictions.split_at_mut(points.len());
                predictions = rest;
                let (my_paths, rest) = paths.split_at_mut(points.len() * kept);
                paths = rest;
                jobs.push((pass, &self.pixels[points], mine, my_paths));
            }
        }
        jobs.into_par_iter().with_min_len(8).for_each_init(
            || (Batch::default(), Vec::new(), Sums::default()),
            |(batch, requests, sums), (pass, pixels, predictions, paths)| {
                pass.predict(batch, requests, sums, pixels, predictions, paths);
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
    lights: &'a LightSet,
    options: &'a PilotOptions,
}

/// Running sums over the samples of some points.
#[derive(Default)]
struct Sums {
    points: Vec<PointSums>,
    /// Sum and sum of squares of the contributions, for each point and technique.
    moments: Vec<[f64; 2]>,
}

/// Running sums over the samples of a point, weighted by their contributions.
#[derive(Clone, Copy, Default)]
struct PointSums {
    bandwidth: f64,
    printed: f64,
    by_position: f64,
    by_normal: f64,
}

impl Pass<'_> {
    fn gathering(&self) -> Gathering<'_> {
        Gathering {
            shading: self.material.shading.as_ref(),
            lights: self.lights,
            look_up: LookUp::Exact,
            stage: Stage::Pilot,
            seed: self.options.seed,
            least_per_light: LEAST_PER_LIGHT,
        }
    }

    fn predict(
        &self,
        batch: &mut Batch,
        requests: &mut Vec<Request>,
        sums: &mut Sums,
        pixels: &[u32],
        predictions: &mut [Prediction],
        paths: &mut [Path],
    ) {
        let with = self.gathering();
        let techniques = self.lights.techniques();
        let samples = self.options.samples;
        let total = with.total(samples);
        sums.points.clear();
        sums.points.resize(pixels.len(), PointSums::default());
        sums.moments.clear();
        sums.moments.resize(pixels.len() * techniques, [0.0; 2]);
        // more samples than a batch holds: one point, several batches
        let mut first = 0;
        while first < total {
            let taken = first..total.min(first.saturating_add(LANES as u32));
            first = taken.end;
            requests.clear();
            requests.extend(pixels.iter().map(|&pixel| Request {
                place: self.place(pixel),
                samples,
                taken: taken.clone(),
            }));
            batch.gather(&with, requests);
            batch.look_up_bandwidths(self.lights);
            for n in 0..pixels.len() {
                let kept = paths.len() / pixels.len();
                let skipped = taken.start as usize * (techniques - 1);
                let moments = &mut sums.moments[n * techniques..][..techniques];
                let paths = paths[n * kept..][..kept].get_mut(skipped..).unwrap_or_default();
                self.add(batch, n, &mut sums.points[n], moments, paths);
            }
        }
        let counts = |technique: usize| f64::from(with.count(technique, samples));
        for ((prediction, sums), moments) in
            predictions.iter_mut().zip(&sums.points).zip(sums.moments.chunks_exact(techniques))
        {
            *prediction = sums.prediction(moments, counts);
        }
    }

    fn place(&self, pixel: u32) -> Place {
        let (gbuffer, n) = (self.gbuffer, pixel as usize);
        let (x, y) = (n % gbuffer.width, n / gbuffer.width);
        Place {
            position: gbuffer.position[n],
            normal: gbuffer.normal[n],
            view: gbuffer.view[n],
            pixel: [x as u32, y as u32],
        }
    }

    /// Adds the samples of a request.
    fn add(&self, batch: &Batch, request: usize, sums: &mut PointSums, moments: &mut [[f64; 2]], paths: &mut [Path]) {
        let lights = self.lights.techniques() - 1;
        let lanes =
            (0..moments.len()).flat_map(|technique| batch.range(request, technique).map(move |lane| (technique, lane)));
        for (n, (technique, lane)) in lanes.enumerate() {
            let at = |arrays: &[Vec<f32>; 3]| arrays.each_ref().map(|component| component[lane]);
            let weight = batch.weight[lane];
            let x = luminance(at(&batch.product)) * weight;
            if x <= 0.0 {
                continue;
            }
            let x_wide = f64::from(x);
            moments[technique][0] += x_wide;
            moments[technique][1] += x_wide * x_wide;
            let lobe = self.material.bandwidth(at(&batch.i), at(&batch.o));
            for light in 0..lights {
                let reflected = batch.arriving(light, lane);
                sums.add(&reflected, lobe, weight, batch.density[lane]);
                if let Some(path) = paths.get_mut(n * lights + light) {
                    *path = Path {
                        contribution: luminance(reflected.product) * weight,
                        light: reflected.bandwidth,
                        lobe,
                        cos_theta_i: batch.i[2][lane],
                        distance: reflected.distance,
                    };
                }
            }
        }
    }
}

impl PointSums {
    /// Adds what one sample reflects of one light.
    fn add(&mut self, reflected: &Reflected, lobe: f32, weight: f32, density: f32) {
        let Reflected { product, distance, bandwidth } = *reflected;
        let arriving = luminance(product);
        let x = f64::from(arriving * weight);
        let mirrored = f64::from(lobe.min(bandwidth));
        self.bandwidth += x * mirrored;
        self.printed += f64::from((bandwidth.min(PRINTED_LARGEST) + lobe) * arriving * arriving / density);
        if distance < f32::INFINITY {
            let geometry = f64::from(GEOMETRY_BANDWIDTH.min(bandwidth));
            let x = x * f64::from(NEAR_MARGIN);
            self.by_position += x * (mirrored + geometry) / f64::from(distance);
            self.by_normal += x * geometry;
        }
    }

    /// Mean, variance and bandwidth. The variance is that of one sample: the number of samples times the variance of their
    /// estimate, in which the sums of the techniques are independent. Stratified points make it too high, up to `n_k / (n_k - 1)`
    /// times.
    fn prediction(&self, moments: &[[f64; 2]], counts: impl Fn(usize) -> f64) -> Prediction {
        let mean: f64 = moments.iter().map(|[first, _]| first).sum();
        let (mut samples, mut variance) = (0.0, 0.0);
        for (technique, [first, second]) in moments.iter().enumerate() {
            let n = counts(technique);
            let spread = (second - first * first / n.max(1.0)).max(0.0);
            variance += n / (n - 1.0).max(1.0) * spread;
            samples += n;
        }
        let share = |sum: f64| if mean > 0.0 { (sum / mean) as f32 } else { 0.0 };
        Prediction {
            bandwidth: share(self.bandwidth),
            mean: mean as f32,
            variance: (samples * variance) as f32,
            printed: self.printed as f32,
            by_position: share(self.by_position),
            by_normal: share(self.by_normal),
        }
    }
}
