//! The SGD model for renderers.

use crate::batch::half_vector_sampler::{HalfVectorSampler, HalfVectors};
use crate::batch::half_vector_table::HalfVectorTable;
use crate::batch::shading::Shading;
use crate::masking::curve::G1Curve;
use crate::masking::table::MaskingTable;
use crate::math::simd::by_eights;
use crate::models::sgd::Sgd;
use crate::models::sgd_channel::{SgdChannel, fifth_of_grazing};
use wide::f32x8;

/// [`Shading`] of three SGD channels: half vectors are drawn from the mean of the channels' `D cos theta_h`, mixed with a cosine lobe.
pub(crate) struct SgdShading {
    channels: [SgdChannel; 3],
    /// `rho_s P22(t*) / pi^2` per channel.
    specular: [f32; 3],
    masking: MaskingTable,
    sampler: HalfVectorSampler,
}

impl SgdShading {
    /// `shares`: probability of each channel's distribution; the rest goes to the cosine lobe.
    pub(crate) fn new(channels: [(&Sgd, &G1Curve); 3], shares: [f64; 3]) -> Self {
        let constants = channels.map(|(sgd, _)| SgdChannel::new(sgd));
        Self {
            specular: constants.each_ref().map(|channel| (channel.specular as f32).clamp(-f32::MAX, f32::MAX)),
            channels: constants,
            masking: MaskingTable::new(channels.map(|(_, curve)| curve)),
            sampler: HalfVectorSampler::new(table(channels.map(|(sgd, _)| sgd), shares), shares.iter().sum()),
        }
    }

    /// The three channels for eight pairs above the horizon.
    #[inline(always)]
    fn values(&self, half: &HalfVectors, i: [f32x8; 3], o: [f32x8; 3]) -> [f32x8; 3] {
        let lobes = self.channels.each_ref().map(|channel| channel.lobe(half.tan_square));
        let diffuse = self.channels.each_ref().map(|channel| f32x8::splat(channel.diffuse));
        if lobes.iter().all(Option::is_none) {
            return diffuse;
        }
        let masking = [i, o].map(|[x, y, z]| self.masking.g1_over_cos(z, x * x + y * y));
        let secant = half.tan_square + 1.0;
        let secant_fourth = secant * secant;
        let fifth = fifth_of_grazing(half.cos_theta_d);
        [0, 1, 2].map(|c: usize| match lobes[c] {
            // in this order no product overflows: the last factors are large where the lobe is small
            Some(lobe) => {
                let masked = lobe * self.specular[c] * masking[0][c] * masking[1][c];
                diffuse[c] + masked * secant_fourth * self.channels[c].fresnel(half.cos_theta_d, fifth)
            }
            None => diffuse[c],
        })
    }
}

impl Shading for SgdShading {
    fn sample(&self, o: [&[f32]; 3], u: [&[f32]; 2], i: [&mut [f32]; 3]) {
        self.sampler.sample_many(o, u, i);
    }

    fn evaluate(&self, i: [&[f32]; 3], o: [&[f32]; 3], values: [&mut [f32]; 3], density: &mut [f32]) {
        let [r, g, b] = values;
        by_eights([i[0], i[1], i[2], o[0], o[1], o[2]], [r, g, b, density], |[ix, iy, iz, ox, oy, oz]| {
            let above = iz.simd_gt(f32x8::ZERO) & oz.simd_gt(f32x8::ZERO);
            if above.none() {
                return [f32x8::ZERO; 4];
            }
            let (i, o) = ([ix, iy, iz], [ox, oy, oz]);
            let half = HalfVectors::new(i, o);
            let [r, g, b] = self.values(&half, i, o);
            [r, g, b, self.sampler.density(&half, iz)].map(|found| above & found)
        });
    }
}

/// The distribution of `tan^2 theta_h` of the channels' half vectors together: the mean of their `P22`. From where the
/// narrowest is constant to where a billionth of the widest is left.
fn table(channels: [&Sgd; 3], shares: [f64; 3]) -> Option<HalfVectorTable> {
    let drawn = || channels.into_iter().zip(shares).filter(|(_, share)| *share > 0.0);
    let distributions = drawn().map(|(sgd, _)| sgd.distribution());
    let alpha = distributions.clone().map(|distribution| distribution.alpha()).reduce(f64::min)?;
    let high = distributions.map(|distribution| distribution.quantile(1.0 - 1e-9)).reduce(f64::max)?;
    let low = (alpha * alpha / 256.0).min(0.01 * high);
    HalfVectorTable::new(|x| drawn().map(|(sgd, share)| share * sgd.distribution().p22(x)).sum(), low, high)
}
