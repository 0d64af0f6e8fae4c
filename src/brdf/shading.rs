//! Many pairs of directions at once: what renderers sample and evaluate.

use crate::brdf::{Brdf, Lambert};
use crate::direction::Direction;
use crate::ggx::Ggx;
use crate::ggx_brdf::GgxBrdf;
use crate::half_vector_sampler::{HalfVectorSampler, HalfVectors};
use crate::half_vector_table::HalfVectorTable;
use crate::lanes::by_eights;
use std::f32::consts::FRAC_1_PI;
use wide::f32x8;

/// A BRDF for shading: see [`Brdf::shading`].
///
/// Directions are unit vectors of the local frame (normal +z), one array per component, rounded to single precision and taken
/// as they are. Every entry is independent of the others and may belong to another shading point. The renderer knows the
/// direction o towards the eye and draws the direction i towards the light: [`Brdf::sample`] with exchanged names.
pub trait Shading: Send + Sync {
    /// Draws a direction i for each o from two numbers in [0, 1); a draw that ends below the horizon has z <= 0 and counts as
    /// a sample of value zero.
    ///
    /// # Panics
    /// If the arrays differ in length.
    fn sample(&self, o: [&[f32]; 3], u: [&[f32]; 2], i: [&mut [f32]; 3]);

    /// `f(i, o)` in 1/sr per channel and the density in 1/sr with which [`Shading::sample`] draws i for o; zeros where either is
    /// at or below the horizon.
    ///
    /// # Panics
    /// If the arrays differ in length.
    fn evaluate(&self, i: [&[f32]; 3], o: [&[f32]; 3], values: [&mut [f32]; 3], density: &mut [f32]);
}

/// [`Shading`] of any model, one pair in double precision after the other.
///
/// [`Brdf::sample`] takes three numbers, the first its azimuth, the third its technique: the first of two serves as the third,
/// and 4096 times it, without its whole part, as the first. Techniques are chosen exactly as often as they should be; azimuths
/// come in steps of 1/4096 turn.
pub(crate) struct OneByOne<'a, B: ?Sized>(pub(crate) &'a B);

impl<B: Brdf + ?Sized> Shading for OneByOne<'_, B> {
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

impl Shading for Lambert {
    fn sample(&self, o: [&[f32]; 3], u: [&[f32]; 2], i: [&mut [f32]; 3]) {
        let sampler = HalfVectorSampler::new(None, 0.0);
        by_eights([o[0], o[1], o[2], u[0], u[1]], i, |[x, y, z, u, v]| sampler.sample([x, y, z], [u, v]));
    }

    fn evaluate(&self, i: [&[f32]; 3], o: [&[f32]; 3], values: [&mut [f32]; 3], density: &mut [f32]) {
        let [r, g, b] = values;
        let value = self.albedo.map(|albedo| (albedo * std::f64::consts::FRAC_1_PI) as f32);
        by_eights([i[2], o[2]], [r, g, b, density], |[i, o]| {
            let above = i.simd_gt(f32x8::ZERO) & o.simd_gt(f32x8::ZERO);
            [f32x8::splat(value[0]), f32x8::splat(value[1]), f32x8::splat(value[2]), i * FRAC_1_PI]
                .map(|found| above & found)
        });
    }
}

/// [`Shading`] of GGX.
pub(crate) struct GgxShading {
    diffuse: [f32; 3],
    /// `rho_s m^2 / (4 pi)`.
    specular: [f32; 3],
    m_square: f32,
    sampler: HalfVectorSampler,
}

impl GgxShading {
    pub(crate) fn new(model: &GgxBrdf) -> Self {
        let (ggx, m_square) = (Ggx::new(model.m), model.m * model.m);
        // D cos theta_h dw = P22 dx / ..: P22 is D without the four cosines, up to a factor
        let p22 = |x: f64| ggx.d_at_tan_square(x) / ((1.0 + x) * (1.0 + x));
        let table = HalfVectorTable::new(p22, m_square / 256.0, (1e6 * m_square).max(1e4));
        Self {
            diffuse: model.rho_d.map(|rho_d| (rho_d * std::f64::consts::FRAC_1_PI) as f32),
            specular: model.rho_s.map(|rho_s| (rho_s * m_square * 0.25 * std::f64::consts::FRAC_1_PI) as f32),
            m_square: m_square as f32,
            sampler: HalfVectorSampler::new(table, model.specular_share()),
        }
    }

    /// `G1 / cos theta`, as the model's.
    #[inline(always)]
    fn g1_over_cos(&self, [x, y, z]: [f32x8; 3]) -> f32x8 {
        2.0 / (z + (z * z + (x * x + y * y) * self.m_square).sqrt())
    }
}

impl Shading for GgxShading {
    fn sample(&self, o: [&[f32]; 3], u: [&[f32]; 2], i: [&mut [f32]; 3]) {
        by_eights([o[0], o[1], o[2], u[0], u[1]], i, |[x, y, z, u, v]| self.sampler.sample([x, y, z], [u, v]));
    }

    fn evaluate(&self, i: [&[f32]; 3], o: [&[f32]; 3], values: [&mut [f32]; 3], density: &mut [f32]) {
        let [r, g, b] = values;
        by_eights([i[0], i[1], i[2], o[0], o[1], o[2]], [r, g, b, density], |[ix, iy, iz, ox, oy, oz]| {
            let above = iz.simd_gt(f32x8::ZERO) & oz.simd_gt(f32x8::ZERO);
            let (i, o) = ([ix, iy, iz], [ox, oy, oz]);
            let half = HalfVectors::new(i, o);
            let base = (half.tan_square + 1.0) / (half.tan_square + self.m_square);
            let lobe = base * base * (self.g1_over_cos(i) * self.g1_over_cos(o));
            let value = |c: usize| lobe * self.specular[c] + self.diffuse[c];
            [value(0), value(1), value(2), self.sampler.density(&half, iz)].map(|found| above & found)
        });
    }
}
