//! What every reflectance model offers: evaluation, sampling, density.

use crate::direction::{Direction, direction};
use crate::lobes::{Directions, Lobes};
use crate::shading::{self, Shading};
use std::f64::consts::{FRAC_1_PI, TAU};

/// A bidirectional reflectance distribution function of three colour channels.
pub trait Brdf: Send + Sync {
    /// `f(i, o)` in 1/sr per channel for unit vectors in the local frame (normal +z); zero where either is at or below the horizon.
    fn value(&self, i: &Direction, o: &Direction) -> [f64; 3];

    /// Draws an outgoing direction for the incident direction `i` from three numbers in [0, 1): `None` where the draw ends below
    /// the horizon (it counts as a sample of value zero).
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
    fn lobes<'a>(&'a self, o: &'a Directions) -> Box<dyn Lobes + 'a> {
        Box::new(OneByOne { brdf: self, o })
    }

    /// Makes the model ready for renderers: many pairs of directions at once in single precision. The density is the one of
    /// the returned object's own samples, not [`Brdf::pdf`].
    fn shading(&self) -> Box<dyn Shading + '_> {
        Box::new(shading::OneByOne(self))
    }
}

/// [`Lobes`] of any model: one evaluation in double precision after the other.
struct OneByOne<'a, B: ?Sized> {
    brdf: &'a B,
    o: &'a Directions,
}

impl<B: Brdf + ?Sized> Lobes for OneByOne<'_, B> {
    fn values(&self, i: &Direction, first: usize, values: [&mut [f32]; 3]) {
        let [r, g, b] = values;
        assert!(r.len() == g.len() && g.len() == b.len(), "the channels differ in length");
        for (n, ((r, g), b)) in r.iter_mut().zip(g).zip(b).enumerate() {
            [*r, *g, *b] = self.brdf.value(i, &self.o.get(first + n)).map(|value| value as f32);
        }
    }
}

/// A direction with density `cos theta / pi` from two numbers in [0, 1).
pub fn cosine_sample(u: [f64; 2]) -> Direction {
    direction(libm::asin(u[1].sqrt()), TAU * u[0])
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

    fn shading(&self) -> Box<dyn Shading + '_> {
        Box::new(*self)
    }
}
