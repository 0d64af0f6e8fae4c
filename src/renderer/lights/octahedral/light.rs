//! The octahedral light: radiance from all directions, at infinite distance.

use crate::geometry::octahedral::{
    direction_to_signed_square, l1_norm, solid_angle_per_area, square_to_direction, wrap,
};
use crate::geometry::vec3::Vec3;
use crate::lights::error::LightError;
use crate::lights::octahedral::alias_table::TexelTable;
use crate::lights::octahedral::level::LightLevel;
use rayon::prelude::*;

/// Luminance of linear RGB with the primaries of Rec. 709.
pub(crate) const LUMINANCE: [f32; 3] = [0.2126, 0.7152, 0.0722];

/// Radiance above this, in any channel and in the unit of the source, is refused: sums and squares of it must stay finite in single
/// precision.
pub const LARGEST_RADIANCE: f32 = 1e14;

/// Radiance from all directions as an octahedral image with its mip levels, and a way to draw directions from it.
///
/// One image serves evaluation, sampling, export and bandwidth: radiance is its bilinear interpolation, and the density
/// of [`Self::sample`] is positive wherever the radiance is. World space, +z up; radiance in the units of the source, linear RGB.
///
/// A texel is drawn with a probability in proportion to its luminance times its solid angle, half its own and half the mean of the
/// 3 x 3 texels around it, because the look-up reads neighbours; inside the texel the place is uniform in the square, over the
/// whole sphere. So `density = n^2 probability / (4 / l^3)`, constant in a texel up to the Jacobian of the map.
#[derive(Clone, Debug, PartialEq)]
pub struct Light {
    /// Radiance per channel and, at level 0, a quarter of `n^2` times the probability of the texel. From `n x n` to 1 x 1.
    pub(crate) levels: Vec<LightLevel>,
    /// None where no radiance is above zero.
    pub(crate) table: Option<TexelTable>,
}

impl Light {
    /// Default resolution: texels along a side.
    pub const SIZE: usize = 512;
    /// The most texels along a side.
    pub const LARGEST_SIZE: usize = 2048;

    /// The light with these `n x n` texels, row-major in the layout of [`crate::octahedral`].
    ///
    /// # Errors
    /// [`LightError::Radiance`] if `n` is not a power of two from 4 to [`Self::LARGEST_SIZE`], the number of texels is not `n^2`, or
    /// a value is negative, not finite or above [`LARGEST_RADIANCE`].
    pub fn from_octahedral(n: usize, texels: Vec<[f32; 3]>) -> Result<Self, LightError> {
        let refuse = |why: String| Err(LightError::Radiance { why });
        if !n.is_power_of_two() || !(4..=Self::LARGEST_SIZE).contains(&n) {
            return refuse(format!("{n} texels along a side, not a power of two from 4 to {}", Self::LARGEST_SIZE));
        }
        if texels.len() != n * n {
            return refuse(format!("{} texels instead of {n} x {n}", texels.len()));
        }
        if let Some(k) = texels.iter().position(|texel| !texel.iter().all(|&value| is_radiance(value))) {
            return refuse(format!("{:?} at column {}, row {}", texels[k], k % n, k / n));
        }
        let weights = weights(n, &texels);
        let sum: f64 = weights.iter().sum();
        let table = (sum > 0.0).then(|| TexelTable::new(n, &weights));
        let factor = if sum > 0.0 { (n * n) as f64 * 0.25 / sum } else { 0.0 };
        let texel = |([r, g, b], weight): (&[f32; 3], &f64)| [*r, *g, *b, (weight * factor) as f32];
        let mut levels = vec![LightLevel::new(n, &texels.iter().zip(&weights).map(texel).collect::<Vec<_>>())];
        while levels[levels.len() - 1].size() > 1 {
            levels.push(levels[levels.len() - 1].half());
        }
        Ok(Self { levels, table })
    }

    /// The light of a function of the unit direction: means over 2 x 2 places per texel, weighted by solid angle.
    ///
    /// # Errors
    /// As [`Self::from_octahedral`].
    pub fn from_fn(n: usize, radiance: impl Fn(Vec3) -> [f32; 3] + Sync) -> Result<Self, LightError> {
        Self::from_octahedral(n, texel_means(n, 2, radiance))
    }

    /// Texels along a side of level 0.
    pub fn size(&self) -> usize {
        self.levels[0].size()
    }

    /// The radiance in a texel of a level.
    ///
    /// # Panics
    /// If there is no such level or texel.
    pub fn texel(&self, level: usize, column: usize, row: usize) -> [f32; 3] {
        let [r, g, b, _] = self.levels[level].texel(column, row);
        [r, g, b]
    }

    /// Whether there is no radiance at all; then the density is 0 everywhere.
    pub fn is_black(&self) -> bool {
        self.table.is_none()
    }

    /// The radiance from a unit direction, bilinear in level 0.
    pub fn radiance(&self, d: Vec3) -> [f32; 3] {
        let [r, g, b, _] = self.levels[0].bilinear(self.position(0, d)).to_array();
        [r, g, b]
    }

    /// The radiance from a unit direction, trilinear at a level, which is limited to those that exist.
    pub fn radiance_at_level(&self, d: Vec3, level: f32) -> [f32; 3] {
        let level = level.clamp(0.0, (self.levels.len() - 1) as f32);
        let fine = (level as usize).min(self.levels.len() - 2);
        let [a, b] = [fine, fine + 1].map(|k| self.levels[k].bilinear(self.position(k, d)));
        let [r, g, b, _] = (a + (b - a) * (level - fine as f32)).to_array();
        [r, g, b]
    }

    /// The density of [`Self::sample`] at a unit direction, 1/sr; it integrates to 1 over the sphere, or is 0 for a black light.
    pub fn density(&self, d: Vec3) -> f32 {
        let [x, y] = self.position(0, d).map(|x| (x + 0.5) as usize);
        let norm = l1_norm(d);
        self.levels[0].fourth(y * (self.size() + 2) + x) / (norm * norm * norm)
    }

    /// Draws a unit direction from two numbers in [0, 1); +z where the light is black.
    pub fn sample(&self, u: [f32; 2]) -> Vec3 {
        self.table.as_ref().map_or_else(Vec3::z, |table| square_to_direction(table.place(u)))
    }

    /// The solid angle of a texel of level 0 at a unit direction, steradians; that of level k is `4^k` times as large.
    pub fn solid_angle(&self, d: Vec3) -> f32 {
        solid_angle_per_area(d) / (self.size() * self.size()) as f32
    }

    fn position(&self, level: usize, d: Vec3) -> [f32; 2] {
        direction_to_signed_square(d).map(|p| self.levels[level].position(p))
    }
}

/// What a light may hold.
pub(crate) fn is_radiance(value: f32) -> bool {
    (0.0..=LARGEST_RADIANCE).contains(&value)
}

/// Means of a function of the direction over `k x k` places in each of `n x n` texels, weighted by solid angle.
pub(crate) fn texel_means(n: usize, k: usize, radiance: impl Fn(Vec3) -> [f32; 3] + Sync) -> Vec<[f32; 3]> {
    let scale = 1.0 / (n * k) as f32;
    let mean = |texel: usize| {
        let (mut sum, mut total) = ([0.0; 3], 0.0);
        for place in 0..k * k {
            let at = |first: usize, inside: usize| ((first * k + inside) as f32 + 0.5) * scale;
            let d = square_to_direction([at(texel % n, place % k), at(texel / n, place / k)]);
            let weight = solid_angle_per_area(d);
            total += weight;
            for (sum, value) in sum.iter_mut().zip(radiance(d)) {
                *sum += weight * value;
            }
        }
        sum.map(|sum| sum / total)
    };
    (0..n * n).into_par_iter().with_min_len(n).map(mean).collect()
}

/// The probabilities of the texels before they are normalised.
fn weights(n: usize, texels: &[[f32; 3]]) -> Vec<f64> {
    let own = |(k, texel): (usize, &[f32; 3])| {
        let luminance: f64 = texel.iter().zip(LUMINANCE).map(|(&x, weight)| f64::from(x) * f64::from(weight)).sum();
        let centre = [k % n, k / n].map(|x| (x as f32 + 0.5) / n as f32);
        luminance * f64::from(solid_angle_per_area(square_to_direction(centre)))
    };
    let own: Vec<f64> = texels.iter().enumerate().map(own).collect();
    let around = |k: usize| {
        let cell = |m: usize| wrap(n, (k % n + m % 3) as isize - 1, (k / n + m / 3) as isize - 1);
        (0..9).map(cell).map(|[column, row]| own[row * n + column]).sum::<f64>() / 9.0
    };
    (0..n * n).map(|k| 0.5 * own[k] + 0.5 * around(k)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lights::procedural::Procedural;

    fn directions(count: usize) -> impl Iterator<Item = Vec3> {
        let spiral = move |n: usize| {
            let z = 1.0 - 2.0 * (n as f64 + 0.5) / count as f64;
            let (radius, phi) = ((1.0 - z * z).sqrt(), n as f64 * 2.399_963_229_728_653);
            nalgebra::Vector3::new(radius * libm::cos(phi), radius * libm::sin(phi), z).cast()
        };
        (0..count).map(spiral)
    }

    #[test]
    fn density_integrates_to_one() {
        for kind in Procedural::ALL {
            let light = kind.light(64);
            // the density is constant in a texel up to the solid angle: eight by eight places in each
            let n = 512;
            let place = |k: usize| [(k % n) as f32, (k / n) as f32].map(|x| (x + 0.5) / n as f32);
            let term = |k: usize| {
                let d = square_to_direction(place(k));
                f64::from(light.density(d)) * f64::from(solid_angle_per_area(d))
            };
            let integral = (0..n * n).map(term).sum::<f64>() / (n * n) as f64;
            assert!((integral - 1.0).abs() < 2e-6, "{kind:?}: {integral}");
        }
    }

    /// Wherever a look-up reads something there is a density.
    #[test]
    fn density_covers_the_radiance() {
        let mut texels = vec![[0.0; 3]; 64];
        texels[0] = [1.0, 0.0, 0.0];
        texels[27] = [0.0, 0.0, 1e-6];
        let light = Light::from_octahedral(8, texels).expect("a light");
        for d in directions(20_000) {
            assert_eq!(light.radiance(d) != [0.0; 3], light.density(d) > 0.0 && light.radiance(d) != [0.0; 3]);
        }
    }

    /// Crossing an edge of the image the radiance goes on.
    #[test]
    fn bilinear_goes_on_over_the_edges() {
        let mut state = 1_u32;
        let mut random = || {
            state = crate::geometry::sobol::mix(state);
            (state >> 8) as f32 / 16_777_216.0
        };
        let light =
            Light::from_octahedral(16, (0..256).map(|_| [random(), random(), random()]).collect()).expect("a light");
        for level in 0..4 {
            for k in 0..200 {
                let along = (k as f32 + 0.5) / 200.0;
                for edge in [[0.0, along], [1.0, along], [along, 0.0], [along, 1.0]] {
                    // the edge is where y and x change sign below the horizon
                    let d = square_to_direction(edge);
                    let step = if edge[0] == 0.0 || edge[0] == 1.0 { Vec3::y() } else { Vec3::x() };
                    let [a, b] =
                        [1e-4, -1e-4].map(|h| light.radiance_at_level((d + step * h).normalize(), level as f32));
                    for channel in 0..3 {
                        assert!((a[channel] - b[channel]).abs() < 0.02, "level {level}, {edge:?}: {a:?} {b:?}");
                    }
                }
            }
        }
    }

    #[test]
    fn levels_are_means() {
        let light = Procedural::Sky.light(64);
        for channel in 0..3 {
            let mean = |level: usize| {
                let n = 64 >> level;
                let sum: f64 = (0..n * n).map(|k| f64::from(light.texel(level, k % n, k / n)[channel])).sum();
                sum / (n * n) as f64
            };
            for level in 1..7 {
                assert!((mean(level) / mean(0) - 1.0).abs() < 1e-6);
            }
        }
        let d = Vec3::new(0.3, -0.5, 0.2).normalize();
        let [fine, coarse, between] = [2.0, 3.0, 2.25].map(|level| light.radiance_at_level(d, level)[1]);
        assert!((between - (0.75 * fine + 0.25 * coarse)).abs() < 1e-6);
        assert_eq!(light.radiance(d), light.radiance_at_level(d, -1.0));
        assert_eq!(light.radiance_at_level(d, 99.0), light.texel(6, 0, 0));
    }

    #[test]
    fn a_black_light_is_never_drawn() {
        let light = Light::from_octahedral(8, vec![[0.0; 3]; 64]).expect("a light");
        assert!(light.is_black());
        assert_eq!((light.density(Vec3::x()), light.radiance(Vec3::x())), (0.0, [0.0; 3]));
        assert_eq!(light.sample([0.3, 0.7]), Vec3::z());
    }

    #[test]
    fn refuses_what_is_no_radiance() {
        for value in [-1.0, f32::NAN, f32::INFINITY, 1e15] {
            let mut texels = vec![[0.5; 3]; 64];
            texels[13][1] = value;
            let message = Light::from_octahedral(8, texels).expect_err("no light").to_string();
            assert!(message.contains("column 5, row 1") && !message.contains('\n'), "{message}");
        }
        assert!(Light::from_octahedral(6, vec![[0.5; 3]; 36]).is_err());
        assert!(Light::from_octahedral(8, vec![[0.5; 3]; 36]).is_err());
    }
}
