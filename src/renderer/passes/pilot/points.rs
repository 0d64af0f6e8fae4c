//! The pilot points: one per material in each tile of 4 x 4 pixels.

use std::ops::Range;

use rayon::prelude::*;

use crate::geometry::gbuffer::GBuffer;

/// Pixels along the side of a tile.
pub(crate) const TILE: usize = 4;
/// The index of pixels without a pilot point.
const NONE: u32 = u32::MAX;

/// The points of the pilot.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct PilotPoints {
    /// Point of each pixel, or [`u32::MAX`] in the background.
    pub(crate) of_pixel: Vec<u32>,
    /// The pixel that each point lies at, sorted by material.
    pub(crate) pixels: Vec<u32>,
}

impl PilotPoints {
    /// Finds the points: per tile and material present the pixel nearest to the tile's centre. Returns the points of each
    /// material.
    pub(crate) fn place(&mut self, gbuffer: &GBuffer, materials: usize) -> Vec<Range<usize>> {
        let (width, height) = (gbuffer.width, gbuffer.height);
        let rows: Vec<Vec<(u16, u32)>> = (0..height.div_ceil(TILE))
            .into_par_iter()
            .map(|row| {
                let mut found = Vec::new();
                for column in 0..width.div_ceil(TILE) {
                    points_of_tile(gbuffer, [column * TILE, row * TILE], &mut found);
                }
                found
            })
            .collect();
        let mut groups = vec![0..0; materials];
        let mut first = 0;
        self.pixels.clear();
        for (material, group) in groups.iter_mut().enumerate() {
            let of_material = |&&(of, _): &&(u16, u32)| usize::from(of) == material;
            self.pixels.extend(rows.iter().flatten().filter(of_material).map(|&(_, pixel)| pixel));
            *group = first..self.pixels.len();
            first = self.pixels.len();
        }
        self.spread(gbuffer);
        groups
    }

    /// Tells every pixel its point.
    fn spread(&mut self, gbuffer: &GBuffer) {
        self.of_pixel.clear();
        self.of_pixel.resize(gbuffer.material.len(), NONE);
        for (point, &pixel) in self.pixels.iter().enumerate() {
            let corner = gbuffer.place(pixel as usize).map(|at| at / TILE * TILE);
            for (other, _) in gbuffer.surfaces_in_block(corner, TILE) {
                if gbuffer.material[other] == gbuffer.material[pixel as usize] {
                    self.of_pixel[other] = point as u32;
                }
            }
        }
    }
}

/// Adds, for each material in the tile, the pixel that is nearest to the tile's centre, the first in row order on a tie.
fn points_of_tile(gbuffer: &GBuffer, corner: [usize; 2], found: &mut Vec<(u16, u32)>) {
    let mine = found.len();
    let mut distances = [0_usize; TILE * TILE];
    for (pixel, distance) in gbuffer.surfaces_in_block(corner, TILE) {
        let material = gbuffer.material[pixel];
        match found[mine..].iter().position(|&(of, _)| of == material) {
            Some(n) if distance < distances[n] => {
                found[mine + n].1 = pixel as u32;
                distances[n] = distance;
            }
            Some(_) => {}
            None => {
                distances[found.len() - mine] = distance;
                found.push((material, pixel as u32));
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::gbuffer::BACKGROUND;
    use crate::test_scenes::plane;

    /// A tile and the left half of another, 6 x 4 pixels, three materials and a hole.
    #[test]
    fn every_material_of_a_tile_has_a_point_near_its_centre() {
        let mut gbuffer = plane(6, 4, 1.0);
        gbuffer.material = [
            [0, 0, 0, 0, 2, 2], //
            [0, 0, BACKGROUND, 0, 2, 2],
            [1, 1, BACKGROUND, 0, 2, 2],
            [1, 1, 1, 1, 2, BACKGROUND],
        ]
        .concat();
        let mut points = PilotPoints::default();
        let groups = points.place(&gbuffer, 4);
        assert_eq!(groups, [0..1, 1..2, 2..3, 3..3]);
        // nearest to (1.5, 1.5): of material 0 (1, 1), of material 1 (1, 2); of material 2 to (5.5, 1.5) (5, 1) before (5, 2)
        assert_eq!(points.pixels, [7, 13, 11]);
        let none = NONE;
        let expected =
            [[0, 0, 0, 0, 2, 2], [0, 0, none, 0, 2, 2], [1, 1, none, 0, 2, 2], [1, 1, 1, 1, 2, none]].concat();
        assert_eq!(points.of_pixel, expected);
    }
}
