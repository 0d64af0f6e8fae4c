//! The bandwidth of one outgoing lobe.

use brdfit_brdf::{Brdf, Direction};

use crate::lobe::grid::{LobeGrid, LobeSampler, RESOLUTIONS, size};
use crate::lobe::map::{MapInput, MapMemory, Rasters};
use crate::lobe::sampled::SampledLobe;
use crate::lobe::transform::LobeEnergies;
use crate::lobe::window_choice::window;
use crate::wavelet::local_bandwidth::Estimator;

/// Options of the estimation of lobes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LobeOptions {
    /// The estimator; its border is always reflected.
    pub estimator: Estimator,
    /// The resolution is doubled where the finest level holds more than this share of a channel's energy.
    pub finest_share: f64,
    /// The highest resolution: 256, 512 or 1024 samples along a side.
    pub max_resolution: usize,
}

impl Default for LobeOptions {
    fn default() -> Self {
        Self { estimator: Estimator::default(), finest_share: 5e-4, max_resolution: 1024 }
    }
}

/// The local bandwidth of an outgoing lobe on the angular map, 64 x 64 texels, each the maximum over its samples.
#[derive(Clone, Debug, PartialEq)]
pub struct Lobe {
    /// Cycles per radian of the channels R, G, B, row-major; 0 where the lobe does not vary, NaN where it has values that are not
    /// finite.
    pub texels: [Vec<f32>; 3],
    /// Samples along a side on which it was estimated.
    pub resolution: usize,
    /// Whether the finest level still held too much at the highest resolution: the map is a lower bound.
    pub saturated: bool,
}

/// Estimates the bandwidth of the lobes of a material (Bagher 2013, section 2.3; docs/theory.md, "Lobes").
pub struct LobeEstimator<'a> {
    sampler: LobeSampler<'a>,
    options: LobeOptions,
    mirrored: bool,
    rasters: Rasters,
}

/// Memory for the estimation of one lobe after the other.
#[derive(Clone, Debug, Default)]
pub struct LobeMemory {
    sampled: SampledLobe,
    energies: LobeEnergies,
    map: MapMemory,
}

impl<'a> LobeEstimator<'a> {
    /// `mirrored` tells that `f(i, .)` is mirror symmetric about the plane of incidence, as that of every isotropic material
    /// is: for incident directions at azimuth zero half of the work is saved.
    ///
    /// # Panics
    /// If the highest resolution is none of 256, 512, 1024.
    pub fn new(brdf: &'a dyn Brdf, grid: &'a LobeGrid, mirrored: bool, options: LobeOptions) -> Self {
        assert!(
            (0..RESOLUTIONS).any(|r| size(r) == options.max_resolution),
            "no resolution {}",
            options.max_resolution
        );
        Self { sampler: LobeSampler::new(brdf, grid), options, mirrored, rasters: Rasters::default() }
    }

    /// Estimates the lobe of an incident direction (unit, above the horizon).
    pub fn estimate(&self, i: &Direction, memory: &mut LobeMemory) -> Lobe {
        let LobeMemory { sampled, energies, map } = memory;
        let estimator = &self.options.estimator;
        sampled.sample(&self.sampler, i, self.mirrored && i.y == 0.0);
        energies.compute(sampled, estimator);
        let saturated = self.refine(i, sampled, energies);
        if !sampled.windows.is_empty() {
            energies.compute(sampled, estimator);
        }
        let mut texels = energies.channels.each_ref().map(|energies| {
            let SampledLobe { windows, symmetric, .. } = &*sampled;
            let input = MapInput { energies, windows, grid: self.sampler.grid(), estimator, symmetric: *symmetric };
            self.rasters.map(&input, map)
        });
        // no map of what is not finite: an atlas refuses it
        if sampled.energies().iter().any(|sum| !sum.is_finite()) {
            texels.iter_mut().for_each(|channel| channel.fill(f32::NAN));
        }
        Lobe { texels, resolution: size(sampled.resolution()), saturated }
    }

    /// Doubles the resolution where the lobe is too sharp for it, until it is not or no further resolution is allowed; tells whether
    /// it still is.
    fn refine(&self, i: &Direction, sampled: &mut SampledLobe, energies: &mut LobeEnergies) -> bool {
        let estimator = &self.options.estimator;
        let mut saturated = self.is_too_sharp(sampled, energies);
        while saturated && size(sampled.resolution()) < self.options.max_resolution {
            let SampledLobe { windows, symmetric, .. } = &*sampled;
            let chosen = window(&energies.channels, windows.len(), estimator.delta, *symmetric, windows.last());
            let Some(chosen) = chosen else { break };
            sampled.sample_window(&self.sampler, i, chosen);
            energies.add_window(sampled, estimator);
            saturated = self.is_too_sharp(sampled, energies);
        }
        saturated
    }

    /// Whether the finest level holds too much of the energy of the lobe, the sum of squares of its samples, in any channel.
    fn is_too_sharp(&self, sampled: &SampledLobe, energies: &LobeEnergies) -> bool {
        let channels = energies.channels.iter().zip(sampled.energies());
        channels.into_iter().any(|(energies, sum)| energies.finest() > self.options.finest_share * sum)
    }
}
