//! The local bandwidth of the light in every direction.

use crate::geometry::vec3::Vec3;
use crate::lights::octahedral::light::Light;
use brdfit_bandwidth::Estimator;
use brdfit_brdf::by_eights;
use rayon::prelude::*;
use std::f32::consts::FRAC_PI_2;
use wide::f32x8;

/// A chart reaches this many times as far as the horizon.
const REACH: f32 = 1.1;
/// Radians per unit along the radius of a chart.
const RADIAL: f32 = REACH * FRAC_PI_2;
/// Samples along a side of the charts that are analysed.
const ANALYSED: usize = 512;
/// Level of the light's mips at which they are read.
const READ_LEVEL: f32 = 0.6;
/// A reading above this, in cycles per sample and before calibration, counts as infinite.
const EDGE: f32 = 0.16;
/// The scale across the radius is at least this: it vanishes at the antipode of the chart's centre.
const SMALLEST_ACROSS: f32 = 0.3;

/// The bandwidth of a [`Light`] around each direction, in cycles per radian; infinite where it changes from sample to sample, and
/// the material decides.
///
/// The light, R + G + B, is laid out on two azimuthal-equidistant charts around +z and -z, `theta = 1.1 pi/2 r` over `[-1, 1]^2`, and
/// analysed by [`Estimator`] with its defaults (512 x 512 samples, 7 levels, to 4 x 4). Readings are divided by the geometric mean
/// of the chart's scales along and across the radius and reduced to 256 x 256 by the maximum; a look-up takes the nearest.
///
/// Reading at mip 0.6 blurs, and edges of a light are as soft as its texels. Readings above some 11 cycles per radian count as the
/// edges that they mostly are.
///
/// Accuracy: that of the estimator (docs/accuracy.md), and up to a factor of 1.25 at the horizon, where the scales differ by 1.6.
#[derive(Clone, Debug, PartialEq)]
pub struct LightBandwidth {
    /// The chart around +z, then that around -z, row-major.
    texels: Vec<f32>,
}

impl LightBandwidth {
    /// Texels along a side of a chart.
    pub const SIZE: usize = 256;

    /// The bandwidth of a light.
    pub fn new(light: &Light) -> Self {
        Self { texels: [1.0, -1.0].into_iter().flat_map(|sign| chart(light, sign)).collect() }
    }

    /// The bandwidth around a unit direction.
    pub fn at(&self, d: Vec3) -> f32 {
        let lanes = [d.x, d.y, d.z].map(f32x8::splat);
        self.texels[eight_indices(lanes)[0]]
    }

    /// The bandwidths around unit directions, the same as [`Self::at`].
    ///
    /// # Panics
    /// If the slices differ in length.
    pub fn at_many(&self, d: [&[f32]; 3], bandwidth: &mut [f32]) {
        by_eights(d, [bandwidth], |d| [f32x8::from(eight_indices(d).map(|index| self.texels[index]))]);
    }

    /// The charts around +z and -z, [`Self::SIZE`] squared texels each, row-major: column along x, row along y, as they are looked up.
    pub fn charts(&self) -> [&[f32]; 2] {
        let (upper, lower) = self.texels.split_at(Self::SIZE * Self::SIZE);
        [upper, lower]
    }
}

/// Positions of the bandwidths of eight directions.
#[inline(always)]
fn eight_indices([x, y, z]: [f32x8; 3]) -> [usize; 8] {
    let size = LightBandwidth::SIZE as f32;
    // theta / sin theta = p(cos theta) / sqrt(1 + cos theta), finite everywhere: Abramowitz and Stegun 4.4.46, within 2e-8
    const P: [f32; 8] = [
        FRAC_PI_2,
        -0.214_598_8,
        0.088_978_99,
        -0.050_174_304,
        0.030_891_88,
        -0.017_088_126,
        0.006_670_09,
        -0.001_262_491,
    ];
    let cos = z.abs().fast_min(f32x8::ONE);
    let polynomial = P.iter().rev().fold(f32x8::ZERO, |sum, &p| sum * cos + p);
    let scale = polynomial / (cos + 1.0).sqrt() * (0.5 * size / RADIAL);
    let cell =
        |x: f32x8| (x * scale + 0.5 * size).fast_max(f32x8::ZERO).fast_min(f32x8::splat(size - 0.5)).fast_trunc_int();
    let (column, row) = (cell(x).to_array(), cell(y).to_array());
    let below = z.simd_lt(f32x8::ZERO).to_bitmask();
    std::array::from_fn(|n| {
        let chart = (below >> n & 1) as usize;
        (chart * LightBandwidth::SIZE + row[n] as usize % LightBandwidth::SIZE) * LightBandwidth::SIZE
            + column[n] as usize % LightBandwidth::SIZE
    })
}

/// One chart, reduced: +1 around +z, -1 around -z.
fn chart(light: &Light, sign: f32) -> Vec<f32> {
    let place = |k: usize| 2.0 * (k as f32 + 0.5) / ANALYSED as f32 - 1.0;
    let theta = |k: usize| {
        let (u, v) = (place(k % ANALYSED), place(k / ANALYSED));
        (u, v, RADIAL * (u * u + v * v).sqrt())
    };
    let read = |k: usize| {
        let (u, v, theta) = theta(k);
        let across = RADIAL * libm::sinf(theta) / theta;
        let [r, g, b] =
            light.radiance_at_level(Vec3::new(u * across, v * across, sign * libm::cosf(theta)), READ_LEVEL);
        r + g + b
    };
    let image: Vec<f32> = (0..ANALYSED * ANALYSED).into_par_iter().with_min_len(ANALYSED).map(read).collect();
    let estimator = Estimator::default();
    let calibrated = estimator.local_bandwidth(&image, ANALYSED, ANALYSED);
    let edge = EDGE * estimator.kappa() as f32;
    let per_radian = |k: usize| {
        let (_, _, theta) = theta(k);
        let across = (RADIAL * libm::sinf(theta) / theta).max(SMALLEST_ACROSS);
        let samples_per_radian = (ANALYSED / 2) as f32 / (RADIAL * across).sqrt();
        if calibrated[k] > edge { f32::INFINITY } else { calibrated[k] * samples_per_radian }
    };
    let size = LightBandwidth::SIZE;
    let reduced = |k: usize| {
        let first = 2 * (k / size) * ANALYSED + 2 * (k % size);
        [first, first + 1, first + ANALYSED, first + ANALYSED + 1].map(per_radian).into_iter().fold(0.0, f32::max)
    };
    (0..size * size).map(reduced).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lights::procedural::Procedural;
    use std::f32::consts::PI;

    fn direction(theta: f32, phi: f32) -> Vec3 {
        Vec3::new(libm::sinf(theta) * libm::cosf(phi), libm::sinf(theta) * libm::sinf(phi), libm::cosf(theta))
    }

    #[test]
    fn a_uniform_light_has_none() {
        let bandwidth = LightBandwidth::new(&Procedural::Uniform.light(512));
        assert!(bandwidth.texels.iter().all(|&nu| nu == 0.0));
        let black = Light::from_fn(64, |_| [0.0; 3]).expect("a light");
        assert!(LightBandwidth::new(&black).texels.iter().all(|&nu| nu == 0.0));
    }

    /// Along the rim of a bright disc the readings are high; they decay with the distance from it.
    #[test]
    fn edges_read_high() {
        let centre = direction(0.8, 0.3);
        let disc = |d: Vec3| [if d.dot(&centre) > libm::cosf(0.35) { 5.0 } else { 0.1 }; 3];
        let bandwidth = LightBandwidth::new(&Light::from_fn(512, disc).expect("a light"));
        let along = centre.cross(&Vec3::z()).normalize();
        let across = along.cross(&centre);
        let at = |angle: f32, turn: f32| {
            let aside = along * libm::cosf(turn) + across * libm::sinf(turn);
            bandwidth.at(centre * libm::cosf(angle) + aside * libm::sinf(angle))
        };
        for k in 0..16 {
            let turn = k as f32 * 0.4;
            let near =
                [-0.01, -0.005, 0.0, 0.005, 0.01].map(|step| at(0.35 + step, turn)).into_iter().fold(0.0, f32::max);
            assert!(near > 10.0 && at(0.7, turn) < 0.3 * near, "{turn}: {near} {}", at(0.7, turn));
        }
    }

    /// What fills one texel has no bandwidth that the image could show.
    #[test]
    fn single_texels_are_infinite() {
        let n = 512;
        let bright = [200 * n + 300, 100 * n + 100];
        let mut texels = vec![[0.01; 3]; n * n];
        for k in bright {
            texels[k] = [1000.0; 3];
        }
        let bandwidth = LightBandwidth::new(&Light::from_octahedral(n, texels).expect("a light"));
        let towards = |k: usize| {
            crate::geometry::octahedral::square_to_direction([k % n, k / n].map(|x| (x as f32 + 0.5) / n as f32))
        };
        let infinite = (0..n * n).map(towards).filter(|&d| bandwidth.at(d) == f32::INFINITY);
        let near = infinite.map(|d| bright.iter().any(|&k| d.angle(&towards(k)) < 0.1)).collect::<Vec<_>>();
        assert!(!near.is_empty() && near.iter().all(|&near| near), "{near:?}");
    }

    /// A wave around the vertical, `cos(k phi)`, has `k / (2 pi sin theta)` cycles per radian.
    #[test]
    fn waves_read_near_their_frequency_until_they_count_as_edges() {
        for k in [12.0, 24.0, 100.0_f32] {
            let wave = |d: Vec3| [1.0 + libm::cosf(k * libm::atan2f(d.y, d.x)); 3];
            let bandwidth = LightBandwidth::new(&Light::from_fn(512, wave).expect("a light"));
            for theta in [0.6, 1.0, 1.4, 1.9_f32] {
                let expected = k / (2.0 * PI * libm::sinf(theta));
                let mut read: Vec<f32> = (0..256).map(|n| bandwidth.at(direction(theta, n as f32 * 0.0245))).collect();
                read.sort_unstable_by(f32::total_cmp);
                let octaves = libm::log2f(read[128] / expected);
                let edge = read[128] == f32::INFINITY;
                assert!(if expected > 15.0 { edge } else { octaves.abs() < 0.6 }, "k {k}, theta {theta}: {octaves}");
            }
        }
    }

    /// The look-up against the definition of the chart in double precision.
    #[test]
    fn looks_up_the_nearest_texel() {
        let size = LightBandwidth::SIZE;
        let numbered = LightBandwidth { texels: (0..2 * size * size).map(|n| n as f32).collect() };
        for n in 0..20_000_u32 {
            let mut u = [[0.0], [0.0]];
            let [a, b] = &mut u;
            crate::geometry::sobol::fill(3, n, [a, b]);
            let d = crate::geometry::octahedral::square_to_direction([u[0][0], u[1][0]]);
            let [x, y, z] = [d.x, d.y, d.z].map(f64::from);
            let r = libm::atan2(x.hypot(y), z.abs()) / (1.1 * std::f64::consts::FRAC_PI_2);
            let place = [x, y].map(|x| (x / libm::hypot(d.x.into(), d.y.into()) * r * 0.5 + 0.5) * size as f64);
            if place.iter().all(|x| (x - x.round()).abs() > 1e-4) {
                let chart = usize::from(z < 0.0) * size * size;
                let index = chart + place[1] as usize * size + place[0] as usize;
                assert_eq!(numbered.at(d), index as f32, "{d:?}");
            }
        }
        assert_eq!(numbered.at(Vec3::z()), (size / 2 * size + size / 2) as f32);
    }

    #[test]
    fn many_are_many_times_one() {
        let bandwidth = LightBandwidth::new(&Procedural::Studio.light(64));
        for count in [0, 5, 8, 77] {
            let d: Vec<Vec3> = (0..count).map(|n| direction(n as f32 * 0.041, n as f32)).collect();
            let [x, y, z]: [Vec<f32>; 3] = std::array::from_fn(|k| d.iter().map(|d| d[k]).collect());
            let mut many = vec![0.0; count];
            bandwidth.at_many([&x, &y, &z], &mut many);
            assert_eq!(many, d.iter().map(|&d| bandwidth.at(d)).collect::<Vec<_>>());
        }
    }
}
