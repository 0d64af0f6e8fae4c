//! Samples of outgoing lobes on the angular map at the resolutions that an atlas uses.

use std::sync::OnceLock;

use brdfit_brdf::{Brdf, Direction, Directions, FixedOutgoing};

use crate::lobe::mapping::AngularMap;

/// Texels along a side of the map of a lobe.
pub const LOBE_TEXELS: usize = 64;

/// The coarsest resolution; each further one has twice as many samples along a side.
pub(crate) const BASE: usize = 256;

/// Levels of the transform at the coarsest resolution.
pub(crate) const BASE_LEVELS: usize = 6;

/// Resolutions: 256, 512, 1024.
pub(crate) const RESOLUTIONS: usize = 3;

/// Strips into which the rows of an image are divided.
const STRIPS: usize = 32;

/// Directions and scales of the samples of a few rows.
#[derive(Debug)]
struct Strip {
    directions: Directions,
    /// Base 2 logarithm of cycles per radian in one cycle per sample.
    log2_scale: Vec<f32>,
}

/// The samples of all resolutions; independent of the material and computed on demand. Share one between materials:
/// at most 25 MB.
#[derive(Debug)]
pub struct LobeGrid {
    strips: [Vec<OnceLock<Strip>>; RESOLUTIONS],
}

impl Default for LobeGrid {
    fn default() -> Self {
        Self { strips: std::array::from_fn(|_| (0..STRIPS).map(|_| OnceLock::new()).collect()) }
    }
}

/// Samples along a side.
pub(crate) const fn size(resolution: usize) -> usize {
    BASE << resolution
}

/// The strip of a row, and where the row begins in it.
fn place(resolution: usize, row: usize) -> (usize, usize) {
    let rows = size(resolution) / STRIPS;
    (row / rows, row % rows * size(resolution))
}

impl LobeGrid {
    fn strip(&self, resolution: usize, strip: usize) -> &Strip {
        self.strips[resolution][strip].get_or_init(|| {
            let map = AngularMap::new(size(resolution));
            let rows = map.size() / STRIPS;
            let texels = || (strip * rows..(strip + 1) * rows).flat_map(|r| (0..map.size()).map(move |c| (r, c)));
            Strip {
                directions: texels().map(|(r, c)| map.direction(r, c)).collect(),
                log2_scale: texels().map(|(r, c)| libm::log2(map.cycles_per_radian(r, c)) as f32).collect(),
            }
        })
    }

    /// Base 2 logarithm of cycles per radian in one cycle per sample, along a row.
    pub(crate) fn log2_scale(&self, resolution: usize, row: usize) -> &[f32] {
        // mirror symmetric: the other half needs not be there
        let row = row.min(size(resolution) - 1 - row);
        let (strip, first) = place(resolution, row);
        &self.strip(resolution, strip).log2_scale[first..][..size(resolution)]
    }
}

/// A material prepared for sampling on a [`LobeGrid`].
pub(crate) struct LobeSampler<'a> {
    brdf: &'a dyn Brdf,
    grid: &'a LobeGrid,
    prepared: [Vec<OnceLock<Box<dyn FixedOutgoing + 'a>>>; RESOLUTIONS],
}

impl<'a> LobeSampler<'a> {
    pub(crate) fn new(brdf: &'a dyn Brdf, grid: &'a LobeGrid) -> Self {
        Self { brdf, grid, prepared: std::array::from_fn(|_| (0..STRIPS).map(|_| OnceLock::new()).collect()) }
    }

    pub(crate) fn grid(&self) -> &'a LobeGrid {
        self.grid
    }

    /// Writes `f(i, .)` in 1/sr at the samples `first ..` of a row.
    pub(crate) fn row(&self, resolution: usize, i: &Direction, row: usize, first: usize, values: [&mut [f32]; 3]) {
        let (strip, start) = place(resolution, row);
        let lobes = self.prepared[resolution][strip]
            .get_or_init(|| self.brdf.towards(&self.grid.strip(resolution, strip).directions));
        lobes.values(i, start + first, values);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use brdfit_brdf::direction;

    /// Of which values tell the direction.
    struct Coordinates;

    impl Brdf for Coordinates {
        fn value(&self, _: &Direction, o: &Direction) -> [f64; 3] {
            [o.x, o.y, o.z]
        }
    }

    #[test]
    fn rows_are_those_of_the_angular_map() {
        let (grid, i) = (LobeGrid::default(), direction(0.3, 0.0));
        let samples = LobeSampler::new(&Coordinates, &grid);
        for resolution in 0..RESOLUTIONS {
            let map = AngularMap::new(size(resolution));
            for row in [0, 1, size(resolution) / 2 - 1, size(resolution) / 2, size(resolution) - 1] {
                let first = size(resolution) / 3;
                let [mut x, mut y, mut z] = [0, 1, 2].map(|_| vec![0.0; 40]);
                samples.row(resolution, &i, row, first, [&mut x, &mut y, &mut z]);
                let scale = grid.log2_scale(resolution, row);
                assert_eq!(scale.len(), size(resolution));
                for n in 0..40 {
                    let expected = map.direction(row, first + n);
                    let found = Direction::new(f64::from(x[n]), f64::from(y[n]), f64::from(z[n]));
                    assert!((found - expected).norm() < 1e-6);
                    let expected = libm::log2(map.cycles_per_radian(row, first + n));
                    assert!((f64::from(scale[first + n]) - expected).abs() < 1e-6);
                }
            }
        }
    }
}
