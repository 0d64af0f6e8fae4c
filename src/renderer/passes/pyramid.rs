//! The surface pyramid: cells of 2^k x 2^k pixels, and the surface that each represents.

use rayon::prelude::*;

use crate::geometry::gbuffer::{BACKGROUND, GBuffer};
use crate::geometry::vec3::Vec3;
use crate::passes::image_bandwidth::COARSEST_LEVEL;
use crate::passes::pass::Pass;

/// Depths of a coherent cell differ from their mean by less than this share of it.
const DEPTH_TOLERANCE: f32 = 0.03;
/// Four unit normals of a coherent cell have a sum longer than this.
const NORMAL_SUM: f32 = 3.6;

/// The surface of a cell.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Cell {
    /// Point on the surface, world units.
    pub(crate) position: Vec3,
    /// Distance to the eye, world units.
    pub(crate) depth: f32,
    /// Unit normal.
    pub(crate) normal: Vec3,
    /// Index of the material, [`BACKGROUND`] where the cell has no surface.
    pub(crate) material: u16,
    /// Whether the four pixels at the centre belong together: then the cell is their mean. Otherwise it is the pixel of a
    /// surface that is nearest to the centre.
    pub(crate) coherent: bool,
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
    pub(crate) fn of_pixel(gbuffer: &GBuffer, pixel: usize) -> Self {
        Self {
            position: gbuffer.position[pixel],
            depth: gbuffer.depth[pixel],
            normal: gbuffer.normal[pixel],
            material: gbuffer.material[pixel],
            coherent: true,
        }
    }

    /// Mean of the distances of the point of either cell to the tangent plane of the other, world units.
    #[inline]
    pub(crate) fn plane_distance(&self, other: &Self) -> f32 {
        let between = other.position - self.position;
        0.5 * (between.dot(&self.normal).abs() + between.dot(&other.normal).abs())
    }
}

/// Columns and rows of the cells of a level: `ceil(W / 2^k) x ceil(H / 2^k)`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Extent {
    /// Columns.
    pub(crate) width: usize,
    /// Rows.
    pub(crate) height: usize,
}

impl Extent {
    /// The cells of level `k` of an image.
    pub(crate) fn of_level(gbuffer: &GBuffer, k: usize) -> Self {
        Self { width: gbuffer.width.div_ceil(1 << k), height: gbuffer.height.div_ceil(1 << k) }
    }

    /// Number of cells.
    pub(crate) fn count(&self) -> usize {
        self.width * self.height
    }
}

/// The cells of levels 1 to 5; those of level 0 are the pixels of the G-buffer.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct SurfacePyramid {
    levels: [Vec<Cell>; COARSEST_LEVEL],
}

impl SurfacePyramid {
    /// The cell of a level and index.
    #[inline]
    pub(crate) fn at(&self, gbuffer: &GBuffer, k: usize, index: usize) -> Cell {
        if k == 0 { Cell::of_pixel(gbuffer, index) } else { self.levels[k - 1][index] }
    }

    /// The cells that are held for a level: none for level 0, whose cells are the pixels.
    pub(crate) fn level(&self, k: usize) -> &[Cell] {
        k.checked_sub(1).map_or(&[], |k| &self.levels[k])
    }
}

/// Computes the cells of all levels.
pub(crate) struct PyramidPass<'a> {
    pub(crate) gbuffer: &'a GBuffer,
}

impl Pass for PyramidPass<'_> {
    type Output = SurfacePyramid;

    fn run(&self, pyramid: &mut SurfacePyramid) {
        for (k, cells) in (1..).zip(&mut pyramid.levels) {
            let extent = Extent::of_level(self.gbuffer, k);
            cells.clear();
            cells.resize(extent.count(), Cell::EMPTY);
            cells.par_chunks_mut(extent.width).enumerate().for_each(|(row, cells)| {
                for (column, cell) in cells.iter_mut().enumerate() {
                    *cell = cell_at(self.gbuffer, k, column, row);
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
    let pixels = gbuffer.surfaces_in_block([column << k, row << k], 1 << k);
    pixels.min_by_key(|&(_, distance)| distance).map(|(pixel, _)| pixel)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_scenes::sphere;

    fn pyramid(gbuffer: &GBuffer) -> SurfacePyramid {
        let mut pyramid = SurfacePyramid::default();
        PyramidPass { gbuffer }.run(&mut pyramid);
        pyramid
    }

    #[test]
    fn cells_of_a_sphere_are_coherent_inside_and_lie_on_it() {
        let gbuffer = sphere(96, 4.0);
        let pyramid = pyramid(&gbuffer);
        for k in 1..=COARSEST_LEVEL {
            let extent = Extent::of_level(&gbuffer, k);
            assert_eq!(pyramid.level(k).len(), extent.count());
            for cell in pyramid.level(k).iter().filter(|cell| cell.material != BACKGROUND) {
                assert!((cell.position.norm() - 1.0).abs() < 0.02, "level {k}: {cell:?}");
                assert!((cell.normal.norm() - 1.0).abs() < 1e-5);
                let facing = cell.normal.dot(&(Vec3::new(4.0, 0.0, 0.0) - cell.position).normalize());
                assert!(cell.coherent || facing < 0.6, "level {k}: {cell:?}");
            }
        }
        assert!(pyramid.level(0).is_empty(), "the cells of level 0 are the pixels");
        assert!(pyramid.level(3)[0].material == BACKGROUND && pyramid.level(5)[0].material == 0);
    }

    #[test]
    fn cells_at_the_border_of_odd_images_are_single_pixels() {
        let gbuffer = sphere(7, 4.0);
        let pyramid = pyramid(&gbuffer);
        // 7 pixels: the last cell of level 1 has one column
        assert_eq!(Extent::of_level(&gbuffer, 1), Extent { width: 4, height: 4 });
        assert!(pyramid.level(1).iter().enumerate().all(|(n, cell)| n % 4 != 3 || !cell.coherent));
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
        let pyramid = pyramid(&gbuffer);
        // columns 14 and 15 lie in one cell of two pixels
        let cell = pyramid.level(1)[8 * 16 + 7];
        assert!(!cell.coherent && cell.material == 0);
        assert!(pyramid.level(1)[8 * 16 + 8].coherent);
    }
}
