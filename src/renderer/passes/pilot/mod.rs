//! The pilot: a few samples per tile of 4 x 4 pixels, from which bandwidth, mean and variance of the integrand are predicted.

pub(crate) mod points;

use rayon::prelude::*;

use crate::geometry::gbuffer::GBuffer;
use crate::images::exposure::luminance;
use crate::lights::light_set::{LightSet, LookUp};
use crate::passes::direct_lighting::{Batch, Gathering, LANES, Place, Reflected, Request, Stage};
use crate::passes::material::ShadingMaterial;
use crate::passes::pass::Pass;
use crate::passes::pilot::points::{PilotPoints, TILE};

/// Bandwidth of the light in the published bound of the variance where the true one is infinite, cycles per radian.
const PUBLISHED_LARGEST: f32 = 100.0;
/// Fewest samples of a point: two of the BRDF and two of a light have a variance.
pub(crate) const LEAST_SAMPLES: u32 = 4;
/// Fewest samples of a light, for the same reason.
const LEAST_PER_LIGHT: u32 = 2;
/// Bandwidth of `cos theta_i` times what the geometry between a surface and a near light makes of its radiance, cycles per radian of
/// the direction to the light. The kernel that all planar lights share, `d^2 / (pi (d^2 + x^2)^2)` at the distance d, has 95 %
/// of its energy below `0.4636 / d` cycles per world unit, which the estimator of the atlas would read as 0.65 to 0.87; the rest is a margin.
pub(crate) const GEOMETRY_BANDWIDTH: f32 = 1.0;
/// Factor of the bandwidth of near lights, a margin of one level: interpolation needs more than Nyquist's rate.
pub(crate) const NEAR_MARGIN: f32 = 2.0;

/// Estimates of one pilot point, with a texture of 1.
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
    /// Of near lights: bandwidth over the position of the surface, cycles per world unit, because the direction to the light follows
    /// it. 0 under distant light.
    pub(crate) by_position: f32,
    /// Of near lights: bandwidth over the direction of the normal, cycles per radian. 0 under distant light.
    pub(crate) by_normal: f32,
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
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Pilot {
    /// The pilot points.
    pub(crate) points: PilotPoints,
    /// One per point.
    pub(crate) predictions: Vec<Prediction>,
    /// The paths of each point one after the other, where they were asked for: of each sample one per light.
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
    pub(crate) lights: &'a LightSet,
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
        pilot.predictions.clear();
        pilot.predictions.resize(points, Prediction::default());
        let samplers: Vec<PointSampler<'_>> =
            self.materials.iter().map(|material| PointSampler { pass: self, material }).collect();
        let count = samplers.first().map_or(0, |sampler| sampler.gathering().total(self.samples)) as usize;
        pilot.samples = points as u64 * count as u64;
        let kept = if self.keep_paths { count * (self.lights.techniques() - 1) } else { 0 };
        pilot.paths.clear();
        pilot.paths.resize(points * kept, Path::default());
        let per_batch = (LANES / count.max(1)).max(1);
        let mut predictions = pilot.predictions.as_mut_slice();
        let mut paths = pilot.paths.as_mut_slice();
        let mut jobs = Vec::new();
        for (sampler, group) in samplers.iter().zip(groups) {
            for first in group.clone().step_by(per_batch) {
                let points = first..(first + per_batch).min(group.end);
                let (mine, rest) = predictions.split_at_mut(points.len());
                predictions = rest;
                let (my_paths, rest) = paths.split_at_mut(points.len() * kept);
                paths = rest;
                jobs.push((sampler, &pilot.points.pixels[points], mine, my_paths));
            }
        }
        jobs.into_par_iter().with_min_len(8).for_each_init(
            || (Batch::default(), Vec::new(), Sums::default()),
            |(batch, requests, sums), (sampler, pixels, predictions, paths)| {
                sampler.predict(batch, requests, sums, pixels, predictions, paths);
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
    published: f64,
    by_position: f64,
    by_normal: f64,
}

impl PointSampler<'_> {
    fn gathering(&self) -> Gathering<'_> {
        Gathering {
            shading: self.material.shading.as_ref(),
            lights: self.pass.lights,
            look_up: LookUp::Exact,
            stage: Stage::Pilot,
            seed: self.pass.seed,
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
        let techniques = self.pass.lights.techniques();
        let samples = self.pass.samples;
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
            batch.look_up_bandwidths(self.pass.lights);
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
        let (gbuffer, n) = (self.pass.gbuffer, pixel as usize);
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
        let lights = self.pass.lights.techniques() - 1;
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
        self.published += f64::from((bandwidth.min(PUBLISHED_LARGEST) + lobe) * arriving * arriving / density);
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
            published: self.published as f32,
            by_position: share(self.by_position),
            by_normal: share(self.by_normal),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use brdfit_brdf::{GgxMaterial, Lambert};

    use crate::lights::octahedral::light::Light;
    use crate::lights::procedural::Procedural;
    use crate::passes::material::{Bandwidth, Material};
    use crate::test_scenes::plane;

    fn predicted(light: Light, material: Material<'_>, samples: u32) -> Pilot {
        let gbuffer = plane(64, 64, 1.0);
        let pass = PilotPass {
            gbuffer: &gbuffer,
            materials: &[ShadingMaterial::new(&material)],
            lights: &LightSet::from(light),
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

            let pilot = predicted(light.clone(), Material::diffuse(&chalk), samples);
            let mean_over = |of: fn(&Prediction) -> f32| {
                pilot.predictions.iter().map(|prediction| f64::from(of(prediction))).sum::<f64>() / 256.0
            };
            assert_eq!((pilot.predictions.len(), pilot.samples), (256, 256 * u64::from(samples)));
            let (mean, predicted) = (mean_over(|p| p.mean), mean_over(|p| p.variance));
            let sigma = (exact / f64::from(256 * samples)).sqrt();
            assert!((mean - 0.6).abs() < 4.0 * sigma, "{mean}, {sigma}");
            // stratified points: up to n_k / (n_k - 1) too high; a tenth for the noise of 256 points
            let most = n_1 / (n_1 - 1.0);
            println!("{samples} samples: predicted variance {predicted:.4}, exact {exact:.4}");
            assert!((0.9..=1.1 * most).contains(&(predicted / exact)), "{samples}: {predicted} {exact}");
        }
    }

    #[test]
    fn the_bandwidth_is_limited_by_that_of_the_lobe() {
        let light = Procedural::Studio.light(128);
        let glossy = GgxMaterial::without_fresnel([0.0; 3], [0.5; 3], 0.3).unwrap();
        let chalk = Lambert { albedo: [0.6; 3] };
        let nu = |material| predicted(light.clone(), material, 16).predictions.into_iter().map(|p| p.bandwidth);
        assert!(nu(Material::diffuse(&chalk)).all(|nu| nu == 0.0));
        let limited: Vec<f32> = nu(Material::new(&glossy, Bandwidth::Constant(0.7))).collect();
        assert!(limited.iter().all(|&nu| nu <= 0.7 * (1.0 + 1e-6)) && limited.iter().any(|&nu| nu > 0.3));
    }
}
