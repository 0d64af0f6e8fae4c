//! The interface of all BRDFs: evaluation, sampling, density.

use crate::batch::batch_brdf::BatchBrdf;
use crate::batch::fixed_outgoing::{Directions, FixedOutgoing};
use crate::batch::half_vector_sampler::HalfVectorSampler;
use crate::math::direction::{Direction, cosine_sample};
use crate::math::simd::by_eights;
use std::f64::consts::FRAC_1_PI;
use wide::f32x8;

/// The symmetry of a BRDF about the normal.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Symmetry {
    /// None that is known: anisotropic.
    None,
    /// `f` depends on the difference of the azimuths.
    Isotropic,
    /// `f` depends on the size of the difference of the azimuths alone: isotropic, and the same seen in a mirror.
    Mirror,
}

/// A bidirectional reflectance distribution function of three colour channels.
pub trait Brdf: Send + Sync {
    /// `f(i, o)` in 1/sr per channel for unit vectors in the local frame (normal +z); zero where either is at or below the horizon.
    fn value(&self, i: &Direction, o: &Direction) -> [f64; 3];

    /// Symmetries: rotations and reflections of both directions that leave the BRDF unchanged.
    fn symmetry(&self) -> Symmetry {
        Symmetry::Mirror
    }

    /// Draws an outgoing direction for the incident direction `i` from three numbers in [0, 1), azimuth, radius and choice of the
    /// technique: `None` where the draw ends below the horizon (it counts as a sample of value zero).
    fn sample(&self, i: &Direction, u: [f64; 3]) -> Option<Direction> {
        let _ = i;
        Some(cosine_sample([u[0], u[1]]))
    }

    /// Probability density in 1/sr with which [`Brdf::sample`] draws `o` for `i`; above zero wherever `f` is.
    fn pdf(&self, i: &Direction, o: &Direction) -> f64 {
        let _ = i;
        o.z.max(0.0) * FRAC_1_PI
    }

    /// Makes the model ready to be evaluated towards a fixed set of directions for many incident ones, in single precision.
    /// Models for which that pays compute here what depends on `o` alone.
    fn towards<'a>(&'a self, o: &'a Directions) -> Box<dyn FixedOutgoing + 'a> {
        Box::new(OneByOne { brdf: self, o })
    }

    /// Makes the model ready for renderers: many pairs of directions at once in single precision. The density is the one of
    /// the returned object's own samples, not [`Brdf::pdf`].
    fn batch(&self) -> Box<dyn BatchBrdf + '_> {
        Box::new(PairByPair(self))
    }
}

/// [`FixedOutgoing`] of any model: one evaluation in double precision after the other.
pub(crate) struct OneByOne<'a, B: ?Sized> {
    pub(crate) brdf: &'a B,
    pub(crate) o: &'a Directions,
}

impl<B: Brdf + ?Sized> FixedOutgoing for OneByOne<'_, B> {
    fn values(&self, i: &Direction, first: usize, values: [&mut [f32]; 3]) {
        let [r, g, b] = values;
        assert!(r.len() == g.len() && g.len() == b.len(), "the channels differ in length");
        for (n, ((r, g), b)) in r.iter_mut().zip(g).zip(b).enumerate() {
            [*r, *g, *b] = self.brdf.value(i, &self.o.get(first + n)).map(|value| value as f32);
        }
    }
}

/// [`BatchBrdf`] of any model, one pair in double precision after the other.
///
/// [`Brdf::sample`] takes three numbers, the first its azimuth, the third its technique: the first of two serves as the third,
/// and 4096 times it, without its whole part, as the first. Techniques are chosen exactly as often as they should be; azimuths
/// come in steps of 1/4096 turn.
struct PairByPair<'a, B: ?Sized>(&'a B);

impl<B: Brdf + ?Sized> BatchBrdf for PairByPair<'_, B> {
    fn sample(&self, o: [&[f32]; 3], u: [&[f32]; 2], i: [&mut [f32]; 3]) {
        let [x, y, z] = i;
        assert!(o.iter().chain(&u).all(|numbers| numbers.len() == x.len()), "the arrays differ in length");
        for n in 0..x.len() {
            let [choice, radial] = u.map(|u| f64::from(u[n]));
            let drawn = self.0.sample(&at(o, n), [(choice * 4096.0).fract(), radial, choice]);
            let drawn = drawn.unwrap_or(Direction::new(0.0, 0.0, -1.0));
            (x[n], y[n], z[n]) = (drawn.x as f32, drawn.y as f32, drawn.z as f32);
        }
    }

    fn evaluate(&self, i: [&[f32]; 3], o: [&[f32]; 3], values: [&mut [f32]; 3], density: &mut [f32]) {
        let [r, g, b] = values;
        for n in 0..density.len() {
            let (i, o) = (at(i, n), at(o, n));
            [r[n], g[n], b[n]] = self.0.value(&i, &o).map(|value| value as f32);
            density[n] = self.0.pdf(&o, &i) as f32;
        }
    }
}

/// One entry, of length one again.
fn at(directions: [&[f32]; 3], n: usize) -> Direction {
    let [x, y, z] = directions.map(|component| f64::from(component[n]));
    Direction::new(x, y, z).normalize()
}

/// Lambert's model: the same value for every pair of directions above the horizon.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lambert {
    /// Albedo per channel.
    pub albedo: [f64; 3],
}

impl Brdf for Lambert {
    fn value(&self, i: &Direction, o: &Direction) -> [f64; 3] {
        if i.z > 0.0 && o.z > 0.0 { self.albedo.map(|albedo| albedo * FRAC_1_PI) } else { [0.0; 3] }
    }

    fn batch(&self) -> Box<dyn BatchBrdf + '_> {
        Box::new(*self)
    }
}

impl BatchBrdf for Lambert {
    fn sample(&self, o: [&[f32]; 3], u: [&[f32]; 2], i: [&mut [f32]; 3]) {
        HalfVectorSampler::new(None, 0.0).sample_many(o, u, i);
    }

    fn evaluate(&self, i: [&[f32]; 3], o: [&[f32]; 3], values: [&mut [f32]; 3], density: &mut [f32]) {
        let [r, g, b] = values;
        let value = self.albedo.map(|albedo| (albedo * FRAC_1_PI) as f32);
        by_eights([i[2], o[2]], [r, g, b, density], |[i, o]| {
            let above = i.simd_gt(f32x8::ZERO) & o.simd_gt(f32x8::ZERO);
            [f32x8::splat(value[0]), f32x8::splat(value[1]), f32x8::splat(value[2]), i * std::f32::consts::FRAC_1_PI]
                .map(|found| above & found)
        });
    }
}
