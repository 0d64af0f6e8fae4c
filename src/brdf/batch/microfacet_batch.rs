//! Microfacet models for renderers.

use crate::batch::batch_brdf::BatchBrdf;
use crate::batch::half_vector_sampler::{HalfVectorSampler, HalfVectors};
use crate::batch::half_vector_table::HalfVectorTable;
use crate::batch::microfacet_channel::{HalfAngles, MicrofacetChannel};
use crate::distributions::normal_distribution::NormalDistribution;
use crate::masking::masking::MaskingLanes;
use crate::math::simd::by_eights;
use crate::models::microfacet::Microfacet;
use wide::f32x8;

/// [`BatchBrdf`] of three channels: half vectors are drawn from the mean of the channels' `D cos theta_h`, mixed with a cosine
/// lobe.
pub(crate) struct MicrofacetBatch<D: NormalDistribution<N>, const N: usize> {
    channels: [MicrofacetChannel<D::Lanes>; 3],
    /// `rho_s height / (c pi)` per channel.
    specular: [f32; 3],
    /// Whether the channels have one distribution.
    shared: bool,
    masking: D::MaskingLanes,
    sampler: HalfVectorSampler,
}

impl<D: NormalDistribution<N>, const N: usize> MicrofacetBatch<D, N> {
    /// `shares`: probability of each channel's distribution; the rest goes to the cosine lobe.
    pub(crate) fn new(channels: [(&Microfacet<D, N>, &D::Masking); 3], shares: [f64; 3]) -> Self {
        let constants = channels.map(|(channel, _)| MicrofacetChannel::new(channel));
        let distributions = channels.map(|(channel, _)| channel.distribution());
        Self {
            specular: constants.each_ref().map(|channel| (channel.specular as f32).clamp(-f32::MAX, f32::MAX)),
            channels: constants,
            shared: distributions[0] == distributions[1] && distributions[1] == distributions[2],
            masking: D::masking_lanes(channels.map(|(_, masking)| masking)),
            sampler: HalfVectorSampler::new(table(distributions, shares), shares.iter().sum()),
        }
    }

    /// The three channels for eight pairs above the horizon.
    #[inline(always)]
    fn values(&self, half: &HalfVectors, i: [f32x8; 3], o: [f32x8; 3]) -> [f32x8; 3] {
        let half = HalfAngles::new(half.tan_square, half.cos_theta_d);
        let [r, g, b] = &self.channels;
        let lobes = if self.shared { [r.lobe(&half); 3] } else { [r.lobe(&half), g.lobe(&half), b.lobe(&half)] };
        if lobes.iter().all(Option::is_none) {
            return self.channels.each_ref().map(MicrofacetChannel::diffuse);
        }
        let masking = [i, o].map(|[x, y, z]| self.masking.g1_over_cos(z, x * x + y * y));
        [0, 1, 2].map(|c: usize| {
            self.channels[c].value(lobes[c], &half, f32x8::splat(self.specular[c]), [masking[0][c], masking[1][c]])
        })
    }
}

impl<D: NormalDistribution<N>, const N: usize> BatchBrdf for MicrofacetBatch<D, N> {
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

/// The distribution of `tan^2 theta_h` of the channels' half vectors together: the mean of their `P22`.
fn table<D: NormalDistribution<N>, const N: usize>(channels: [&D; 3], shares: [f64; 3]) -> Option<HalfVectorTable> {
    let drawn = || channels.into_iter().zip(shares).filter(|(_, share)| *share > 0.0);
    let ranges = drawn().map(|(distribution, _)| distribution.tan_square_range());
    let [low, high] = ranges.reduce(|a, b| [a[0].min(b[0]), a[1].max(b[1])])?;
    let density = |x| drawn().map(|(distribution, share)| share * distribution.p22(x)).sum();
    HalfVectorTable::new(density, low.min(0.01 * high), high)
}
