//! What the passes leave behind, as layers of a file.

use crate::frame::renderer::Renderer;
use crate::geometry::differentials::Differentials;
use crate::geometry::gbuffer::{BACKGROUND, GBuffer};
use crate::images::film::Film;
use crate::lights::light_set::LightSet;
use crate::passes::decision::{DecisionLevel, State};
use crate::passes::image_bandwidth::COARSEST_LEVEL;
use crate::passes::pilot::Prediction;

/// A group of layers.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Pass {
    /// `position`, `normal`, `view`, `albedo`, `uv`, `depth`, `material`, and the differentials `spread` (radians per pixel) and
    /// `curvature` (1 per world unit).
    GBuffer,
    /// `light.NU`: bandwidth of the light in the mirror direction, cycles per radian; -1 for the infinite one of an edge.
    Light,
    /// `pilot`: `MEAN`, `VARIANCE` (of one sample) of the luminance, `NU` (cycles per radian), `EQ9`.
    Pilot,
    /// `bandwidth.Y` in cycles per pixel and `level.Y`, -1 in the background.
    Bandwidth,
    /// `decision`: channels `L0` to `L5`, the state of the cell of each level: 0 empty, 1 leaf, 2 refined, 3 interpolated, 4 orphan,
    /// 5 invalid.
    Decision,
    /// `list`: `LEVEL` of the cell that a pixel lies in and is shaded by, or -1 where it is interpolated from several; `SAMPLES` of
    /// that cell per pixel; `FILTERED` 1 where its light is prefiltered.
    List,
    /// `upsampled`: R, G, B, radiance with a texture of 1, before the resolve.
    Upsampled,
}

impl Pass {
    /// All of them, in the order of the frame.
    pub const ALL: [Self; 7] =
        [Self::GBuffer, Self::Light, Self::Pilot, Self::Bandwidth, Self::Decision, Self::List, Self::Upsampled];
}

impl Renderer {
    /// Adds the layers of a pass of the last frame to a film. Passes that the mode leaves out add nothing.
    #[must_use]
    pub fn add_to(
        &self,
        film: Film,
        pass: Pass,
        gbuffer: &GBuffer,
        differentials: &Differentials,
        lights: &LightSet,
    ) -> Film {
        let pixels = 0..gbuffer.material.len();
        let predicted = self.pilot.of_pixel.len() == pixels.len();
        let divided = self.bandwidth_buffer.level.len() == pixels.len();
        match pass {
            Pass::GBuffer => gbuffer
                .add_to(film)
                .scalar("spread", differentials.spread.iter().copied())
                .scalar("curvature", differentials.curvature.iter().copied()),
            Pass::Light => film.layer(
                "light",
                ["NU"],
                pixels.map(|pixel| {
                    let mirror = gbuffer.mirror_direction(pixel);
                    let bandwidth = lights.bandwidth(gbuffer.position[pixel], mirror);
                    let shown = if bandwidth.is_finite() { bandwidth } else { -1.0 };
                    [if gbuffer.material[pixel] == BACKGROUND { 0.0 } else { shown }]
                }),
            ),
            Pass::Pilot if predicted => film.layer(
                "pilot",
                ["MEAN", "VARIANCE", "NU", "EQ9"],
                pixels.map(|pixel| {
                    let Prediction { bandwidth, mean, variance, printed, .. } =
                        self.pilot.at(pixel).copied().unwrap_or_default();
                    [mean, variance, bandwidth, printed]
                }),
            ),
            Pass::Bandwidth if divided => {
                let level = |&level: &u8| if usize::from(level) > COARSEST_LEVEL { -1.0 } else { f32::from(level) };
                film.scalar("bandwidth", self.bandwidth_buffer.bandwidth.iter().copied())
                    .scalar("level", self.bandwidth_buffer.level.iter().map(level))
            }
            Pass::Decision if divided => {
                let state = |pixel: usize, k: usize| {
                    let level = &self.decisions.levels[k];
                    f32::from(level.state[cell_of(gbuffer, level, pixel, k)] as u8)
                };
                let states = pixels.map(|pixel| [0, 1, 2, 3, 4, 5].map(|k| state(pixel, k)));
                film.layer("decision", ["L0", "L1", "L2", "L3", "L4", "L5"], states)
            }
            Pass::List => {
                let shading = self.shading_of_pixels(gbuffer);
                film.layer("list", ["LEVEL", "SAMPLES", "FILTERED"], shading.into_iter())
            }
            Pass::Upsampled => film.layer("upsampled", ["R", "G", "B"], self.upsampled()),
            Pass::Pilot | Pass::Bandwidth | Pass::Decision => film,
        }
    }

    /// Radiance of each pixel of the last frame with a texture of 1, before the resolve; zeros in the background.
    pub fn upsampled(&self) -> impl Iterator<Item = [f32; 3]> + Clone {
        self.values.levels[0].iter().zip(&self.decisions.levels[0].state).map(|(value, &state)| {
            let [r, g, b, _] = value.to_array();
            if state == State::Empty { [0.0; 3] } else { [r, g, b] }
        })
    }

    /// For each pixel the level of the shaded cell that it lies in (-1 without one), samples per pixel there, and whether the light was
    /// prefiltered. The map of where a picture was shaded.
    #[must_use]
    pub fn shading_of_pixels(&self, gbuffer: &GBuffer) -> Vec<[f32; 3]> {
        let mut shading = vec![[-1.0, 0.0, 0.0]; gbuffer.material.len()];
        // coarse to fine: an orphan inside a leaf shows itself
        let mut points: Vec<_> = self.list.points.iter().collect();
        points.sort_by_key(|point| std::cmp::Reverse(point.level));
        for point in points {
            let k = usize::from(point.level);
            let (left, top) = (usize::from(point.column) << k, usize::from(point.row) << k);
            let samples = point.samples as f32 / (1_u32 << (2 * k)) as f32;
            for y in top..(top + (1 << k)).min(gbuffer.height) {
                for x in left..(left + (1 << k)).min(gbuffer.width) {
                    let pixel = y * gbuffer.width + x;
                    if gbuffer.material[pixel] == point.material {
                        shading[pixel] = [k as f32, samples, f32::from(u8::from(point.filtered))];
                    }
                }
            }
        }
        shading
    }
}

/// The cell of a level that a pixel lies in.
fn cell_of(gbuffer: &GBuffer, level: &DecisionLevel, pixel: usize, k: usize) -> usize {
    let (x, y) = (pixel % gbuffer.width, pixel / gbuffer.width);
    (y >> k) * level.extent.width + (x >> k)
}

const _: () = assert!(State::Invalid as u8 == 5, "the documented numbers of the states");
