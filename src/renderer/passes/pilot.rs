//! The pilot: a few samples per tile of 4 x 4 pixels, from which bandwidth, mean and variance of the integrand are predicted.

use rayon::prelude::*;

use crate::geometry::gbuffer::GBuffer;
use crate::geometry::sobol::seed;
use crate::images::exposure::luminance;
use crate::lights::bandwidth::LightBandwidth;
use crate::lights::octahedral_light::Light;
use crate::passes::direct_lighting::{Batch, LANES, LookUp, Place, Request, Technique};
use crate::passes::material::ShadingMaterial;
use crate::passes::pass::Pass;
use crate::passes::pilot_points::{PilotPoints, TILE};

/// What the published bound of variance takes for the bandwidth of the light where that is infinite, cycles per radian.
const PUBLISHED_LARGEST: f32 = 100.0;
/// Fewest samples of a point: two of either technique have a variance.
pub(crate) const LEAST_SAMPLES: u32 = 4;

/// What the samples of one pilot point say, with a texture of 1.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Prediction {
    /// Angular bandwidth of what leaves the surface towards the eye, cycles per radian: the mean over the samples, weighted by
    /// their contribution, of the smaller of the bandwidths of light and lobe (Bagher et al. 2013, equation 5).
    pub(crate) bandwidth: f32,
    /// Luminance: the estimate of the pilot.
    pub(crate) mean: f32,
    /// Variance of one sample of the luminance.
    pub(crate) variance: f32,
    /// The published bound of the variance (Bagher et al. 2013, equation 9 without the factor), for comparison.
    pub(crate) published: f32,
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
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Pilot {
    /// Where samples are taken.
    pub(crate) points: PilotPoints,
    /// One per point.
    pub(crate) predictions: Vec<Prediction>,
    /// The paths of each point one after the other, where they were asked for.
    pub(crate) paths: Vec<Path>,
    /// Samples that were taken.
    pub(crate) samples: u64,
}

impl Pilot {
    /// The prediction at a pixel; `None` in the background and without a frame.
    pub(crate) fn at(&self, pixel: usize) -> Option<&Prediction> {
        self.predictions.get(*self.points.of_pixel.get(pixel)? as usize)
    }
}

/// Chooses the points and takes their samples.
pub(crate) struct PilotPass<'a> {
    pub(crate) gbuffer: &'a GBuffer,
    pub(crate) materials: &'a [ShadingMaterial<'a>],
    pub(crate) light: &'a Light,
    pub(crate) light_bandwidth: &'a LightBandwidth,
    /// Samples per point, at least [`LEAST_SAMPLES`].
    pub(crate) samples: u32,
    pub(crate) seed: u32,
    /// Whether paths are kept.
    pub(crate) keep_paths: bool,
}

impl Pass for PilotPass<'_> {
    type Output = Pilot;

    fn run(&self, pilot: &mut Pilot) {
        let groups = pilot.points.place(self.gbuffer, self.materials.len());
        let points = pilot.points.pixels.len();
        pilot.samples = points as u64 * u64::from(self.samples);
        pilot.predictions.clear();
        pilot.predictions.resize(points, Prediction::default());
        let count = self.samples as usize;
        let kept = if self.keep_paths { count } else { 0 };
        pilot.paths.clear();
        pilot.paths.resize(points * kept, Path::default());
        let per_batch = (LANES / count).max(1);
        let mut predictions = pilot.predictions.as_mut_slice();
        let mut paths = pilot.paths.as_mut_slice();
        let mut jobs = Vec::new();
        for (material, group) in groups.into_iter().enumerate() {
            for first in group.clone().step_by(per_batch) {
                let points = first..(first + per_batch).min(group.end);
                let (mine, rest) = predictions.split_at_mut(points.len());
                predictions = rest;
                let (my_paths, rest) = paths.split_at_mut(points.len() * kept);
                paths = rest;
                jobs.push((material, &pilot.points.pixels[points], mine, my_paths));
            }
        }
        jobs.into_par_iter().with_min_len(8).for_each_init(
            || (Batch::default(), Vec::new()),
            |(batch, requests), (material, pixels, predictions, paths)| {
                let sampler = PointSampler { pass: self, material: &self.materials[material] };
                sampler.predict(batch, requests, pixels, predictions, paths);
            },
        );
        pilot.average_neighbours(self.gbuffer);
    }
}

impl Pilot {
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
                        let near = &self.predictions[self.points.of_pixel[other] as usize];
                        mean += near.mean;
                        variance += near.variance;
                        count += 1.0;
                    }
                }
            }
            Prediction { mean: mean / count, variance: variance / count, ..own }
        };
        self.predictions = self.points.pixels.par_iter().enumerate().with_min_len(256).map(averaged).collect();
    }
}

/// Places along one axis in the tile of a pixel and in both tiles beside it, where they exist.
fn around(at: usize, end: usize) -> impl Iterator<Item = usize> {
    [at.checked_sub(TILE), Some(at), Some(at + TILE)].into_iter().flatten().filter(move |&place| place < end)
}

/// Takes the samples of points of one material.
struct PointSampler<'a> {
    pass: &'a PilotPass<'a>,
    material: &'a ShadingMaterial<'a>,
}

/// Running sums over the samples of a point.
#[derive(Clone, Copy, Default)]
struct Sums {
    /// Sum and sum of squares of the contributions of either technique.
    first: [f64; 2],
    second: [f64; 2],
    bandwidth: f64,
    published: f64,
}

impl PointSampler<'_> {
    fn predict(
        &self,
        batch: &mut Batch,
        requests: &mut Vec<Request>,
        pixels: &[u32],
        predictions: &mut [Prediction],
        paths: &mut [Path],
    ) {
        let count = self.pass.samples;
        // more samples than a batch holds: one point, several batches
        let parts = (count as usize).div_ceil(LANES) as u32;
        let mut sums = [Sums::default(); LANES / LEAST_SAMPLES as usize];
        let sums = &mut sums[..pixels.len()];
        let counts = [count.div_ceil(2), count / 2];
        for part in 0..parts {
            requests.clear();
            requests.extend(pixels.iter().map(|&pixel| self.request(pixel, counts, part, parts)));
            batch.gather(self.material.shading.as_ref(), self.pass.light, LookUp::Exact, requests);
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
        let (x, y) = (pixel as usize % self.pass.gbuffer.width, pixel as usize / self.pass.gbuffer.width);
        let seed = |technique: Technique| seed([x as u32, y as u32], technique as u32, self.pass.seed);
        Request {
            place: Place {
                normal: self.pass.gbuffer.normal[pixel as usize],
                view: self.pass.gbuffer.view[pixel as usize],
            },
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
                let light = self.pass.light_bandwidth.at(at(&batch.world).into());
                let x_wide = f64::from(x);
                sums.first[technique] += x_wide;
                sums.second[technique] += x_wide * x_wide;
                sums.bandwidth += x_wide * f64::from(lobe.min(light));
                let bound = (light.min(PUBLISHED_LARGEST) + lobe) * arriving * arriving / batch.density[lane];
                sums.published += f64::from(bound);
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
            published: self.published as f32,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use brdfit_brdf::{GgxBrdf, Lambert};

    use crate::lights::procedural::Procedural;
    use crate::passes::material::{Bandwidth, Material};
    use crate::test_scenes::plane;

    fn predicted(light: &Light, material: Material<'_>, samples: u32) -> Pilot {
        let gbuffer = plane(64, 64, 1.0);
        let pass = PilotPass {
            gbuffer: &gbuffer,
            materials: &[ShadingMaterial::new(&material)],
            light,
            light_bandwidth: &LightBandwidth::new(light),
            samples,
            seed: 5,
            keep_paths: false,
        };
        let mut pilot = Pilot::default();
        pass.run(&mut pilot);
        pilot
    }

    #[test]
    fn without_a_frame_there_is_no_prediction() {
        assert_eq!(Pilot::default().at(0), None);
    }

    /// A diffuse plane under radiance 1: with densities z/pi and 1/(4 pi) of the cosine z the contribution of a sample is
    /// `x(z) = albedo z / (n_1 z + n_2 / 4)`, and the moments of either technique are integrals over z: `2 z dz` and `dz / 2`.
    #[test]
    fn mean_and_variance_are_those_of_independent_samples() {
        let chalk = Lambert { albedo: [0.6; 3] };
        let light = Procedural::Uniform.light(64);
        for samples in [16_u32, 64] {
            let (n_1, n_2) = (f64::from(samples.div_ceil(2)), f64::from(samples / 2));
            let contribution = |z: f64| 0.6 * z / (n_1 * z + n_2 / 4.0);
            let moment = |power: i32, weight: &dyn Fn(f64) -> f64| {
                let steps = 100_000;
                let at = |n: i32| (f64::from(n) + 0.5) / f64::from(steps);
                (0..steps).map(|n| weight(at(n)) * contribution(at(n)).powi(power)).sum::<f64>() / f64::from(steps)
            };
            let variance = |weight: &dyn Fn(f64) -> f64| moment(2, weight) - moment(1, weight).powi(2);
            let (brdf, sphere) = (|z: f64| 2.0 * z, |_: f64| 0.5);
            let exact = f64::from(samples) * (n_1 * variance(&brdf) + n_2 * variance(&sphere));

            let pilot = predicted(&light, Material::diffuse(&chalk), samples);
            let mean_over = |of: fn(&Prediction) -> f32| {
                pilot.predictions.iter().map(|prediction| f64::from(of(prediction))).sum::<f64>() / 256.0
            };
            assert_eq!((pilot.predictions.len(), pilot.samples), (256, 256 * u64::from(samples)));
            let (mean, predicted) = (mean_over(|p| p.mean), mean_over(|p| p.variance));
            assert!((mean / 0.6 - 1.0).abs() < 2e-3, "{mean}");
            // stratified points: up to n_k / (n_k - 1) too high
            let most = n_1 / (n_1 - 1.0);
            println!("{samples} samples: predicted variance {predicted:.4}, exact {exact:.4}");
            assert!((0.98..=1.02 * most).contains(&(predicted / exact)), "{samples}: {predicted} {exact}");
        }
    }

    #[test]
    fn the_bandwidth_is_limited_by_that_of_the_lobe() {
        let light = Procedural::Studio.light(128);
        let glossy = GgxBrdf { rho_d: [0.0; 3], rho_s: [0.5; 3], m: 0.3 };
        let chalk = Lambert { albedo: [0.6; 3] };
        let nu = |material| predicted(&light, material, 16).predictions.into_iter().map(|p| p.bandwidth);
        assert!(nu(Material::diffuse(&chalk)).all(|nu| nu == 0.0));
        let limited: Vec<f32> = nu(Material::new(&glossy, Bandwidth::Constant(0.7))).collect();
        assert!(limited.iter().all(|&nu| nu <= 0.7 * (1.0 + 1e-6)) && limited.iter().any(|&nu| nu > 0.3));
    }
}
