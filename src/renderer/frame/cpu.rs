//! The passes of a frame on the processors of the current thread pool.

use std::time::{Duration, Instant};

use crate::frame::backend::{Backend, Frame};
use crate::frame::buffers::FrameBuffers;
use crate::frame::error::FrameError;
use crate::frame::input::FrameInput;
use crate::frame::layers::{LayerGroup, layers};
use crate::frame::options::{Mode, RenderOptions};
use crate::frame::statistics::{FrameStatistics, Times};
use crate::images::layer::Layer;
use crate::passes::allocation::{Allocation, AllocationPass, Budget, EqualCountsPass, Prefilter};
use crate::passes::decision::{DecisionPass, EveryPixelPass};
use crate::passes::image_bandwidth::{COARSEST_LEVEL, Geometry, ImageBandwidth, ImageBandwidthPass};
use crate::passes::material::ShadingMaterial;
use crate::passes::pass::Pass;
use crate::passes::pilot::{Pilot, PilotPass};
use crate::passes::pyramid::PyramidPass;
use crate::passes::resolve::ResolvePass;
use crate::passes::shading::ShadingPass;
use crate::passes::shading_list::ShadingListPass;
use crate::passes::upsampling::UpsamplingPass;

/// Renders on the threads of the current pool. A frame is the same for every number of them.
#[derive(Clone, Copy, Debug, Default)]
pub struct Cpu;

/// An input of [`Cpu`] with its buffers.
pub struct CpuFrame<'a> {
    pub(crate) input: FrameInput<'a>,
    pub(crate) materials: Vec<ShadingMaterial<'a>>,
    pub(crate) buffers: FrameBuffers,
}

impl<'a> CpuFrame<'a> {
    /// The input of the frame.
    #[must_use]
    pub fn input(&self) -> &FrameInput<'a> {
        &self.input
    }
}

impl Backend for Cpu {
    type Prepared<'a> = CpuFrame<'a>;

    fn prepare<'a>(&self, input: FrameInput<'a>) -> CpuFrame<'a> {
        let materials = input.materials().iter().map(ShadingMaterial::new).collect();
        CpuFrame { input, materials, buffers: FrameBuffers::default() }
    }

    fn render(&self, prepared: &mut CpuFrame<'_>, options: &RenderOptions) -> Result<Frame, FrameError> {
        options.check()?;
        let mut times = Times::default();
        prepared.predict(options, &mut times);
        prepared.decide(options, &mut times);
        prepared.count(options, &mut times);
        let radiance = prepared.shade(options, &mut times);
        Ok(Frame { radiance, statistics: prepared.statistics(times) })
    }

    fn layers(&self, prepared: &CpuFrame<'_>, group: LayerGroup) -> Vec<Layer> {
        layers(group, &prepared.input, &prepared.buffers)
    }
}

impl CpuFrame<'_> {
    /// The pilot, and from it the image-space bandwidth, as far as the mode asks for them.
    fn predict(&mut self, options: &RenderOptions, times: &mut Times) {
        let Self { input, materials, buffers } = self;
        let gbuffer = input.gbuffer();
        if options.mode.predicts() {
            let pass = PilotPass {
                gbuffer,
                materials,
                lights: input.lights(),
                samples: options.pilot_samples,
                seed: options.seed,
                keep_paths: options.geometry != Geometry::Reflected,
            };
            timed(&mut times.pilot, &pass, &mut buffers.pilot);
        } else {
            buffers.pilot = Pilot::default();
        }
        if options.mode.divides() {
            let pass = ImageBandwidthPass {
                gbuffer,
                differentials: input.differentials(),
                pilot: &buffers.pilot,
                geometry: options.geometry,
                rate: options.sampling_rate,
            };
            timed(&mut times.bandwidth, &pass, &mut buffers.bandwidth);
        } else {
            buffers.bandwidth = ImageBandwidth::default();
        }
    }

    /// State of each cell.
    fn decide(&mut self, options: &RenderOptions, times: &mut Times) {
        let Self { input, buffers, .. } = self;
        let gbuffer = input.gbuffer();
        if options.mode.divides() {
            timed(&mut times.decisions, &PyramidPass { gbuffer }, &mut buffers.pyramid);
            let pass = DecisionPass {
                gbuffer,
                pyramid: &buffers.pyramid,
                levels: &buffers.bandwidth.level,
                upsampling: options.upsampling,
            };
            timed(&mut times.decisions, &pass, &mut buffers.decisions);
        } else {
            timed(&mut times.decisions, &EveryPixelPass { gbuffer }, &mut buffers.decisions);
        }
    }

    /// The list of shading points, and their samples.
    fn count(&mut self, options: &RenderOptions, times: &mut Times) {
        let Self { input, materials, buffers } = self;
        let gbuffer = input.gbuffer();
        let pass = ShadingListPass {
            gbuffer,
            decisions: &buffers.decisions,
            pyramid: &buffers.pyramid,
            materials: materials.len(),
        };
        timed(&mut times.list, &pass, &mut buffers.list);
        let points = &buffers.list.points;
        match (options.mode, options.budget) {
            (Mode::Reference, Budget::SamplesPerPixel(samples)) => {
                let samples = (samples.round() as u32).max(1);
                let pass = EqualCountsPass {
                    points: points.len(),
                    samples,
                    prefiltered: options.prefilter == Prefilter::Always,
                };
                timed(&mut times.list, &pass, &mut buffers.counts);
            }
            (mode, budget) => {
                let pass = AllocationPass {
                    gbuffer,
                    pilot: &buffers.pilot,
                    points,
                    allocation: if mode == Mode::AdaptivePixels { Allocation::Even } else { options.allocation },
                    budget,
                    foreground: input.foreground(),
                    prefilter: options.prefilter,
                };
                timed(&mut times.list, &pass, &mut buffers.counts);
            }
        }
    }

    /// From the list to the image.
    fn shade(&mut self, options: &RenderOptions, times: &mut Times) -> Vec<[f32; 3]> {
        let Self { input, materials, buffers } = self;
        let gbuffer = input.gbuffer();
        let (points, counts) = (&buffers.list.points, &buffers.counts);
        let pass = ShadingPass { gbuffer, materials, lights: input.lights(), seed: options.seed, points, counts };
        timed(&mut times.shading, &pass, &mut buffers.shaded);
        let pass = UpsamplingPass {
            gbuffer,
            pyramid: &buffers.pyramid,
            decisions: &buffers.decisions,
            points,
            shaded: &buffers.shaded,
        };
        timed(&mut times.upsampling, &pass, &mut buffers.radiance);
        let mut image = Vec::new();
        let pass = ResolvePass { gbuffer, radiance: &buffers.radiance.levels[0] };
        timed(&mut times.resolve, &pass, &mut image);
        image
    }

    fn statistics(&self, times: Times) -> FrameStatistics {
        let Self { input, buffers, .. } = self;
        let mut shaded = [0; COARSEST_LEVEL + 1];
        buffers.list.points.iter().for_each(|point| shaded[usize::from(point.level)] += 1);
        FrameStatistics {
            times,
            foreground: input.foreground() as u64,
            pilot_samples: buffers.pilot.samples,
            shading_samples: buffers.counts.total(),
            shaded,
            prefiltered: buffers.counts.prefiltered.iter().filter(|&&prefiltered| prefiltered).count() as u64,
        }
    }
}

/// Runs a pass and adds the time that it takes.
fn timed<P: Pass>(time: &mut Duration, pass: &P, output: &mut P::Output) {
    let start = Instant::now();
    pass.run(output);
    *time += start.elapsed();
}

#[cfg(test)]
mod tests {
    use super::*;
    use brdfit_brdf::Lambert;

    use crate::frame::options::OptionsError;
    use crate::lights::light_set::LightSet;
    use crate::lights::procedural::Procedural;
    use crate::passes::allocation::Prefilter;
    use crate::passes::material::Material;
    use crate::test_scenes::sphere;

    const CHALK: Lambert = Lambert { albedo: [0.7; 3] };

    /// The groups that have layers.
    fn groups(frame: &CpuFrame<'_>) -> Vec<LayerGroup> {
        LayerGroup::ALL.into_iter().filter(|&group| !Cpu.layers(frame, group).is_empty()).collect()
    }

    #[test]
    fn layers_are_those_of_the_passes_that_ran() {
        let lights = LightSet::from(Procedural::Sky.light(16));
        let mut frame =
            Cpu.prepare(FrameInput::new(sphere(24, 4.0), vec![Material::diffuse(&CHALK)], lights.clone()).unwrap());
        let of_the_input = [LayerGroup::GBuffer, LayerGroup::Light];
        assert_eq!(groups(&frame), of_the_input);
        let with = |mode| RenderOptions { mode, ..RenderOptions::default() };
        Cpu.render(&mut frame, &with(Mode::Adaptive)).unwrap();
        assert_eq!(groups(&frame), LayerGroup::ALL);
        Cpu.render(&mut frame, &with(Mode::AdaptiveCounts)).unwrap();
        assert_eq!(groups(&frame)[2..], [LayerGroup::Pilot, LayerGroup::List, LayerGroup::Upsampled]);
        Cpu.render(&mut frame, &with(Mode::Reference)).unwrap();
        assert_eq!(groups(&frame)[2..], [LayerGroup::List, LayerGroup::Upsampled]);
    }

    #[test]
    fn options_that_cannot_be_used_are_an_error() {
        let lights = LightSet::from(Procedural::Sky.light(16));
        let mut frame =
            Cpu.prepare(FrameInput::new(sphere(24, 4.0), vec![Material::diffuse(&CHALK)], lights.clone()).unwrap());
        let reference = RenderOptions { mode: Mode::Reference, ..RenderOptions::default() };
        for options in [
            RenderOptions { pilot_samples: 3, ..RenderOptions::default() },
            RenderOptions { budget: Budget::TargetError(0.1), ..reference },
            RenderOptions { prefilter: Prefilter::Above(0.1), ..reference },
        ] {
            let error: Result<_, OptionsError> = options.check();
            assert_eq!(Cpu.render(&mut frame, &options), Err(error.unwrap_err().into()));
        }
        assert_eq!(groups(&frame).len(), 2, "nothing was rendered");
    }

    #[test]
    fn a_frame_without_surfaces_is_black() {
        let lights = LightSet::from(Procedural::Sky.light(16));
        let mut gbuffer = sphere(8, 4.0);
        gbuffer.material.fill(crate::geometry::gbuffer::BACKGROUND);
        for mode in [Mode::Adaptive, Mode::AdaptivePixels, Mode::AdaptiveCounts, Mode::Reference] {
            let mut frame = Cpu.prepare(FrameInput::new(gbuffer.clone(), Vec::new(), lights.clone()).unwrap());
            let rendered = Cpu.render(&mut frame, &RenderOptions { mode, ..RenderOptions::default() }).unwrap();
            assert_eq!(rendered.radiance, [[0.0; 3]; 64]);
            assert_eq!((rendered.statistics.foreground, rendered.statistics.shading_samples), (0, 0));
        }
    }
}
