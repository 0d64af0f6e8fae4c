//! The cells of the pyramid: blocks of 2^k x 2^k pixels, and the surface that each stands for.

use rayon::prelude::*;

use crate::Vec3;
use crate::geometry::gbuffer::{BACKGROUND, GBuffer};
use crate::passes::image_bandwidth::COARSEST_LEVEL;

/// Depths of a coherent cell differ from their mean by less than this share of it.
const DEPTH_TOLERANCE: f32 = 0.03;
/// Four unit normals of a coherent cell have a sum longer than this.
const NORMAL_SUM: f32 = 3.6;

/// The surface of a cell.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cell {
    /// Point on the surface, world units.
    pub position: Vec3,
    /// Distance to the eye, world units.
    pub depth: f32,
    /// Unit normal.
    pub normal: Vec3,
    /// Index of the material, [`BACKGROUND`] where the cell has no surface.
    pub material: u16,
    /// Whether the four pixels at the centre belong together: then the cell is their mean. Otherwise it is the pixel of a
    /// surface that is nearest to the centre.
    pub coherent: bool,
}

impl Cell {
    const EMPTY: Self = Self {
        position: Vec3::new(0.0, 0.0, 0.0),
        depth: 0.0,
        normal: Vec3::new(0.0, 0.0, 0.0),
        material: BACKGROUND,
        coherent: false,
    };

    /// The cell of a single pixel.
    #[inline]
    pub fn of_pixel(gbuffer: &GBuffer, pixel: usize) -> Self {
        Self {
            position: gbuffer.position[pixel],
            depth: gbuffer.depth[pixel],
            normal: gbuffer.normal[pixel],
            material: gbuffer.material[pixel],
            coherent: true,
        }
    }

    /// Whether there is no surface.
    #[inline]
    pub fn is_empty(&self) -> bool {
        self.material == BACKGROUND
    }

    /// Mean of the distances of the point of either cell to the tangent plane of the other, world units.
    #[inline]
    pub fn plane_distance(&self, other: &Self) -> f32 {
        let between = other.position - self.position;
        0.5 * (between.dot(&self.normal).abs() + between.dot(&other.normal).abs())
    }
}

/// Columns and rows of the cells of a level: `ceil(W / 2^k) x ceil(H / 2^k)`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Extent {
    /// Columns.
    pub width: usize,
    /// Rows.
    pub height: usize,
}

impl Extent {
    /// The cells of level `k` of an image.
    pub fn of_level(gbuffer: &GBuffer, k: usize) -> Self {
        Self { width: gbuffer.width.div_ceil(1 << k), height: gbuffer.height.div_ceil(1 << k) }
    }

    /// Number of cells.
    pub fn count(&self) -> usize {
        self.width * self.height
    }
}

/// The cells of levels 1 to 5; those of level 0 are the pixels.
#[derive(Clone, Debug, Default)]
pub struct Cells {
    levels: [Vec<Cell>; COARSEST_LEVEL],
}

impl Cells {
    /// The cell of a level and index.
    #[inline]
    pub fn at(&self, gbuffer: &GBuffer, k: usize, index: usize) -> Cell {
        if k == 0 { Cell::of_pixel(gbuffer, index) } else { self.levels[k - 1][index] }
    }

    /// The cells of a level from 1.
    pub fn level(&self, k: usize) -> &[Cell] {
        &self.levels[k - 1]
    }

    /// Computes the cells of all levels.
    pub(crate) fn compute(&mut self, gbuffer: &GBuffer) {
        for (k, cells) in (1..).zip(&mut self.levels) {
            let extent = Extent::of_level(gbuffer, k);
            cells.clear();
            cells.resize(extent.count(), Cell::EMPTY);
            cells.par_chunks_mut(extent.width).enumerate().for_each(|(row, cells)| {
                for (column, cell) in cells.iter_mut().enumerate() {
                    *cell = cell_at(gbuffer, k, column, row);
                }
            });
        }
    }
}

/// The four pixels around the centre of a cell, where all exist.
pub(crate) fn central_pixels(gbuffer: &GBuffer, k: usize, column: usize, row: usize) -> Option<[usize; 4]> {
    let centre = |at: usize| (at << k) + (1 << (k - 1)) - 1;
    let (x, y) = (centre(column), centre(row));
    let first = y * gbuffer.width + x;
    (x + 1 < gbuffer.width && y + 1 < gbuffer.height)
        .then(|| [first, first + 1, first + gbuffer.width, first + gbuffer.width + 1])
}

fn cell_at(gbuffer: &GBuffer, k: usize, column: usize, row: usize) -> Cell {
    let coherent = central_pixels(gbuffer, k, column, row).and_then(|four| coherent_cell(gbuffer, four));
    coherent.or_else(|| nearest_pixel(gbuffer, k, column, row).map(|pixel| lone(gbuffer, pixel))).unwrap_or(Cell::EMPTY)
}

fn lone(gbuffer: &GBuffer, pixel: usize) -> Cell {
    Cell { coherent: false, ..Cell::of_pixel(gbuffer, pixel) }
}

/// The mean of four pixels of one surface.
fn coherent_cell(gbuffer: &GBuffer, four: [usize; 4]) -> Option<Cell> {
    let material = gbuffer.material[four[0]];
    if material == BACKGROUND || four.iter().any(|&pixel| gbuffer.material[pixel] != material) {
        return None;
    }
    let sum = |vectors: &[Vec3]| four.iter().fold(Vec3::zeros(), |sum, &pixel| sum + vectors[pixel]);
    let depth = 0.25 * four.iter().map(|&pixel| gbuffer.depth[pixel]).sum::<f32>();
    let normal = sum(&gbuffer.normal);
    let length = normal.norm();
    let apart = |&pixel: &usize| (gbuffer.depth[pixel] - depth).abs() >= DEPTH_TOLERANCE * depth;
    (length > NORMAL_SUM && !four.iter().any(apart)).then(|| Cell {
        position: 0.25 * sum(&gbuffer.position),
        depth,
        normal: normal / length,
        material,
        coherent: true,
    })
}

/// The pixel of a surface that is nearest to the centre of a cell, the first in row order on a tie.
fn nearest_pixel(gbuffer: &GBuffer, k: usize, column: usize, row: usize) -> Option<usize> {
    let side = 1_usize << k;
    let (left, top) = (column * side, row * side);
    let off = |at: usize, first: usize| (2 * (at - first)).abs_diff(side - 1).pow(2);
    let mut best: Option<(usize, usize)> = None;
    for y in top..(top + side).min(gbuffer.height) {
        for x in left..(left + side).min(gbuffer.width) {
            let pixel = y * gbuffer.width + x;
            if gbuffer.material[pixel] != BACKGROUND {
                let distance = off(x, left) + off(y, top);
                if best.is_none_or(|(least, _)| distance < least) {
                    best = Some((distance, pixel));
                }
            }
        }
    }
    best.map(|(_, pixel)| pixel)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_scenes::sphere;

    #[test]
    fn cells_of_a_sphere_are_coherent_inside_and_lie_on_it() {
        let gbuffer = sphere(96, 4.0);
        let mut cells = Cells::default();
        cells.compute(&gbuffer);
        for k in 1..=COARSEST_LEVEL {
            let extent = Extent::of_level(&gbuffer, k);
            assert_eq!(cells.level(k).len(), extent.count());
            for cell in cells.level(k).iter().filter(|cell| !cell.is_empty()) {
                assert!((cell.position.norm() - 1.0).abs() < 0.02, "level {k}: {cell:?}");
                assert!((cell.normal.norm() - 1.0).abs() < 1e-5);
                let facing = cell.normal.dot(&(Vec3::new(4.0, 0.0, 0.0) - cell.position).normalize());
                assert!(cell.coherent || facing < 0.6, "level {k}: {cell:?}");
            }
        }
        assert!(cells.level(3)[0].is_empty() && !cells.level(5)[0].is_empty());
    }

    #[test]
    fn cells_at_the_border_of_odd_images_are_single_pixels() {
        let gbuffer = sphere(7, 4.0);
        let mut cells = Cells::default();
        cells.compute(&gbuffer);
        // 7 pixels: the last cell of level 1 has one column
        assert_eq!(Extent::of_level(&gbuffer, 1), Extent { width: 4, height: 4 });
        assert!(cells.level(1).iter().enumerate().all(|(n, cell)| n % 4 != 3 || !cell.coherent));
        assert_eq!(nearest_pixel(&gbuffer, 3, 0, 0), Some(3 * 7 + 3));
    }

    #[test]
    fn pixels_of_two_materials_make_no_coherent_cell() {
        let mut gbuffer = sphere(32, 4.0);
        for pixel in 0..32 * 32 {
            if pixel % 32 >= 15 && gbuffer.material[pixel] != BACKGROUND {
                gbuffer.material[pixel] = 1;
            }
        }
        let mut cells = Cells::default();
        cells.compute(&gbuffer);
        // columns 14 and 15 lie in one cell of two pixels
        let cell = cells.level(1)[8 * 16 + 7];
        assert!(!cell.coherent && cell.material == 0);
        assert!(cells.level(1)[8 * 16 + 8].coherent);
    }
}
