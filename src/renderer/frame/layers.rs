//! The buffers of the passes as layers of an image.

use crate::frame::buffers::FrameBuffers;
use crate::frame::input::FrameInput;
use crate::geometry::gbuffer::{BACKGROUND, GBuffer};
use crate::images::layer::Layer;
use crate::lights::light_set::LightSet;
use crate::passes::decision::State;
use crate::passes::image_bandwidth::COARSEST_LEVEL;

/// The layers that come from one place of the frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum LayerGroup {
    /// `position` (X, Y, Z), `normal` (X, Y, Z), `view` (X, Y, Z), `albedo` (R, G, B), `uv` (U, V), `depth` (Z), `material` (Y), and the
    /// differentials `spread` (radians per pixel) and `curvature` (1 per world unit). In the background all are 0, the depth too, and
    /// the material is -1.
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

impl LayerGroup {
    /// All of them, in the order of the frame.
    pub const ALL: [Self; 7] =
        [Self::GBuffer, Self::Light, Self::Pilot, Self::Bandwidth, Self::Decision, Self::List, Self::Upsampled];
}

/// The layers of a group; none where the mode of the frame left the pass out or no frame has been rendered.
pub(crate) fn layers(group: LayerGroup, input: &FrameInput<'_>, buffers: &FrameBuffers) -> Vec<Layer> {
    let gbuffer = input.gbuffer();
    match group {
        LayerGroup::GBuffer => surface_layers(input),
        LayerGroup::Light => vec![light_layer(gbuffer, input.lights())],
        LayerGroup::Pilot if buffers.is_predicted() => vec![pilot_layer(buffers)],
        LayerGroup::Bandwidth if buffers.is_divided() => bandwidth_layers(buffers),
        LayerGroup::Decision if buffers.is_divided() => vec![decision_layer(gbuffer, buffers)],
        LayerGroup::List if buffers.is_rendered() => vec![list_layer(gbuffer, buffers)],
        LayerGroup::Upsampled if buffers.is_rendered() => vec![upsampled_layer(buffers)],
        _ => Vec::new(),
    }
}

/// The visible surface and its differentials.
fn surface_layers(input: &FrameInput<'_>) -> Vec<Layer> {
    let (gbuffer, differentials) = (input.gbuffer(), input.differentials());
    let depth = |(&z, &material): (&f32, &u16)| [if material == BACKGROUND { 0.0 } else { z }];
    let material = |&index: &u16| if index == BACKGROUND { -1.0 } else { f32::from(index) };
    vec![
        Layer::new("position", ["X", "Y", "Z"], gbuffer.position.iter().map(|&p| p.into())),
        Layer::new("normal", ["X", "Y", "Z"], gbuffer.normal.iter().map(|&n| n.into())),
        Layer::new("view", ["X", "Y", "Z"], gbuffer.view.iter().map(|&v| v.into())),
        Layer::new("albedo", ["R", "G", "B"], gbuffer.albedo.iter().copied()),
        Layer::new("uv", ["U", "V"], gbuffer.uv.iter().copied()),
        Layer::new("depth", ["Z"], gbuffer.depth.iter().zip(&gbuffer.material).map(depth)),
        Layer::scalar("material", gbuffer.material.iter().map(material)),
        Layer::scalar("spread", differentials.spread.iter().copied()),
        Layer::scalar("curvature", differentials.curvature.iter().copied()),
    ]
}

/// The largest bandwidth of the lights in the mirror direction of every pixel.
fn light_layer(gbuffer: &GBuffer, lights: &LightSet) -> Layer {
    let mirrored = |pixel: usize| {
        if gbuffer.material[pixel] == BACKGROUND {
            return [0.0];
        }
        [finite_or_minus_one(lights.bandwidth(gbuffer.position[pixel], gbuffer.mirror_direction(pixel)))]
    };
    Layer::new("light", ["NU"], (0..gbuffer.material.len()).map(mirrored))
}

/// A bandwidth as files hold it: -1 for the infinite one of an edge.
#[must_use]
pub fn finite_or_minus_one(bandwidth: f32) -> f32 {
    if bandwidth.is_finite() { bandwidth } else { -1.0 }
}

fn pilot_layer(buffers: &FrameBuffers) -> Layer {
    let predicted = |pixel: usize| {
        let prediction = buffers.pilot.at(pixel).copied().unwrap_or_default();
        [prediction.mean, prediction.variance, prediction.bandwidth, prediction.published]
    };
    Layer::new("pilot", ["MEAN", "VARIANCE", "NU", "EQ9"], (0..buffers.pixels()).map(predicted))
}

fn bandwidth_layers(buffers: &FrameBuffers) -> Vec<Layer> {
    let level = |&level: &u8| if usize::from(level) > COARSEST_LEVEL { -1.0 } else { f32::from(level) };
    vec![
        Layer::scalar("bandwidth", buffers.bandwidth.bandwidth.iter().copied()),
        Layer::scalar("level", buffers.bandwidth.level.iter().map(level)),
    ]
}

/// The state of the cell of each level that a pixel lies in.
fn decision_layer(gbuffer: &GBuffer, buffers: &FrameBuffers) -> Layer {
    let state = |[x, y]: [usize; 2], k: usize| {
        let level = &buffers.decisions.levels[k];
        f32::from(level.state[(y >> k) * level.extent.width + (x >> k)] as u8)
    };
    let states = |pixel: usize| [0, 1, 2, 3, 4, 5].map(|k| state(gbuffer.place(pixel), k));
    Layer::new("decision", ["L0", "L1", "L2", "L3", "L4", "L5"], (0..buffers.pixels()).map(states))
}

/// The map of where an image was shaded.
fn list_layer(gbuffer: &GBuffer, buffers: &FrameBuffers) -> Layer {
    let (points, counts) = (&buffers.list.points, &buffers.counts);
    let mut shading = vec![[-1.0, 0.0, 0.0]; gbuffer.material.len()];
    // coarse to fine: an orphan inside a leaf shows itself
    let mut order: Vec<usize> = (0..points.len()).collect();
    order.sort_by_key(|&n| std::cmp::Reverse(points[n].level));
    for n in order {
        let k = usize::from(points[n].level);
        let corner = [usize::from(points[n].column) << k, usize::from(points[n].row) << k];
        let samples = counts.samples[n] as f32 / (1_u32 << (2 * k)) as f32;
        let filtered = f32::from(u8::from(counts.prefiltered[n]));
        for (pixel, _) in gbuffer.surfaces_in_block(corner, 1 << k) {
            if gbuffer.material[pixel] == points[n].material {
                shading[pixel] = [k as f32, samples, filtered];
            }
        }
    }
    Layer::new("list", ["LEVEL", "SAMPLES", "FILTERED"], shading.into_iter())
}

/// Radiance with a texture of 1; zeros in the background.
fn upsampled_layer(buffers: &FrameBuffers) -> Layer {
    let values = buffers.radiance.levels[0].iter().zip(&buffers.decisions.levels[0].state);
    let colour = |(value, &state): (&wide::f32x4, &State)| {
        let [r, g, b, _] = value.to_array();
        if state == State::Empty { [0.0; 3] } else { [r, g, b] }
    };
    Layer::new("upsampled", ["R", "G", "B"], values.map(colour))
}

const _: () = assert!(State::Invalid as u8 == 5, "the documented numbers of the states");
