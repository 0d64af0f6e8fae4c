//! Mixture sampling of half vectors and a cosine lobe, eight directions at a time.

use crate::batch::half_vector_table::HalfVectorTable;
use crate::math::simd::{by_eights, cos_sin_of_turns};
use std::f32::consts::FRAC_1_PI;
use wide::f32x8;

/// `tan^2 theta_h` is cut here; its square stays finite.
const LARGEST_TAN_SQUARE: f32 = 1e9;

/// Quantities of the half vectors of eight pairs of directions that distributions need.
#[derive(Clone, Copy, Debug)]
pub struct HalfVectors {
    /// `tan^2 theta_h`, at most 1e9.
    pub tan_square: f32x8,
    /// `cos theta_d`, above zero.
    pub cos_theta_d: f32x8,
}

impl HalfVectors {
    /// Those of directions above the horizon. Near the mirror direction sums of components are exact: no digits are lost
    /// where half vectors are short across.
    #[inline]
    pub fn new(i: [f32x8; 3], o: [f32x8; 3]) -> Self {
        let [x, y, z] = [i[0] + o[0], i[1] + o[1], i[2] + o[2]];
        let (across, along) = (x * x + y * y, (z * z).fast_max(f32x8::splat(f32::MIN_POSITIVE)));
        Self {
            tan_square: (across / along).fast_min(f32x8::splat(LARGEST_TAN_SQUARE)),
            cos_theta_d: (across + along).sqrt() * 0.5,
        }
    }
}

/// Half vectors of a tabulated distribution mixed with a cosine lobe (one-sample balance heuristic).
#[derive(Clone, Debug)]
pub struct HalfVectorSampler {
    table: Option<HalfVectorTable>,
    /// Probability of the table; the rest goes to the cosine lobe.
    share: f32,
}

impl HalfVectorSampler {
    /// The mixture with a probability in [0, 0.95] of the table; without a table it is the cosine lobe alone.
    pub fn new(table: Option<HalfVectorTable>, share: f64) -> Self {
        let share = if table.is_some() { share.clamp(0.0, 0.95) as f32 } else { 0.0 };
        Self { table: table.filter(|_| share > 0.0), share }
    }

    /// Draws directions for others from two numbers in [0, 1): the first chooses between the techniques and, stretched,
    /// serves as their radial number, so that stratified numbers stay stratified in each; the second is the azimuth.
    /// A draw that ends below the horizon has z <= 0.
    #[inline]
    pub fn sample(&self, o: [f32x8; 3], u: [f32x8; 2]) -> [f32x8; 3] {
        let [cos, sin] = cos_sin_of_turns(u[1]);
        let most = f32x8::splat(1.0 - f32::EPSILON / 2.0);
        let rest = ((u[0] - self.share) / (1.0 - self.share)).fast_max(f32x8::ZERO).fast_min(most);
        let across = rest.sqrt();
        let diffuse = [across * cos, across * sin, (1.0 - rest).sqrt()];
        let Some(table) = &self.table else { return diffuse };
        let specular = u[0].simd_lt(f32x8::splat(self.share));
        let tan_square = table.sample_tan_square((u[0] / self.share).fast_min(most));
        let cos_h = 1.0 / (tan_square + 1.0).sqrt();
        let sin_h = tan_square.sqrt() * cos_h;
        let h = [sin_h * cos, sin_h * sin, cos_h];
        let twice = (o[0] * h[0] + o[1] * h[1] + o[2] * h[2]) * 2.0;
        [0, 1, 2].map(|axis: usize| specular.select(twice * h[axis] - o[axis], diffuse[axis]))
    }

    /// [`Self::sample`] for arrays of any length.
    ///
    /// # Panics
    /// If the arrays differ in length.
    pub fn sample_many(&self, o: [&[f32]; 3], u: [&[f32]; 2], i: [&mut [f32]; 3]) {
        by_eights([o[0], o[1], o[2], u[0], u[1]], i, |[x, y, z, u, v]| self.sample([x, y, z], [u, v]));
    }

    /// The density in 1/sr with which [`Self::sample`] draws directions of these cosines, above zero, with these half vectors.
    #[inline]
    pub fn density(&self, half: &HalfVectors, cos_theta: f32x8) -> f32x8 {
        let diffuse = cos_theta * ((1.0 - self.share) * FRAC_1_PI);
        let Some(table) = &self.table else { return diffuse };
        // 1 / cos^2 theta_h
        let secant = half.tan_square + 1.0;
        let normals = table.density(half.tan_square) * secant * secant.sqrt() * (self.share * 0.25 * FRAC_1_PI);
        diffuse + normals / half.cos_theta_d
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn directions_have_length_one_and_the_half_vector_is_found_again() {
        let table = HalfVectorTable::new(|x| libm::exp(-x / 1e-4), 1e-8, 1e-2).unwrap();
        let sampler = HalfVectorSampler::new(Some(table.clone()), 0.5);
        let o = [0.6, 0.0, 0.8].map(f32x8::splat);
        for n in 0..500 {
            let u = [n as f32 / 500.0, (n as f32 * 0.618).fract()].map(f32x8::splat);
            let i = sampler.sample(o, u);
            let length = (i[0] * i[0] + i[1] * i[1] + i[2] * i[2]).to_array()[0];
            assert!((length - 1.0).abs() < 1e-6, "{length}");
            if n < 250 {
                let drawn = table.sample_tan_square(u[0] / 0.5).to_array()[0];
                let found = HalfVectors::new(i, o).tan_square.to_array()[0];
                assert!((drawn.sqrt() - found.sqrt()).abs() < 2e-7, "{drawn} {found}");
            }
        }
    }

    #[test]
    fn without_a_table_the_density_is_the_cosine() {
        let sampler = HalfVectorSampler::new(None, 0.9);
        let (i, o) = ([0.0, 0.6, 0.8].map(f32x8::splat), [0.6, 0.0, 0.8].map(f32x8::splat));
        let density = sampler.density(&HalfVectors::new(i, o), i[2]).to_array()[0];
        assert!((density - 0.8 * FRAC_1_PI).abs() < 1e-7);
    }
}
