//! Light gathered at points by several techniques, many samples side by side: draws, values, densities, contributions.
//!
//! The techniques are the BRDF and each light, in this order. Every sample is weighed by the balance heuristic over all of them
//! (Veach and Guibas, "Optimally combining sampling techniques for Monte Carlo rendering", 1995): a sample of direction i
//! contributes `f L cos theta_i / sum_k n_k p_k(i)`, whoever drew it.
//!
//! Samples of several points of one material share a batch, so that few samples per point fill the lanes too. Nothing is
//! allocated per sample or per point: a [`Batch`] belongs to a thread and is used again.

use std::ops::Range;

use brdfit_brdf::BatchBrdf;

use crate::geometry::grazing::LEAST_COSINE;
use crate::geometry::sobol;
use crate::geometry::vec3::Vec3;
use crate::lights::light_set::{LightSet, LookUp, Samples};
use crate::lights::lighting::{Arriving, Receivers};

/// Samples of a batch: what they hold stays in the first cache level.
pub(crate) const LANES: usize = 256;

/// Purpose of the gathered light. The pilot's points differ from those of shading, or counts would depend on the values that they
/// are for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Stage {
    Shading,
    Pilot,
}

impl Stage {
    /// The number of the sequence of points of the unit square that a technique uses: different ones for all techniques of both stages.
    fn sequence(self, technique: usize) -> u32 {
        let (pilot, technique) = (u32::from(self == Self::Pilot), technique as u32);
        if technique < 2 { technique + 2 * pilot } else { 2 * technique + pilot }
    }
}

/// A point that gathers light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Place {
    /// Point on the surface, world units.
    pub(crate) position: Vec3,
    /// Unit normal.
    pub(crate) normal: Vec3,
    /// Unit vector to the eye.
    pub(crate) view: Vec3,
    /// Column and row of the pixel that the sequences belong to.
    pub(crate) pixel: [u32; 2],
}

/// Samples at a place: a part of all that it takes, as many as fit into a batch.
#[derive(Clone, Debug)]
pub(crate) struct Request {
    pub(crate) place: Place,
    /// Samples at this place in all, before they are divided.
    pub(crate) samples: u32,
    /// Those that this batch takes, counted through all techniques one after the other.
    pub(crate) taken: Range<u32>,
}

/// Inputs of light gathering.
#[derive(Clone, Copy)]
pub(crate) struct Gathering<'a> {
    pub(crate) shading: &'a dyn BatchBrdf,
    pub(crate) lights: &'a LightSet,
    pub(crate) look_up: LookUp,
    pub(crate) stage: Stage,
    /// The seed that the user chose.
    pub(crate) seed: u32,
    /// As in [`Samples::least_per_light`].
    pub(crate) least_per_light: u32,
}

impl Gathering<'_> {
    /// Samples of a technique, of so many in all.
    pub(crate) fn count(&self, technique: usize, total: u32) -> u32 {
        self.lights.count(technique, self.samples(total))
    }

    /// Samples of all techniques.
    pub(crate) fn total(&self, total: u32) -> u32 {
        self.lights.total(self.samples(total))
    }

    fn samples(&self, total: u32) -> Samples {
        Samples { total, look_up: self.look_up, least_per_light: self.least_per_light }
    }
}

/// Samples side by side, one array per quantity; local vectors have the normal as z.
#[derive(Debug)]
pub(crate) struct Batch {
    techniques: usize,
    /// Where the lanes of each request lie, technique by technique.
    ranges: Vec<Range<usize>>,
    /// Local directions to the eye and to the light, world directions to the light.
    pub(crate) o: [Vec<f32>; 3],
    pub(crate) i: [Vec<f32>; 3],
    world: [Vec<f32>; 3],
    /// BRDF, 1/sr.
    values: [Vec<f32>; 3],
    /// BRDF times the radiance of all lights.
    pub(crate) product: [Vec<f32>; 3],
    /// `cos theta_i / sum_k n_k p_k`: the contribution of a sample is this times [`Self::product`].
    pub(crate) weight: Vec<f32>,
    /// `sum_k n_k p_k`, 1/sr: the density of all samples of the place together.
    pub(crate) density: Vec<f32>,
    /// Incident light from each light.
    lights: Vec<FromLight>,
    position: [Vec<f32>; 3],
    u: [Vec<f32>; 2],
    footprint: Vec<f32>,
    /// Samples of each technique at the place of a lane.
    counts: Vec<Vec<f32>>,
    frames: Vec<Frame>,
}

/// Incident light from one light.
#[derive(Debug)]
struct FromLight {
    radiance: [Vec<f32>; 3],
    density: Vec<f32>,
    distance: Vec<f32>,
    bandwidth: Vec<f32>,
}

fn lanes() -> Vec<f32> {
    vec![0.0; LANES]
}

fn vectors() -> [Vec<f32>; 3] {
    [0; 3].map(|_| lanes())
}

impl FromLight {
    fn new() -> Self {
        Self { radiance: vectors(), density: lanes(), distance: lanes(), bandwidth: lanes() }
    }
}

impl Default for Batch {
    fn default() -> Self {
        Self {
            techniques: 0,
            ranges: Vec::with_capacity(2 * LANES),
            o: vectors(),
            i: vectors(),
            world: vectors(),
            values: vectors(),
            product: vectors(),
            weight: lanes(),
            density: lanes(),
            lights: Vec::new(),
            position: vectors(),
            u: [lanes(), lanes()],
            footprint: lanes(),
            counts: Vec::new(),
            frames: Vec::with_capacity(LANES),
        }
    }
}

impl Batch {
    /// Takes the samples of all requests, which together are [`LANES`] at most.
    pub(crate) fn gather(&mut self, with: &Gathering<'_>, requests: &[Request]) {
        self.techniques = with.lights.techniques();
        self.lights.resize_with(self.techniques - 1, FromLight::new);
        self.counts.resize_with(self.techniques, lanes);
        let total = self.lay_out(with, requests);
        self.prepare(with, requests);
        self.draw(with);
        with.shading.evaluate(
            part(&self.i, 0..total),
            part(&self.o, 0..total),
            part_mut(&mut self.values, 0..total),
            &mut self.density[..total],
        );
        self.look_up(with, total);
        self.weigh(total);
    }

    /// The lanes of a request that were drawn by a technique.
    pub(crate) fn range(&self, request: usize, technique: usize) -> Range<usize> {
        self.ranges[request * self.techniques + technique].clone()
    }

    /// Gives every request its lanes, the techniques one after the other; the number of all.
    fn lay_out(&mut self, with: &Gathering<'_>, requests: &[Request]) -> usize {
        self.ranges.clear();
        self.ranges.resize(requests.len() * self.techniques, 0..0);
        let mut next = 0;
        for technique in 0..self.techniques {
            for (n, request) in requests.iter().enumerate() {
                let count = taken(with, request, technique).len();
                self.ranges[n * self.techniques + technique] = next..next + count;
                next += count;
            }
        }
        assert!(next <= LANES, "{next} samples do not fit into a batch");
        next
    }

    /// The lanes of a technique, of all requests.
    fn lanes_of(&self, technique: usize) -> Range<usize> {
        let ranges = || self.ranges.iter().skip(technique).step_by(self.techniques);
        ranges().next().map_or(0, |range| range.start)..ranges().next_back().map_or(0, |range| range.end)
    }

    /// Points, directions to the eye, receivers and counts of every lane.
    fn prepare(&mut self, with: &Gathering<'_>, requests: &[Request]) {
        self.frames.clear();
        for (request, ranges) in requests.iter().zip(self.ranges.chunks_exact(self.techniques)) {
            let Place { position, normal, view, pixel } = request.place;
            let frame = Frame::new(normal);
            let o = frame.towards_eye(&view);
            for (technique, range) in ranges.iter().enumerate() {
                let [u0, u1] = self.u.each_mut().map(|u| &mut u[range.clone()]);
                let seed = sobol::seed(pixel, with.stage.sequence(technique), with.seed);
                sobol::fill(seed, taken(with, request, technique).start, [u0, u1]);
                fill(&mut self.o, range, o);
                fill(&mut self.position, range, position.into());
            }
            for (technique, counts) in self.counts.iter_mut().enumerate() {
                let count = with.count(technique, request.samples) as f32;
                ranges.iter().for_each(|range| counts[range.clone()].fill(count));
            }
            self.frames.push(frame);
        }
    }

    /// Directions, local and of the world.
    fn draw(&mut self, with: &Gathering<'_>) {
        let of_brdf = self.lanes_of(0);
        let [u0, u1] = self.u.each_ref().map(|u| &u[of_brdf.clone()]);
        with.shading.sample(part(&self.o, of_brdf.clone()), [u0, u1], part_mut(&mut self.i, of_brdf));
        for (n, light) in with.lights.iter().enumerate() {
            let lanes = self.lanes_of(n + 1);
            let [u0, u1] = self.u.each_ref().map(|u| &u[lanes.clone()]);
            let receivers = receivers(&self.position, lanes.clone());
            light.sample(receivers, [u0, u1], part_mut(&mut self.world, lanes));
        }
        for (frame, ranges) in self.frames.iter().zip(self.ranges.chunks_exact(self.techniques)) {
            let of_brdf = ranges[0].clone();
            frame.to_world(part(&self.i, of_brdf.clone()), part_mut(&mut self.world, of_brdf));
            for range in &ranges[1..] {
                frame.to_local(part(&self.world, range.clone()), part_mut(&mut self.i, range.clone()));
            }
        }
    }

    /// Radiance of every light, and the density of all techniques together.
    fn look_up(&mut self, with: &Gathering<'_>, total: usize) {
        let all = || 0..total;
        let receivers = receivers(&self.position, all());
        let directions = part(&self.world, all());
        let filtered = with.look_up == LookUp::Filtered;
        for (light, from) in with.lights.iter().zip(&mut self.lights) {
            if filtered && light.prefiltered().is_some() {
                from.density[all()].fill(0.0);
                from.distance[all()].fill(f32::INFINITY);
            } else {
                let FromLight { radiance, density, distance, .. } = from;
                let radiance = part_mut(radiance, all());
                let (density, distance) = (&mut density[all()], &mut distance[all()]);
                light.evaluate(receivers, directions, Arriving { radiance, density, distance });
            }
        }
        let density = &mut self.density[..total];
        let n = &self.counts[0][..total];
        density.iter_mut().zip(n).for_each(|(density, n)| *density *= n);
        for (from, n) in self.lights.iter().zip(&self.counts[1..]) {
            for ((density, n), of_light) in density.iter_mut().zip(n).zip(&from.density) {
                *density += n * of_light;
            }
        }
        if filtered {
            let footprint = &mut self.footprint[..total];
            for (footprint, density) in footprint.iter_mut().zip(&*density) {
                // one level more than covers the share: texels are squares, shares are not
                *footprint = 2.0 / density.max(f32::MIN_POSITIVE);
            }
            for (light, from) in with.lights.iter().zip(&mut self.lights) {
                if let Some(light) = light.prefiltered() {
                    light.evaluate(receivers, directions, footprint, part_mut(&mut from.radiance, all()));
                }
            }
        }
    }

    /// From values and densities to products and weights.
    fn weigh(&mut self, total: usize) {
        let (weight, cos, density) = (&mut self.weight[..total], &self.i[2][..total], &self.density[..total]);
        for lane in 0..total {
            let inverse = 1.0 / density[lane].max(f32::MIN_POSITIVE);
            weight[lane] = if cos[lane] > 0.0 && density[lane] > 0.0 { cos[lane] * inverse } else { 0.0 };
        }
        for (channel, product) in self.product.iter_mut().enumerate() {
            let product = &mut product[..total];
            product.fill(0.0);
            for from in &self.lights {
                product.iter_mut().zip(&from.radiance[channel]).for_each(|(sum, radiance)| *sum += radiance);
            }
            product.iter_mut().zip(&self.values[channel]).for_each(|(product, value)| *product *= value);
        }
    }

    /// Sum of the contributions of a request, per channel.
    pub(crate) fn sum(&self, request: usize) -> [f32; 3] {
        let mut sum = [0.0; 3];
        for technique in 0..self.techniques {
            let range = self.range(request, technique);
            let weight = &self.weight[range.clone()];
            for (sum, product) in sum.iter_mut().zip(&self.product) {
                *sum +=
                    product[range.clone()].iter().zip(weight).map(|(product, weight)| product * weight).sum::<f32>();
            }
        }
        sum
    }

    /// Looks the bandwidths of all lights up, for [`Self::arriving`].
    pub(crate) fn look_up_bandwidths(&mut self, lights: &LightSet) {
        let total = self.ranges.iter().map(|range| range.end).max().unwrap_or(0);
        let receivers = receivers(&self.position, 0..total);
        for (light, from) in lights.iter().zip(&mut self.lights) {
            light.bandwidth(receivers, part(&self.world, 0..total), &mut from.bandwidth[..total]);
        }
    }

    /// Incident light in a lane from one light, times the BRDF.
    pub(crate) fn arriving(&self, light: usize, lane: usize) -> Reflected {
        let from = &self.lights[light];
        Reflected {
            product: std::array::from_fn(|channel| self.values[channel][lane] * from.radiance[channel][lane]),
            distance: from.distance[lane],
            bandwidth: from.bandwidth[lane],
        }
    }
}

/// Of one light and one direction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Reflected {
    /// BRDF times radiance.
    pub(crate) product: [f32; 3],
    /// To the light, world units.
    pub(crate) distance: f32,
    /// Of the light, cycles per radian.
    pub(crate) bandwidth: f32,
}

/// The samples of a technique that a request takes.
fn taken(with: &Gathering<'_>, request: &Request, technique: usize) -> Range<u32> {
    let before: u32 = (0..technique).map(|technique| with.count(technique, request.samples)).sum();
    let count = with.count(technique, request.samples);
    let within = |at: u32| at.saturating_sub(before).min(count);
    within(request.taken.start)..within(request.taken.end)
}

fn receivers(position: &[Vec<f32>; 3], lanes: Range<usize>) -> Receivers<'_> {
    Receivers { position: part(position, lanes) }
}

fn fill(arrays: &mut [Vec<f32>; 3], range: &Range<usize>, values: [f32; 3]) {
    for (component, value) in arrays.iter_mut().zip(values) {
        component[range.clone()].fill(value);
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn techniques_have_sequences_of_their_own() {
        let mut sequences: Vec<u32> =
            [Stage::Shading, Stage::Pilot].into_iter().flat_map(|s| (0..50).map(move |k| s.sequence(k))).collect();
        sequences.sort_unstable();
        sequences.dedup();
        assert_eq!(sequences.len(), 100);
    }
}
