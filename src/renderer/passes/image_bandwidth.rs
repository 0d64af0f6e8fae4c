//! The bandwidth buffer: image-space bandwidth and pyramid level of every pixel, paper 000, section 3.1.

use nalgebra::Vector2;
use rayon::prelude::*;

use crate::geometry::differentials::Differentials;
use crate::geometry::gbuffer::{BACKGROUND, GBuffer};
use crate::geometry::grazing::LEAST_COSINE;
use crate::passes::pilot::{Path, Pilot};
use crate::passes::transport::{BandLimit, Bounce, LARGEST};

/// Coarsest level of the pyramid: cells of 32 x 32 pixels.
pub const COARSEST_LEVEL: usize = 5;
/// The level of pixels of the background.
pub(crate) const NO_LEVEL: u8 = u8::MAX;

/// How angular bandwidth becomes image-space bandwidth.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Geometry {
    /// Times the speed at which the mirror direction passes over the image, in both directions of the surface.
    #[default]
    Reflected,
    /// The operators of figure 4, each path by itself, with [`BandLimit::Segment`].
    Operators,
    /// The operators as they are printed: [`BandLimit::Printed`].
    OperatorsLiteral,
}

/// Bandwidth and level of each pixel, row-major.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct BandwidthBuffer {
    /// Image-space bandwidth, cycles per pixel.
    pub bandwidth: Vec<f32>,
    /// Coarsest level at which the pixel may be shaded, 0 to [`COARSEST_LEVEL`]; [`u8::MAX`] in the background.
    pub level: Vec<u8>,
}

impl BandwidthBuffer {
    /// Fills the buffers. `rate` is the number k_s: samples per cycle over two (1 is Nyquist's, pi the papers').
    pub(crate) fn compute(
        &mut self,
        gbuffer: &GBuffer,
        differentials: &Differentials,
        pilot: &Pilot,
        geometry: Geometry,
        rate: f32,
    ) {
        let pixels = gbuffer.material.len();
        self.bandwidth.clear();
        self.bandwidth.resize(pixels, 0.0);
        self.level.clear();
        self.level.resize(pixels, NO_LEVEL);
        let rows = gbuffer.width.max(1);
        self.bandwidth.par_chunks_mut(rows).zip(self.level.par_chunks_mut(rows)).enumerate().for_each(
            |(y, (bandwidth, level))| {
                for x in 0..rows {
                    let pixel = y * rows + x;
                    if gbuffer.material[pixel] != BACKGROUND {
                        bandwidth[x] = match geometry {
                            Geometry::Reflected => reflected(pilot, differentials, pixel),
                            Geometry::Operators => by_paths(gbuffer, differentials, pilot, pixel, BandLimit::Segment),
                            Geometry::OperatorsLiteral => {
                                by_paths(gbuffer, differentials, pilot, pixel, BandLimit::Printed)
                            }
                        };
                        level[x] = level_of(bandwidth[x], rate);
                    }
                }
            },
        );
    }
}

/// `nu s`.
fn reflected(pilot: &Pilot, differentials: &Differentials, pixel: usize) -> f32 {
    pilot.at(pixel).map_or(0.0, |prediction| prediction.bandwidth * differentials.spread[pixel])
}

/// Equation (5) over the transported paths of the pixel's pilot point, with the pixel's own geometry.
fn by_paths(gbuffer: &GBuffer, differentials: &Differentials, pilot: &Pilot, pixel: usize, limit: BandLimit) -> f32 {
    let point = pilot.of_pixel[pixel] as usize;
    let count = pilot.paths.len() / pilot.pixels.len();
    let cos_theta_x = gbuffer.normal[pixel].dot(&gbuffer.view[pixel]).max(LEAST_COSINE);
    let (mut sum, mut total) = (0.0, 0.0);
    for &Path { contribution, light, lobe, cos_theta_i } in &pilot.paths[point * count..][..count] {
        let bounce = Bounce {
            d: 0.0,
            d_eye: gbuffer.depth[pixel],
            c: differentials.curvature[pixel],
            cos_theta_i,
            cos_theta_x,
            rho: lobe,
            t: 0.0,
        };
        let seen = bounce.transport(Vector2::new(0.0, light.min(LARGEST)), limit);
        sum += contribution * seen.y.abs();
        total += contribution;
    }
    if total > 0.0 { sum / total * gbuffer.pixel_angle } else { 0.0 }
}

/// Equation (11) with Nyquist's factor: the largest cells with two samples per cycle, `clamp(floor(log2(1 / (2 k_s b_p))), 0, 5)`.
fn level_of(bandwidth: f32, rate: f32) -> u8 {
    let pixels = 1.0 / (2.0 * rate * bandwidth);
    // by comparison: the bits of a logarithm decide nothing
    (1..=COARSEST_LEVEL).filter(|&k| pixels >= (1 << k) as f32).count() as u8
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn levels_follow_nyquist() {
        // 0.25 cycles per pixel are two samples per cycle at cells of two pixels
        for (bandwidth, level) in
            [(0.6, 0), (0.26, 0), (0.25, 1), (0.13, 1), (0.125, 2), (0.0156, 5), (1e-9, 5), (0.0, 5)]
        {
            assert_eq!(level_of(bandwidth, 1.0), level, "{bandwidth}");
        }
        assert_eq!(level_of(f32::INFINITY, 1.0), 0);
        assert_eq!(level_of(0.125, std::f32::consts::PI), 0);
    }
}
