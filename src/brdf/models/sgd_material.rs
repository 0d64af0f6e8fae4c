//! A material of three SGD channels: evaluation and importance sampling.

use crate::batch::fixed_outgoing::{Directions, Lobes};
use crate::batch::sgd_lobes::SgdLobes;
use crate::batch::sgd_shading::SgdShading;
use crate::batch::shading::Shading;
use crate::brdf::{Brdf, cosine_sample};
use crate::distributions::ggx::Ggx;
use crate::masking::curve::G1Curve;
use crate::math::direction::{Direction, HalfDifference, reflect};
use crate::models::sgd::{ParameterError, Sgd, SgdParameters, directional_albedo, sine};
use std::f64::consts::{FRAC_1_PI, PI};

/// Three SGD channels (R, G, B), evaluated with Smith's masking from a tabulated curve (5e-8 relative), sampled through GGX.
///
/// # Sampling
/// The cumulative of the shifted gamma distribution has no closed inverse. As in thesis V.3.5 half vectors are drawn from a
/// GGX proxy, with two differences. The proxy's width is not alpha but the root of the distribution's **median** `tan^2 theta_h`:
/// with alpha as the width the tail, where most normals lie, is hardly drawn, and single weights reach thousands. And the
/// density is the full mixture of the three channels' proxies and a cosine lobe (one-sample balance heuristic), so it is above
/// zero wherever `f` is and the weight `f cos / pdf` contains every Jacobian: `pdf_h D cos theta_h / (4 i.h)`.
/// [`Brdf::shading`] draws from the tabulated distributions themselves.
#[derive(Clone, Debug)]
pub struct SgdMaterial {
    channels: [Channel; 3],
    /// Probability of each channel's proxy; the rest goes to the cosine lobe.
    specular: [f64; 3],
}

#[derive(Clone, Debug)]
struct Channel {
    sgd: Sgd,
    curve: G1Curve,
    proxy: Ggx,
}

impl SgdMaterial {
    /// The material with these parameters of R, G and B.
    ///
    /// # Errors
    /// As [`Sgd::new`], for the first channel that it refuses.
    pub fn new(parameters: [SgdParameters; 3]) -> Result<Self, ParameterError> {
        let [r, g, b] = parameters.map(|channel| {
            Sgd::new(channel).map(|sgd| Channel {
                curve: G1Curve::new(sgd.distribution()),
                proxy: Ggx::new(sgd.distribution().quantile(0.5).sqrt()),
                sgd,
            })
        });
        let channels = [r?, g?, b?];
        // shares by the albedo at 45 degrees, the lobes together between 0.1 and 0.95
        let lobes = [0, 1, 2].map(|c: usize| {
            let Channel { sgd, curve, .. } = &channels[c];
            (directional_albedo(sgd, curve, PI / 4.0) - sgd.parameters().rho_d).max(0.0)
        });
        let diffuse: f64 = channels.iter().map(|channel| channel.sgd.parameters().rho_d).sum();
        let total: f64 = lobes.iter().sum();
        let specular = if total > 0.0 {
            let share = (total / (total + diffuse)).clamp(0.1, 0.95);
            lobes.map(|lobe| share * lobe / total)
        } else {
            [0.0; 3]
        };
        Ok(Self { channels, specular })
    }

    /// The model of channel R, G or B (0, 1, 2).
    pub fn channel(&self, channel: usize) -> &Sgd {
        &self.channels[channel].sgd
    }
}

impl Brdf for SgdMaterial {
    fn value(&self, i: &Direction, o: &Direction) -> [f64; 3] {
        if i.z <= 0.0 || o.z <= 0.0 {
            return [0.0; 3];
        }
        let angles = HalfDifference::from_directions(i, o);
        let tan = libm::tan(angles.theta_h);
        let (tan_square, cos_d) = (tan * tan, libm::cos(angles.theta_d));
        let place = |cos: f64| {
            let sin = sine(cos).max(1e-12);
            (cos, sin, G1Curve::position(cos, sin))
        };
        let (ci, si, pi) = place(i.z);
        let (co, so, po) = place(o.z);
        let secant = 1.0 + tan_square;
        [0, 1, 2].map(|c: usize| {
            let Channel { sgd, curve, .. } = &self.channels[c];
            let parameters = sgd.parameters();
            let d = sgd.distribution().p22(tan_square) * secant * secant / PI;
            let masking = curve.g1_over_cos(ci, si, pi) * curve.g1_over_cos(co, so, po);
            (parameters.rho_d + parameters.rho_s * parameters.fresnel().value(cos_d) * d * masking) * FRAC_1_PI
        })
    }

    fn sample(&self, i: &Direction, u: [f64; 3]) -> Option<Direction> {
        let mut below = 0.0;
        for (channel, share) in self.channels.iter().zip(self.specular) {
            below += share;
            if u[2] < below {
                let o = reflect(i, &channel.proxy.sample([u[0], u[1]]));
                return (o.z > 0.0).then_some(o);
            }
        }
        Some(cosine_sample([u[0], u[1]]))
    }

    fn pdf(&self, i: &Direction, o: &Direction) -> f64 {
        if i.z <= 0.0 || o.z <= 0.0 {
            return 0.0;
        }
        let h = (i + o).normalize();
        let jacobian = h.z / (4.0 * i.dot(&h));
        let lobes: f64 =
            self.channels.iter().zip(self.specular).map(|(channel, share)| share * channel.proxy.d(h.z)).sum();
        let cosine = (1.0 - self.specular.iter().sum::<f64>()).max(0.0);
        lobes * jacobian + cosine * o.z * FRAC_1_PI
    }

    fn lobes<'a>(&'a self, o: &'a Directions) -> Box<dyn Lobes + 'a> {
        Box::new(SgdLobes::new(self.channels.each_ref().map(|channel| (&channel.sgd, &channel.curve)), o))
    }

    fn shading(&self) -> Box<dyn Shading + '_> {
        Box::new(SgdShading::new(self.channels.each_ref().map(|channel| (&channel.sgd, &channel.curve)), self.specular))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::direction::direction;
    use crate::models::sgd::Configuration;

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
                let expected = directional_albedo(material.channel(c), &material.channels[c].curve, theta);
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
