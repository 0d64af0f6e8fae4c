//! Mixture sampling of GGX half vectors and a cosine lobe, one direction at a time in double precision.

use crate::distributions::ggx::Ggx;
use crate::distributions::normal_distribution::NormalDistribution;
use crate::math::direction::{Direction, cosine_sample, reflect};
use std::f64::consts::FRAC_1_PI;

/// Half vectors of up to three GGX distributions mixed with a cosine lobe. The density is that of the whole mixture
/// (one-sample balance heuristic; Veach 1997, section 9.2.4), so it is above zero wherever a BRDF may be.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GgxMixture {
    proxies: [Ggx; 3],
    /// Probability of each; the rest goes to the cosine lobe.
    shares: [f64; 3],
}

impl GgxMixture {
    /// The mixture of distributions with these probabilities, together at most one; the rest goes to the cosine lobe.
    pub fn new(proxies: [Ggx; 3], shares: [f64; 3]) -> Self {
        Self { proxies, shares }
    }

    /// The distributions.
    pub fn proxies(&self) -> &[Ggx; 3] {
        &self.proxies
    }

    /// Draws an outgoing direction for the incident direction `i`: see [`crate::Brdf::sample`].
    pub fn sample(&self, i: &Direction, u: [f64; 3]) -> Option<Direction> {
        let mut below = 0.0;
        for (proxy, share) in self.proxies.iter().zip(self.shares) {
            below += share;
            if u[2] < below {
                let o = reflect(i, &proxy.sample([u[0], u[1]]));
                return (o.z > 0.0).then_some(o);
            }
        }
        Some(cosine_sample([u[0], u[1]]))
    }

    /// The density in 1/sr with which [`Self::sample`] draws `o` for `i`.
    pub fn pdf(&self, i: &Direction, o: &Direction) -> f64 {
        if i.z <= 0.0 || o.z <= 0.0 {
            return 0.0;
        }
        let h = i + o;
        let tan_square = (h.x * h.x + h.y * h.y) / (h.z * h.z);
        // D cos theta_h / (4 i.h) with h of length one; |i + o| = 2 i.h
        let jacobian = h.z / (2.0 * h.norm_squared());
        let lobes = self.proxies.iter().zip(self.shares).filter(|(_, share)| *share > 0.0);
        let lobes: f64 = lobes.map(|(proxy, share)| share * proxy.d_at_tan_square(tan_square)).sum();
        let cosine = (1.0 - self.shares.iter().sum::<f64>()).max(0.0);
        lobes * jacobian + cosine * o.z * FRAC_1_PI
    }
}
