//! Batched look-ups in a light, eight lanes at a time, on arrays of components.
//!
//! All results are those of the single look-ups bit for bit, wherever in a slice they stand.

use crate::geometry::octahedral::{eight_to_directions, eight_to_square};
use crate::geometry::vec3::Vec3;
use crate::lights::octahedral::alias_table::TexelTable;
use crate::lights::octahedral::level::LightLevel;
use crate::lights::octahedral::light::Light;
use brdfit_brdf::by_eights;
use wide::{f32x4, f32x8};

impl Light {
    /// Draws directions as [`Light::sample`] does.
    ///
    /// # Panics
    /// If the slices differ in length.
    pub fn sample_many(&self, u: [&[f32]; 2], d: [&mut [f32]; 3]) {
        let Some(table) = &self.table else {
            for (component, out) in Vec3::z().iter().zip(d) {
                out.fill(*component);
            }
            return;
        };
        by_eights(u, d, |u| eight_samples(table, u));
    }

    /// The radiance, as [`Light::radiance`], and the density, as [`Light::density`], at unit directions.
    ///
    /// # Panics
    /// If the slices differ in length.
    pub fn evaluate_many(&self, d: [&[f32]; 3], radiance: [&mut [f32]; 3], density: &mut [f32]) {
        let [r, g, b] = radiance;
        by_eights(d, [r, g, b, density], |d| eight_values(&self.levels[0], d));
    }

    /// The radiance at unit directions, trilinear at the levels whose texels there cover the given footprints in steradians: level
    /// `1/2 log2(footprint / solid angle of the texel of level 0)`, limited to those that exist.
    ///
    /// Footprints that are not above zero, or not numbers, read level 0. Agrees with [`Light::radiance_at_level`] at that level
    /// within the rounding of the logarithm, 1e-6 of a level.
    ///
    /// # Panics
    /// If the slices differ in length.
    pub fn prefiltered_many(&self, d: [&[f32]; 3], footprint: &[f32], radiance: [&mut [f32]; 3]) {
        let [x, y, z] = d;
        by_eights([x, y, z, footprint], radiance, |[x, y, z, footprint]| self.eight_prefiltered([x, y, z], footprint));
    }

    #[inline(always)]
    fn eight_prefiltered(&self, d: [f32x8; 3], footprint: f32x8) -> [f32x8; 3] {
        let ([p, q], norm) = eight_to_square(d);
        let texel = norm * norm * norm * (4.0 / (self.size() * self.size()) as f32);
        let ratio = (footprint / texel).fast_max(f32x8::ONE).fast_min(f32x8::splat(1e9));
        let last = (self.levels.len() - 1) as f32;
        let level = (ratio.ln() * (0.5 * std::f32::consts::LOG2_E)).fast_max(f32x8::ZERO).fast_min(f32x8::splat(last));
        let (p, q, level) = (p.to_array(), q.to_array(), level.to_array());
        let mut out = [[0.0; 8]; 3];
        for n in 0..8 {
            let fine = (level[n] as usize).min(self.levels.len() - 2);
            let [a, b] = [fine, fine + 1].map(|k| {
                let level = &self.levels[k];
                level.bilinear([level.position(p[n]), level.position(q[n])])
            });
            let value = (a + (b - a) * (level[n] - fine as f32)).to_array();
            for channel in 0..3 {
                out[channel][n] = value[channel];
            }
        }
        out.map(f32x8::from)
    }
}

#[inline(always)]
fn eight_samples(table: &TexelTable, u: [f32x8; 2]) -> [f32x8; 3] {
    let [u, v] = u.map(f32x8::to_array);
    let mut place = [[0.0; 8]; 2];
    for n in 0..8 {
        [place[0][n], place[1][n]] = table.place([u[n], v[n]]);
    }
    eight_to_directions(place.map(f32x8::from))
}

#[inline(always)]
fn eight_values(level: &LightLevel, d: [f32x8; 3]) -> [f32x8; 4] {
    let n = level.size() as f32;
    let ([p, q], norm) = eight_to_square(d);
    let position = |p: f32x8| (p * (0.5 * n) + (0.5 * n + 0.5)).fast_max(f32x8::ZERO).fast_min(f32x8::splat(n + 0.5));
    let (x, y) = (position(p), position(q));
    let floor = |x: f32x8| f32x8::from_i32x8(x.fast_trunc_int());
    let (column, row) = (floor(x), floor(y));
    // below 2^24, so exact
    let index = |column: f32x8, row: f32x8| (row * (n + 2.0) + column).fast_trunc_int().to_array();
    let first = index(column, row);
    let nearest = index(floor(x + 0.5), floor(y + 0.5));
    let (x, y) = ((x - column).to_array(), (y - row).to_array());

    let value = |k: usize| level.between(first[k] as usize, [x[k], y[k]]);
    let [low, high] = [0, 4].map(|k| f32x4::transpose([value(k), value(k + 1), value(k + 2), value(k + 3)]));
    let mut out = [[0.0; 8]; 4];
    for channel in 0..3 {
        out[channel][..4].copy_from_slice(low[channel].as_array());
        out[channel][4..].copy_from_slice(high[channel].as_array());
    }
    let fourth = f32x8::from(std::array::from_fn(|k| level.fourth(nearest[k] as usize)));
    let [r, g, b, _] = out.map(f32x8::from);
    [r, g, b, fourth / (norm * norm * norm)]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::sobol;
    use crate::lights::procedural::Procedural;

    fn split(d: &[Vec3]) -> [Vec<f32>; 3] {
        std::array::from_fn(|k| d.iter().map(|d| d[k]).collect())
    }

    #[test]
    fn many_are_many_times_one() {
        let light = Procedural::Studio.light(64);
        for count in [1, 7, 8, 1003] {
            let mut u = [vec![0.0; count], vec![0.0; count]];
            let [a, b] = &mut u;
            sobol::fill(count as u32, 0, [a, b]);
            let mut d = [0; 3].map(|_| vec![0.0; count]);
            light.sample_many([&u[0], &u[1]], d.each_mut().map(|x| x.as_mut_slice()));
            let singles: Vec<Vec3> = (0..count).map(|n| light.sample([u[0][n], u[1][n]])).collect();
            assert_eq!(d, split(&singles));

            // light samples and uniform directions, axes among them
            let uniform = |n: usize| crate::geometry::octahedral::square_to_direction([u[0][n], u[1][n]]);
            let axes = [Vec3::x(), Vec3::y(), Vec3::z(), -Vec3::x(), -Vec3::y(), -Vec3::z()];
            let all: Vec<Vec3> = singles.iter().copied().chain((0..count).map(uniform)).chain(axes).collect();
            let d = split(&all);
            let mut values = [0; 4].map(|_| vec![0.0; all.len()]);
            let [r, g, b, density] = &mut values;
            light.evaluate_many([&d[0], &d[1], &d[2]], [r, g, b], density);
            for (n, &d) in all.iter().enumerate() {
                assert_eq!(light.radiance(d), [values[0][n], values[1][n], values[2][n]], "{d:?}");
                assert_eq!(light.density(d), values[3][n], "{d:?}");
            }

            let footprint: Vec<f32> = (0..all.len()).map(|n| libm::exp2f(n as f32 % 23.0 - 20.0)).collect();
            let [r, g, b, _] = &mut values;
            light.prefiltered_many([&d[0], &d[1], &d[2]], &footprint, [r, g, b]);
            for (n, &d) in all.iter().enumerate() {
                let level = 0.5 * libm::log2f(footprint[n] / light.solid_angle(d));
                for (channel, value) in light.radiance_at_level(d, level).into_iter().enumerate() {
                    assert!((value - values[channel][n]).abs() <= 1e-5 * (1.0 + value), "{n} {value}");
                }
            }
        }
    }

    #[test]
    fn what_is_no_direction_does_no_harm() {
        let light = Procedural::Sky.light(16);
        let bad = [f32::NAN, 0.0, f32::INFINITY, 1e-40];
        let mut values = [[0.0; 4]; 4];
        let [r, g, b, density] = &mut values;
        light.evaluate_many([&bad, &bad, &bad], [r, g, b], density);
        light.prefiltered_many([&bad, &bad, &bad], &[f32::NAN, -1.0, f32::INFINITY, 0.0], [r, g, b]);
        let _ = (
            light.radiance(Vec3::zeros()),
            light.density(Vec3::zeros()),
            light.radiance_at_level(Vec3::zeros(), f32::NAN),
        );
    }
}
