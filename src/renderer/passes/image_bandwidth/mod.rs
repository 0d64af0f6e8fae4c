//! Image-space bandwidth and pyramid level of every pixel (Bagher et al. 2013, section 3.1).

pub(crate) mod transport;

use nalgebra::Vector2;
use rayon::prelude::*;

use crate::geometry::differentials::Differentials;
use crate::geometry::gbuffer::{BACKGROUND, GBuffer};
use crate::geometry::grazing::LEAST_COSINE;
use crate::passes::image_bandwidth::transport::{BandLimit, Bounce, LARGEST};
use crate::passes::pass::Pass;
use crate::passes::pilot::{GEOMETRY_BANDWIDTH, NEAR_MARGIN, Path, Pilot, Prediction};

/// Coarsest level of the pyramid: cells of 32 x 32 pixels.
pub const COARSEST_LEVEL: usize = 5;
/// The level of pixels of the background.
pub(crate) const NO_LEVEL: u8 = u8::MAX;

/// Transport of angular bandwidth to image-space bandwidth.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Geometry {
    /// Times the speed at which the mirror direction passes over the image, in both directions of the surface.
    #[default]
    Reflected,
    /// The operators of Bagher et al. 2013, figure 4, each path by itself; a band limit
    /// shortens the whole spectrum, a segment, and not its angular part alone.
    Operators,
    /// The operators as published: a band limit cuts the angular part and leaves the spatial one.
    OperatorsPublished,
}

/// Bandwidth and level of each pixel, row-major.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct ImageBandwidth {
    /// Image-space bandwidth, cycles per pixel.
    pub(crate) bandwidth: Vec<f32>,
    /// Coarsest level at which the pixel may be shaded, 0 to [`COARSEST_LEVEL`]; [`u8::MAX`] in the background.
    pub(crate) level: Vec<u8>,
}

/// Carries the bandwidths of the pilot into the image.
pub(crate) struct ImageBandwidthPass<'a> {
    pub(crate) gbuffer: &'a GBuffer,
    pub(crate) differentials: &'a Differentials,
    pub(crate) pilot: &'a Pilot,
    pub(crate) geometry: Geometry,
    /// The number k_s: samples per cycle over two (1 is Nyquist's, pi the published one).
    pub(crate) rate: f32,
}

impl Pass for ImageBandwidthPass<'_> {
    type Output = ImageBandwidth;

    fn run(&self, output: &mut ImageBandwidth) {
        let Self { gbuffer, .. } = *self;
        let (width, pixels) = (gbuffer.width, gbuffer.material.len());
        output.bandwidth.clear();
        output.bandwidth.resize(pixels, 0.0);
        output.level.clear();
        output.level.resize(pixels, NO_LEVEL);
        let rows = output.bandwidth.par_chunks_mut(width).zip(output.level.par_chunks_mut(width));
        rows.enumerate().for_each(|(y, (bandwidth, level))| {
            for x in 0..width {
                let pixel = y * width + x;
                if gbuffer.material[pixel] != BACKGROUND {
                    bandwidth[x] = self.bandwidth(pixel);
                    level[x] = level_of(bandwidth[x], self.rate);
                }
            }
        });
    }
}

impl ImageBandwidthPass<'_> {
    /// Cycles per pixel at a pixel of a surface.
    fn bandwidth(&self, pixel: usize) -> f32 {
        let Self { gbuffer, differentials, pilot, .. } = *self;
        match self.geometry {
            Geometry::Reflected => reflected(gbuffer, pilot, differentials, pixel),
            Geometry::Operators => by_paths(gbuffer, differentials, pilot, pixel, BandLimit::Segment),
            Geometry::OperatorsPublished => by_paths(gbuffer, differentials, pilot, pixel, BandLimit::Published),
        }
    }
}

/// `nu s`, the speed of the mirror direction, for all lights; and for near ones what follows the position and the normal. Distances
/// add up where directions turn both ways, so this is an upper bound of the speed.
fn reflected(gbuffer: &GBuffer, pilot: &Pilot, differentials: &Differentials, pixel: usize) -> f32 {
    let Some(prediction) = pilot.at(pixel) else { return 0.0 };
    let &Prediction { bandwidth, by_position, by_normal, .. } = prediction;
    // along the direction in which the surface is foreshortened
    let step = gbuffer.depth[pixel] * gbuffer.pixel_angle / cos_theta_x(gbuffer, pixel);
    let turn = step * differentials.curvature[pixel].abs();
    bandwidth * differentials.spread[pixel] + (by_position * step + by_normal * turn)
}

fn cos_theta_x(gbuffer: &GBuffer, pixel: usize) -> f32 {
    gbuffer.normal[pixel].dot(&gbuffer.view[pixel]).max(LEAST_COSINE)
}

/// Equation (5) over the transported paths of the pixel's pilot point, with the pixel's own geometry. The light of a near lamp leaves
/// it with a bandwidth in space, and what turns it into one in angle is the way to the surface.
fn by_paths(gbuffer: &GBuffer, differentials: &Differentials, pilot: &Pilot, pixel: usize, limit: BandLimit) -> f32 {
    let point = pilot.points.of_pixel[pixel] as usize;
    let count = pilot.paths.len() / pilot.points.pixels.len();
    let (mut sum, mut total) = (0.0, 0.0);
    for &Path { contribution, light, lobe, cos_theta_i, distance } in &pilot.paths[point * count..][..count] {
        // samples that contribute nothing have no path
        if contribution <= 0.0 {
            continue;
        }
        let light = light.min(LARGEST);
        let near = distance < f32::INFINITY;
        let bounce = Bounce {
            d: if near { distance } else { 0.0 },
            d_eye: gbuffer.depth[pixel],
            c: differentials.curvature[pixel],
            cos_theta_i,
            cos_theta_x: cos_theta_x(gbuffer, pixel),
            rho: if near { (lobe * lobe + GEOMETRY_BANDWIDTH * GEOMETRY_BANDWIDTH).sqrt() } else { lobe },
            t: 0.0,
        };
        let leaving = if near { Vector2::new(light / distance, 0.0) } else { Vector2::new(0.0, light) };
        let seen = bounce.transport(leaving, limit);
        sum += contribution * seen.y.abs() * if near { NEAR_MARGIN } else { 1.0 };
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
