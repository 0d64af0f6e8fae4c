//! A microfacet material of three channels: evaluation and importance sampling.

use crate::batch::batch_brdf::BatchBrdf;
use crate::batch::fixed_outgoing::{Directions, FixedOutgoing};
use crate::batch::ggx_mixture::GgxMixture;
use crate::batch::microfacet_batch::MicrofacetBatch;
use crate::batch::microfacet_towards::MicrofacetTowards;
use crate::brdf::{Brdf, OneByOne};
use crate::distributions::ggx::Ggx;
use crate::distributions::normal_distribution::NormalDistribution;
use crate::masking::curve::G1Curve;
use crate::masking::masking::Masking;
use crate::math::direction::{Direction, sine};
use crate::models::microfacet::{Microfacet, MicrofacetParameters};
use crate::models::parameter::ParameterError;
use std::f64::consts::FRAC_PI_4;

/// Three channels (R, G, B) of a microfacet model, evaluated with Smith's masking made ready for many directions.
///
/// # Sampling
/// The cumulative of a distribution need not have a closed inverse. As in thesis V.3.5 half vectors are drawn from a
/// GGX proxy, with two differences. The proxy's width is not alpha but the root of the distribution's **median** `tan^2 theta_h`:
/// with alpha as the width the tail of SGD, where most normals lie, is hardly drawn, and single weights reach thousands. And the
/// density is the full mixture of the three channels' proxies and a cosine lobe (one-sample balance heuristic), so it is above
/// zero wherever `f` is and the weight `f cos / pdf` contains every Jacobian: `pdf_h D cos theta_h / (4 i.h)`.
/// [`Brdf::batch`] draws from the tabulated distributions themselves.
#[derive(Clone, Debug)]
pub struct MicrofacetMaterial<D: NormalDistribution<N>, const N: usize> {
    channels: [Channel<D, N>; 3],
    /// Probability of each channel's lobe; the rest goes to the cosine lobe.
    shares: [f64; 3],
    mixture: GgxMixture,
}

/// A channel with its masking function.
#[derive(Clone, Debug)]
pub(crate) struct Channel<D: NormalDistribution<N>, const N: usize> {
    model: Microfacet<D, N>,
    masking: D::Masking,
}

impl<D: NormalDistribution<N>, const N: usize> MicrofacetMaterial<D, N> {
    /// The material with these parameters of R, G and B.
    ///
    /// # Errors
    /// As [`Microfacet::new`], for the first channel that it rejects.
    pub fn new(parameters: [impl Into<MicrofacetParameters<N>>; 3]) -> Result<Self, ParameterError> {
        let channels = channels(parameters)?;
        // shares by the albedo at 45 degrees, the lobes together between 0.1 and 0.95
        let rho_d = channels.each_ref().map(|channel| channel.model.parameters().rho_d);
        let albedo = |c: usize| channels[c].model.directional_albedo(&channels[c].masking, FRAC_PI_4);
        let lobes = [0, 1, 2].map(|c: usize| (albedo(c) - rho_d[c]).max(0.0));
        let (total, share) = (lobes.iter().sum::<f64>(), specular_share(lobes, rho_d));
        Ok(Self::with_shares(channels, lobes.map(|lobe| if share > 0.0 { share * lobe / total } else { 0.0 })))
    }

    /// The material with given probabilities of the channels' lobes.
    pub(crate) fn with_shares(channels: [Channel<D, N>; 3], shares: [f64; 3]) -> Self {
        let median = |channel: &Channel<D, N>| Ggx::new(channel.model.distribution().quantile(0.5).sqrt());
        let mixture = GgxMixture::new(channels.each_ref().map(median), shares);
        Self { channels, shares, mixture }
    }

    /// The model of channel R, G or B (0, 1, 2).
    pub fn channel(&self, channel: usize) -> &Microfacet<D, N> {
        &self.channels[channel].model
    }

    /// The channels with their masking functions.
    fn parts(&self) -> [(&Microfacet<D, N>, &D::Masking); 3] {
        self.channels.each_ref().map(|channel| (&channel.model, &channel.masking))
    }
}

/// The models of three channels.
pub(crate) fn channels<D: NormalDistribution<N>, const N: usize>(
    parameters: [impl Into<MicrofacetParameters<N>>; 3],
) -> Result<[Channel<D, N>; 3], ParameterError> {
    let [r, g, b] = parameters.map(|parameters| {
        let model = Microfacet::<D, N>::new(parameters)?;
        Ok(Channel { masking: model.distribution().masking(), model })
    });
    Ok([r?, g?, b?])
}

/// The probability of the lobes together, from what they and the diffuse parts reflect: between 0.1 and 0.95, or zero.
pub(crate) fn specular_share(specular: [f64; 3], diffuse: [f64; 3]) -> f64 {
    let [specular, diffuse] = [specular, diffuse].map(|scale| scale.iter().sum::<f64>());
    if specular > 0.0 { (specular / (specular + diffuse)).clamp(0.1, 0.95) } else { 0.0 }
}

impl<D: NormalDistribution<N>, const N: usize> Brdf for MicrofacetMaterial<D, N> {
    fn value(&self, i: &Direction, o: &Direction) -> [f64; 3] {
        if i.z <= 0.0 || o.z <= 0.0 {
            return [0.0; 3];
        }
        let h = i + o;
        let tan_square = (h.x * h.x + h.y * h.y) / (h.z * h.z);
        let cos_d = 0.5 * h.norm();
        let places = [i.z, o.z].map(|cos| {
            let sin = sine(cos).max(1e-12);
            (cos, sin, G1Curve::position(cos, sin))
        });
        self.channels.each_ref().map(|Channel { model, masking }| {
            let g1_over_cos = places.map(|(cos, sin, position)| masking.g1_over_cos(cos, sin, position));
            let fresnel = model.parameters().fresnel().value(cos_d);
            model.combine(model.distribution().d_at_tan_square(tan_square), fresnel, g1_over_cos)
        })
    }

    fn sample(&self, i: &Direction, u: [f64; 3]) -> Option<Direction> {
        self.mixture.sample(i, u)
    }

    fn pdf(&self, i: &Direction, o: &Direction) -> f64 {
        self.mixture.pdf(i, o)
    }

    fn towards<'a>(&'a self, o: &'a Directions) -> Box<dyn FixedOutgoing + 'a> {
        if D::SINGLE_PRECISION_LOBES {
            Box::new(MicrofacetTowards::new(self.parts(), o))
        } else {
            Box::new(OneByOne { brdf: self, o })
        }
    }

    fn batch(&self) -> Box<dyn BatchBrdf + '_> {
        Box::new(MicrofacetBatch::new(self.parts(), self.shares))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::direction::{HalfDifference, direction, reflect};
    use crate::models::configuration::Configuration;
    use crate::models::sgd::{SgdMaterial, SgdParameters};
    use std::f64::consts::PI;

    fn material() -> SgdMaterial {
        let channel = |alpha, p| SgdParameters { rho_d: 0.05, rho_s: 0.3, alpha, p, f0: 0.3, f1: 0.1 };
        SgdMaterial::new([channel(0.002, 0.6), channel(0.01, 1.1), channel(0.15, 0.2)]).unwrap()
    }

    #[test]
    fn agrees_with_the_exact_channels() {
        let material = material();
        for (theta_i, theta_o, phi) in [(0.2, 0.3, 3.0), (0.9, 0.8, 3.1), (1.3, 1.45, 2.8), (0.0, 0.0, 0.0)] {
            let (i, o) = (direction(theta_i, 0.4), direction(theta_o, 0.4 + phi));
            let configuration = Configuration::from(HalfDifference::from_directions(&i, &o));
            let value = material.value(&i, &o);
            for c in 0..3 {
                let exact = material.channel(c).value(&configuration);
                assert!((value[c] / exact - 1.0).abs() < 1e-5, "channel {c}: {} {exact}", value[c]);
            }
        }
    }

    /// Kronecker's sequence of the golden ratio of dimension three: deterministic, even.
    fn points(count: u32) -> impl Iterator<Item = [f64; 3]> {
        const STEPS: [f64; 3] = [0.819_172_513_396_164_4, 0.671_043_606_703_789_2, 0.549_700_477_901_970_2];
        (1..=count).map(|n| STEPS.map(|step| (0.5 + f64::from(n) * step).fract()))
    }

    #[test]
    fn the_estimate_of_the_albedo_agrees_with_quadrature() {
        let material = material();
        for theta in [0.05, 0.6, 1.2] {
            let i = direction(theta, 0.0);
            let count = 1_000_000;
            let mut sums = [0.0; 3];
            for u in points(count) {
                if let Some(o) = material.sample(&i, u) {
                    let value = material.value(&i, &o);
                    let weight = o.z / material.pdf(&i, &o);
                    for c in 0..3 {
                        sums[c] += value[c] * weight;
                    }
                }
            }
            for c in 0..3 {
                let expected = material.channel(c).directional_albedo(&material.channels[c].masking, theta);
                let estimate = sums[c] / f64::from(count);
                assert!((estimate / expected - 1.0).abs() < 2e-3, "theta {theta} channel {c}: {estimate} {expected}");
            }
        }
    }

    #[test]
    fn the_density_integrates_to_the_share_above_the_horizon() {
        let material = material();
        for theta in [0.1, 1.0] {
            let i = direction(theta, 0.0);
            let above = points(100_000).filter(|&u| material.sample(&i, u).is_some()).count() as f64 / 1e5;
            // midpoint rule in (sqrt(theta of h), phi of h), where the density is smooth
            let (rings, azimuths) = (1500, 400);
            let mut sum = 0.0;
            for ring in 0..rings {
                let root = (f64::from(ring) + 0.5) / f64::from(rings);
                let theta_h = root * root * PI / 2.0;
                let width = 2.0 * root / f64::from(rings) * PI / 2.0;
                for n in 0..azimuths {
                    let h = direction(theta_h, 2.0 * PI * (f64::from(n) + 0.5) / f64::from(azimuths));
                    let o = reflect(&i, &h);
                    if i.dot(&h) > 0.0 {
                        sum += material.pdf(&i, &o) * 4.0 * i.dot(&h) * libm::sin(theta_h) * width * 2.0 * PI
                            / f64::from(azimuths);
                    }
                }
            }
            assert!((sum - above).abs() < 3e-3, "theta {theta}: {sum} {above}");
        }
    }

    #[test]
    fn a_material_without_specular_part_is_sampled_by_the_cosine() {
        let channel = SgdParameters { rho_d: 0.5, rho_s: 0.0, alpha: 0.1, p: 0.3, f0: 0.0, f1: 0.0 };
        let material = SgdMaterial::new([channel; 3]).unwrap();
        let i = direction(0.3, 0.0);
        let o = material.sample(&i, [0.2, 0.4, 0.0]).unwrap();
        assert!((material.pdf(&i, &o) - o.z / PI).abs() < 1e-15);
    }
}
