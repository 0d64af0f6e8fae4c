//! The GGX model for shading, eight pairs at a time.

use crate::batch::half_vector_sampler::{HalfVectorSampler, HalfVectors};
use crate::batch::half_vector_table::HalfVectorTable;
use crate::batch::shading::Shading;
use crate::distributions::ggx::Ggx;
use crate::math::simd::by_eights;
use wide::f32x8;

/// [`Shading`] of GGX.
pub(crate) struct GgxShading {
    diffuse: [f32; 3],
    /// `rho_s m^2 / (4 pi)`.
    specular: [f32; 3],
    m_square: f32,
    sampler: HalfVectorSampler,
}

impl GgxShading {
    /// Of the scales of the diffuse and the specular part, the width and the probability of the specular lobe.
    pub(crate) fn new(rho_d: [f64; 3], rho_s: [f64; 3], m: f64, specular_share: f64) -> Self {
        let (ggx, m_square) = (Ggx::new(m), m * m);
        // D cos theta_h dw = P22 dx / ..: P22 is D without the four cosines, up to a factor
        let p22 = |x: f64| ggx.d_at_tan_square(x) / ((1.0 + x) * (1.0 + x));
        let table = HalfVectorTable::new(p22, m_square / 256.0, (1e6 * m_square).max(1e4));
        Self {
            diffuse: rho_d.map(|rho_d| (rho_d * std::f64::consts::FRAC_1_PI) as f32),
            specular: rho_s.map(|rho_s| (rho_s * m_square * 0.25 * std::f64::consts::FRAC_1_PI) as f32),
            m_square: m_square as f32,
            sampler: HalfVectorSampler::new(table, specular_share),
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
        self.sampler.sample_many(o, u, i);
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
