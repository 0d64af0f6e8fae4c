//! Light gathered at points by the two techniques, many samples side by side: draws, values, densities, contributions.
//!
//! Samples of several points of one material share a batch, so that few samples per point fill the lanes too. Nothing is
//! allocated per sample or per point: a [`Batch`] belongs to a thread and is used again.

use std::ops::Range;

use brdfit_brdf::Shading;

use crate::Vec3;
use crate::geometry::grazing::LEAST_COSINE;
use crate::geometry::sobol;
use crate::lights::octahedral_light::Light;

/// Samples of a batch: what they hold stays in the first cache level.
pub(crate) const LANES: usize = 256;

/// What points of the unit square are for: each has a sequence of its own at every pixel. The pilot's differ from those of
/// shading, or counts would depend on the values that they are for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u32)]
pub(crate) enum Technique {
    /// Directions from the BRDF.
    Brdf,
    /// Directions from the light.
    Light,
    /// The same for the pilot.
    PilotBrdf,
    PilotLight,
}

/// A point that gathers light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Place {
    /// Unit normal.
    pub(crate) normal: Vec3,
    /// Unit vector to the eye.
    pub(crate) view: Vec3,
}

/// Samples at a place: a part of all that it takes, as many as fit into a batch.
#[derive(Clone, Debug)]
pub(crate) struct Request {
    pub(crate) place: Place,
    /// Seeds of the points for both techniques, BRDF and light.
    pub(crate) seeds: [u32; 2],
    /// Samples of both techniques at this place in all.
    pub(crate) counts: [u32; 2],
    /// Those that this batch takes.
    pub(crate) taken: [Range<u32>; 2],
}

/// How the light is looked up.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum LookUp {
    /// As it is: the estimate is unbiased.
    Exact,
    /// At the mip level whose texel covers what one of the BRDF samples stands for (filtered importance sampling).
    Filtered,
}

/// Samples side by side, one array per quantity; local vectors have the normal as z.
#[derive(Debug)]
pub(crate) struct Batch {
    /// Where the lanes of each request lie, BRDF and light.
    pub(crate) ranges: Vec<[Range<usize>; 2]>,
    /// Local directions to the eye and to the light, world directions to the light.
    pub(crate) o: [Vec<f32>; 3],
    pub(crate) i: [Vec<f32>; 3],
    pub(crate) world: [Vec<f32>; 3],
    /// BRDF, 1/sr, times radiance of the light.
    pub(crate) product: [Vec<f32>; 3],
    /// `cos theta_i / (n_1 p_brdf + n_2 p_light)`: the contribution of a sample is this times [`Self::product`].
    pub(crate) weight: Vec<f32>,
    /// `n_1 p_brdf + n_2 p_light`, 1/sr: the density of all samples of the place together.
    pub(crate) density: Vec<f32>,
    u: [Vec<f32>; 2],
    radiance: [Vec<f32>; 3],
    light_density: Vec<f32>,
    footprint: Vec<f32>,
    counts: [Vec<f32>; 2],
    frames: Vec<Frame>,
}

impl Default for Batch {
    fn default() -> Self {
        let three = || [0; 3].map(|_| vec![0.0; LANES]);
        let two = || [0; 2].map(|_| vec![0.0; LANES]);
        let one = || vec![0.0; LANES];
        Self {
            ranges: Vec::with_capacity(LANES),
            o: three(),
            i: three(),
            world: three(),
            product: three(),
            weight: one(),
            density: one(),
            u: two(),
            radiance: three(),
            light_density: one(),
            footprint: one(),
            counts: two(),
            frames: Vec::with_capacity(LANES),
        }
    }
}

impl Batch {
    /// Takes the samples of all requests, which together are [`LANES`] at most.
    pub(crate) fn gather(&mut self, shading: &dyn Shading, light: &Light, look_up: LookUp, requests: &[Request]) {
        let [drawn, total] = self.lay_out(requests);
        self.prepare(requests);
        {
            let [u0, u1] = self.u.each_ref().map(|u| &u[..drawn]);
            shading.sample(part(&self.o, 0..drawn), [u0, u1], part_mut(&mut self.i, 0..drawn));
            let [u0, u1] = self.u.each_ref().map(|u| &u[drawn..total]);
            light.sample_many([u0, u1], part_mut(&mut self.world, drawn..total));
        }
        for (frame, ranges) in self.frames.iter().zip(&self.ranges) {
            let [brdf, light] = ranges.clone();
            frame.to_world(part(&self.i, brdf.clone()), part_mut(&mut self.world, brdf));
            frame.to_local(part(&self.world, light.clone()), part_mut(&mut self.i, light));
        }
        let all = 0..total;
        shading.evaluate(
            part(&self.i, all.clone()),
            part(&self.o, all.clone()),
            part_mut(&mut self.product, all.clone()),
            &mut self.density[all.clone()],
        );
        match look_up {
            LookUp::Exact => light.evaluate_many(
                part(&self.world, all.clone()),
                part_mut(&mut self.radiance, all.clone()),
                &mut self.light_density[all],
            ),
            LookUp::Filtered => {
                for lane in all.clone() {
                    // one level more than covers the share: texels are squares, shares are not
                    self.footprint[lane] = 2.0 / (self.counts[0][lane] * self.density[lane]).max(f32::MIN_POSITIVE);
                    self.light_density[lane] = 0.0;
                }
                light.prefiltered_many(
                    part(&self.world, all.clone()),
                    &self.footprint[all.clone()],
                    part_mut(&mut self.radiance, all),
                );
            }
        }
        self.weigh(total);
    }

    /// Gives every request its lanes, those of the BRDF first; the number of those, and of all.
    fn lay_out(&mut self, requests: &[Request]) -> [usize; 2] {
        let taken = |request: &Request, technique: usize| request.taken[technique].len();
        let drawn = requests.iter().map(|request| taken(request, 0)).sum();
        let mut next = [0, drawn];
        self.ranges.clear();
        self.ranges.extend(requests.iter().map(|request| {
            [0, 1].map(|technique| {
                let first = next[technique];
                next[technique] += taken(request, technique);
                first..next[technique]
            })
        }));
        assert!(next[1] <= LANES, "{} samples do not fit into a batch", next[1]);
        [drawn, next[1]]
    }

    /// Points, directions to the eye and counts of every lane.
    fn prepare(&mut self, requests: &[Request]) {
        self.frames.clear();
        for (request, ranges) in requests.iter().zip(&self.ranges) {
            let frame = Frame::new(request.place.normal);
            let o = frame.towards_eye(&request.place.view);
            for (technique, range) in ranges.iter().enumerate() {
                let [u0, u1] = self.u.each_mut().map(|u| &mut u[range.clone()]);
                sobol::fill(request.seeds[technique], request.taken[technique].start, [u0, u1]);
                for (component, value) in self.o.iter_mut().zip(o) {
                    component[range.clone()].fill(value);
                }
                for (counts, count) in self.counts.iter_mut().zip(request.counts) {
                    counts[range.clone()].fill(count as f32);
                }
            }
            self.frames.push(frame);
        }
    }

    /// From values and densities to weights.
    fn weigh(&mut self, total: usize) {
        let [n_1, n_2] = self.counts.each_ref().map(|counts| &counts[..total]);
        let (density, light_density) = (&mut self.density[..total], &self.light_density[..total]);
        for lane in 0..total {
            density[lane] = n_1[lane] * density[lane] + n_2[lane] * light_density[lane];
        }
        let (weight, cos) = (&mut self.weight[..total], &self.i[2][..total]);
        for lane in 0..total {
            let inverse = 1.0 / density[lane].max(f32::MIN_POSITIVE);
            weight[lane] = if cos[lane] > 0.0 && density[lane] > 0.0 { cos[lane] * inverse } else { 0.0 };
        }
        for (product, radiance) in self.product.iter_mut().zip(&self.radiance) {
            for (product, radiance) in product[..total].iter_mut().zip(&radiance[..total]) {
                *product *= radiance;
            }
        }
    }

    /// Sum of the contributions of a request, per channel.
    pub(crate) fn sum(&self, request: usize) -> [f32; 3] {
        let mut sum = [0.0; 3];
        for range in &self.ranges[request] {
            let weight = &self.weight[range.clone()];
            for (sum, product) in sum.iter_mut().zip(&self.product) {
                *sum +=
                    product[range.clone()].iter().zip(weight).map(|(product, weight)| product * weight).sum::<f32>();
            }
        }
        sum
    }
}

/// Tangent, bitangent and normal (Duff et al. 2017).
#[derive(Clone, Copy, Debug)]
struct Frame([Vec3; 3]);

impl Frame {
    fn new(n: Vec3) -> Self {
        let sign = 1.0_f32.copysign(n.z);
        let a = -1.0 / (sign + n.z);
        let b = n.x * n.y * a;
        Self([
            Vec3::new(1.0 + sign * n.x * n.x * a, sign * b, -sign * n.x),
            Vec3::new(b, sign + n.y * n.y * a, -n.y),
            n,
        ])
    }

    /// Local direction to the eye; a cosine below [`LEAST_COSINE`] is taken as that.
    fn towards_eye(&self, view: &Vec3) -> [f32; 3] {
        let [t, b, n] = &self.0;
        let o = Vec3::new(t.dot(view), b.dot(view), n.dot(view).max(LEAST_COSINE));
        (o / o.norm()).into()
    }

    fn to_world(self, local: [&[f32]; 3], world: [&mut [f32]; 3]) {
        let [t, b, n] = self.0;
        turn([[t.x, b.x, n.x], [t.y, b.y, n.y], [t.z, b.z, n.z]], local, world);
    }

    fn to_local(self, world: [&[f32]; 3], local: [&mut [f32]; 3]) {
        turn(self.0.map(Into::into), world, local);
    }
}

/// The products of a matrix, given by its rows, with vectors.
fn turn(rows: [[f32; 3]; 3], from: [&[f32]; 3], to: [&mut [f32]; 3]) {
    let [x, y, z] = from;
    for ([a, b, c], to) in rows.into_iter().zip(to) {
        let (x, y, z) = (&x[..to.len()], &y[..to.len()], &z[..to.len()]);
        for lane in 0..to.len() {
            to[lane] = a * x[lane] + b * y[lane] + c * z[lane];
        }
    }
}

fn part(arrays: &[Vec<f32>; 3], range: Range<usize>) -> [&[f32]; 3] {
    arrays.each_ref().map(|array| &array[range.clone()])
}

fn part_mut(arrays: &mut [Vec<f32>; 3], range: Range<usize>) -> [&mut [f32]; 3] {
    arrays.each_mut().map(|array| &mut array[range.clone()])
}
