//! Screen-space differentials of normals, positions and mirror directions.

use rayon::prelude::*;

use crate::geometry::gbuffer::{BACKGROUND, GBuffer};
use crate::geometry::vec3::Vec3;

/// Change of the mirror direction, in radians per pixel along both axes, where a pixel has no neighbour of its material: as
/// good as a silhouette on all sides, so it asks for full resolution.
const ISOLATED: f32 = 0.2;

/// Screen-space differentials of a [`GBuffer`], row-major; zeros at pixels of the background.
///
/// Differences are one-sided: along each axis, of the two neighbours of the same material that whose depth is nearer.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Differentials {
    /// Largest singular value of `d r / d pixel`, `r = 2 (n.v) n - v` the mirror direction of the view: radians per pixel. What
    /// is reflected from a distance passes over the image at this speed.
    pub(crate) spread: Vec<f32>,
    /// Normal curvature `dn.dp / dp.dp` along the axis of the image where it is larger in magnitude, 1 per world unit;
    /// above zero where the surface is convex towards the eye.
    pub(crate) curvature: Vec<f32>,
}

impl Differentials {
    /// The differentials of all pixels.
    pub(crate) fn new(gbuffer: &GBuffer) -> Self {
        let (width, pixels) = (gbuffer.width, gbuffer.material.len());
        let (mut spread, mut curvature) = (vec![0.0; pixels], vec![0.0; pixels]);
        spread.par_chunks_mut(width).zip(curvature.par_chunks_mut(width)).enumerate().for_each(
            |(y, (spread, curvature))| {
                for x in 0..width {
                    if gbuffer.material[y * width + x] != BACKGROUND {
                        (spread[x], curvature[x]) = at(gbuffer, x, y);
                    }
                }
            },
        );
        Self { spread, curvature }
    }
}

/// Spread and curvature at a pixel of a surface.
fn at(gbuffer: &GBuffer, x: usize, y: usize) -> (f32, f32) {
    let (width, height) = (gbuffer.width, gbuffer.height);
    let centre = y * width + x;
    let across = nearer(gbuffer, centre, (x > 0).then(|| centre - 1), (x + 1 < width).then(|| centre + 1));
    let down = nearer(gbuffer, centre, (y > 0).then(|| centre - width), (y + 1 < height).then(|| centre + width));
    let mirror = gbuffer.mirror_direction(centre);
    let column = |neighbour: Option<usize>| match neighbour {
        Some(other) => gbuffer.mirror_direction(other) - mirror,
        None => Vec3::repeat(ISOLATED),
    };
    let bend = |neighbour: Option<usize>| match neighbour {
        Some(other) => {
            let dp = gbuffer.position[other] - gbuffer.position[centre];
            let dn = gbuffer.normal[other] - gbuffer.normal[centre];
            dn.dot(&dp) / dp.norm_squared().max(f32::MIN_POSITIVE)
        }
        None => 0.0,
    };
    let (c_x, c_y) = (bend(across), bend(down));
    (largest_singular_value(&column(across), &column(down)), if c_x.abs() >= c_y.abs() { c_x } else { c_y })
}

/// Of two neighbours the one of the same material whose depth is nearer, the first on a tie.
fn nearer(gbuffer: &GBuffer, centre: usize, before: Option<usize>, after: Option<usize>) -> Option<usize> {
    let step = |other: usize| (gbuffer.depth[other] - gbuffer.depth[centre]).abs();
    let same = |other: &usize| gbuffer.material[*other] == gbuffer.material[centre];
    match (before.filter(same), after.filter(same)) {
        (Some(before), Some(after)) => Some(if step(after) < step(before) { after } else { before }),
        (before, after) => before.or(after),
    }
}

/// Largest singular value of the matrix with these two columns.
fn largest_singular_value(a: &Vec3, b: &Vec3) -> f32 {
    let (aa, bb, ab) = (a.norm_squared(), b.norm_squared(), a.dot(b));
    let half = 0.5 * (aa - bb);
    (0.5 * (aa + bb) + (half * half + ab * ab).sqrt()).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_scenes::sphere;

    #[test]
    fn the_centre_of_a_sphere_agrees_with_the_closed_form() {
        // unit sphere seen from distance d: at the centre dn = dp / R, the normal turns by a (d - R)/R per pixel, the view by a
        let gbuffer = sphere(129, 4.0);
        let differentials = Differentials::new(&gbuffer);
        let centre = 64 * 129 + 64;
        let expected = gbuffer.pixel_angle * (2.0 * 3.0 + 1.0);
        let ours = differentials.spread[centre];
        assert!((ours / expected - 1.0).abs() < 2e-3, "{ours} {expected}");
        assert!((differentials.curvature[centre] - 1.0).abs() < 1e-3, "{}", differentials.curvature[centre]);
        // the normal curvature of a sphere is 1/R everywhere
        for (pixel, &material) in gbuffer.material.iter().enumerate() {
            let facing = gbuffer.normal[pixel].dot(&gbuffer.view[pixel]);
            assert!(material == BACKGROUND || facing < 0.3 || (differentials.curvature[pixel] - 1.0).abs() < 0.02);
        }
    }

    #[test]
    fn singular_values_agree_with_nalgebra() {
        for (a, b) in [([1.0, 2.0, 3.0], [0.5, -1.0, 0.1]), ([0.0, 0.0, 1.0], [0.0, 0.0, 2.0]), ([0.0; 3], [0.0; 3])] {
            let (a, b) = (Vec3::from(a), Vec3::from(b));
            let exact = nalgebra::Matrix3x2::from_columns(&[a, b]).svd(false, false).singular_values[0];
            assert!((largest_singular_value(&a, &b) - exact).abs() < 1e-5);
        }
    }

    #[test]
    fn a_single_pixel_asks_for_full_resolution() {
        let mut gbuffer = sphere(3, 4.0);
        for pixel in (0..9).filter(|&pixel| pixel != 4) {
            gbuffer.material[pixel] = BACKGROUND;
        }
        let differentials = Differentials::new(&gbuffer);
        assert!((differentials.spread[4] - ISOLATED * 6.0_f32.sqrt()).abs() < 1e-6);
        assert_eq!(differentials.curvature[4], 0.0);
        assert_eq!(differentials.spread[0], 0.0);
    }
}
