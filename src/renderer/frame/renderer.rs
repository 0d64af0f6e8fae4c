//! One frame: the passes one after the other, timed.

use std::time::{Duration, Instant};

use rayon::prelude::*;
use wide::f32x4;

use crate::geometry::differentials::Differentials;
use crate::geometry::gbuffer::{BACKGROUND, GBuffer};
use crate::lights::light_set::LightSet;
use crate::passes::allocation::{self, Allocation, Budget, CellPrediction, allocate, dark};
use crate::passes::decision::Decisions;
use crate::passes::image_bandwidth::{BandwidthBuffer, COARSEST_LEVEL, Geometry};
use crate::passes::material::Material;
use crate::passes::pilot::{LEAST_SAMPLES, Pilot, PilotOptions};
use crate::passes::pyramid::Cells;
use crate::passes::shading::{Shade, ShadingList};
use crate::passes::upsampling::Values;
use crate::passes::upsampling_stencil::Upsampling;

/// Which parts of the algorithm are at work.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Mode {
    /// Pixels and counts both follow the prediction.
    #[default]
    Adaptive,
    /// The prediction decides which pixels are shaded; all points take the same number of samples.
    AdaptivePixels,
    /// Every pixel is shaded; the prediction decides with how many samples.
    AdaptiveCounts,
    /// Every pixel with the same number of samples: no prediction.
    Reference,
}

/// When the light is looked up in its mips, by BRDF samples alone (filtered importance sampling).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Prefilter {
    /// Never: every shaded pixel is unbiased.
    #[default]
    Never,
    /// At points whose predicted relative error with unbiased samples is larger than this.
    Above(f32),
    /// Everywhere.
    Always,
}

/// How a frame is rendered.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RenderOptions {
    /// Which parts of the algorithm are at work.
    pub mode: Mode,
    /// What is spent; in [`Mode::Reference`] samples per pixel, rounded.
    pub budget: Budget,
    /// Seed of all sample points.
    pub seed: u32,
    /// Samples of a pilot point, n_b.
    pub pilot_samples: u32,
    /// How bandwidth gets into image space.
    pub geometry: Geometry,
    /// k_s: samples per cycle over two.
    pub sampling_rate: f32,
    /// How samples are distributed.
    pub allocation: Allocation,
    /// How values pass from coarse to fine.
    pub upsampling: Upsampling,
    /// Whether the light may be prefiltered.
    pub prefilter: Prefilter,
}

impl Default for RenderOptions {
    fn default() -> Self {
        Self {
            mode: Mode::default(),
            budget: Budget::SamplesPerPixel(4.0),
            seed: 0,
            pilot_samples: 16,
            geometry: Geometry::default(),
            sampling_rate: 1.0,
            allocation: Allocation::default(),
            upsampling: Upsampling::default(),
            prefilter: Prefilter::default(),
        }
    }
}

/// What is rendered.
#[derive(Clone, Copy)]
pub struct View<'a> {
    /// Visible surfaces.
    pub gbuffer: &'a GBuffer,
    /// Their differentials.
    pub differentials: &'a Differentials,
    /// The materials that the G-buffer counts.
    pub materials: &'a [Material<'a>],
    /// The lights.
    pub lights: &'a LightSet,
}

/// Wall time of each pass.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Times {
    /// Samples of the pilot.
    pub pilot: Duration,
    /// Image-space bandwidth and levels of pixels.
    pub bandwidth_buffer: Duration,
    /// Cells, grading, leaves, parents.
    pub decisions: Duration,
    /// The list and its counts.
    pub list: Duration,
    /// Shading.
    pub shading: Duration,
    /// Up-sampling.
    pub interpolation: Duration,
    /// Times the texture.
    pub resolve: Duration,
}

impl Times {
    /// From the pilot to the up-sampling, which is what is compared.
    pub fn frame(&self) -> Duration {
        self.pilot + self.bandwidth_buffer + self.decisions + self.list + self.shading + self.interpolation
    }
}

/// What a frame took.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FrameStatistics {
    /// Wall time of each pass.
    pub times: Times,
    /// Pixels that show a surface.
    pub foreground: u64,
    /// Samples of the pilot.
    pub pilot_samples: u64,
    /// Samples of the shading points.
    pub shading_samples: u64,
    /// Shading points per level.
    pub shaded: [u64; COARSEST_LEVEL + 1],
    /// Of all, those whose light was prefiltered.
    pub filtered: u64,
}

/// Renders frames; keeps its buffers from one to the next.
#[derive(Clone, Debug, Default)]
pub struct Renderer {
    /// Predictions of the pilot.
    pub pilot: Pilot,
    /// Image-space bandwidth and levels.
    pub bandwidth_buffer: BandwidthBuffer,
    /// Cells of the pyramid.
    pub cells: Cells,
    /// What becomes of each cell.
    pub decisions: Decisions,
    /// What is shaded.
    pub list: ShadingList,
    /// Radiance with a texture of 1.
    pub values: Values,
    radiance: Vec<f32x4>,
    predictions: Vec<CellPrediction>,
}

impl Renderer {
    /// Renders a frame: outgoing radiance of every pixel of a surface, row-major, in linear sRGB; zeros in the background. The same for
    /// every number of threads.
    ///
    /// # Panics
    /// If [`Mode::Reference`] is to reach a target error (it predicts none), a pilot point has fewer than
    /// [`LEAST_SAMPLES`](crate::LEAST_SAMPLES) samples, or the G-buffer counts a material that is not there.
    pub fn render(&mut self, view: &View<'_>, options: &RenderOptions) -> (Vec<[f32; 3]>, FrameStatistics) {
        assert!(options.pilot_samples >= LEAST_SAMPLES, "{} samples of a pilot point", options.pilot_samples);
        let mut times = Times::default();
        let gbuffer = view.gbuffer;
        let foreground = gbuffer.material.iter().filter(|&&material| material != BACKGROUND).count();
        let pilot_options = PilotOptions {
            samples: options.pilot_samples,
            seed: options.seed,
            keep_paths: options.geometry != Geometry::Reflected,
        };
        let predicts = options.mode != Mode::Reference;
        let divides = matches!(options.mode, Mode::Adaptive | Mode::AdaptivePixels);
        if !predicts {
            self.pilot = Pilot::default();
        }
        if !divides {
            self.bandwidth_buffer = BandwidthBuffer::default();
        }
        if predicts {
            timed(&mut times.pilot, || {
                self.pilot.compute(gbuffer, view.materials, view.lights, &pilot_options);
            });
        }
        if divides {
            timed(&mut times.bandwidth_buffer, || {
                let (geometry, rate) = (options.geometry, options.sampling_rate);
                self.bandwidth_buffer.compute(gbuffer, view.differentials, &self.pilot, geometry, rate);
            });
        }
        timed(&mut times.decisions, || {
            if divides {
                self.cells.compute(gbuffer);
                self.decisions.compute(gbuffer, &self.cells, &self.bandwidth_buffer, options.upsampling);
            } else {
                self.decisions.all_pixels(gbuffer);
            }
        });
        timed(&mut times.list, || {
            self.list.collect(gbuffer, &self.decisions, &self.cells, view.materials.len());
            self.count(gbuffer, options, foreground);
        });
        timed(&mut times.shading, || {
            let shade = Shade { gbuffer, materials: view.materials, lights: view.lights, seed: options.seed };
            shade.shade(&self.list, &mut self.radiance);
        });
        timed(&mut times.interpolation, || {
            self.values.compute(gbuffer, &self.cells, &self.decisions, &self.list, &self.radiance);
        });
        let mut image = Vec::new();
        timed(&mut times.resolve, || image = resolve(gbuffer, &self.values));
        let mut shaded = [0; COARSEST_LEVEL + 1];
        self.list.points.iter().for_each(|point| shaded[usize::from(point.level)] += 1);
        let statistics = FrameStatistics {
            times,
            foreground: foreground as u64,
            pilot_samples: if predicts { self.pilot.samples() } else { 0 },
            shading_samples: self.list.samples(),
            shaded,
            filtered: self.list.points.iter().filter(|point| point.filtered).count() as u64,
        };
        (image, statistics)
    }

    /// Gives every point its samples and the way that the light is looked up.
    fn count(&mut self, gbuffer: &GBuffer, options: &RenderOptions, foreground: usize) {
        let points = &mut self.list.points;
        if options.mode == Mode::Reference {
            let Budget::SamplesPerPixel(samples) = options.budget else {
                panic!("without a prediction there is no target error")
            };
            let filtered = options.prefilter == Prefilter::Always;
            points.iter_mut().for_each(|point| {
                point.samples = (samples.round() as u32).max(1);
                point.filtered = filtered;
            });
            return;
        }
        let pilot = &self.pilot;
        points
            .par_iter()
            .with_min_len(256)
            .map(|point| allocation::predict(gbuffer, pilot, point))
            .collect_into_vec(&mut self.predictions);
        let dark = dark(pilot);
        let even = if options.mode == Mode::AdaptivePixels { Allocation::Even } else { options.allocation };
        allocate(points, &self.predictions, even, options.budget, dark, foreground);
        points.iter_mut().zip(&self.predictions).for_each(|(point, cell)| {
            point.filtered = match options.prefilter {
                Prefilter::Never => false,
                Prefilter::Always => true,
                Prefilter::Above(threshold) => {
                    (cell.variance / point.samples as f32).sqrt() > threshold * (cell.mean + dark)
                }
            };
        });
    }
}

/// Runs a pass and adds the time that it takes.
fn timed(time: &mut Duration, pass: impl FnOnce()) {
    let start = Instant::now();
    pass();
    *time += start.elapsed();
}

/// Radiance times texture.
fn resolve(gbuffer: &GBuffer, values: &Values) -> Vec<[f32; 3]> {
    let pixel = |(pixel, value): (usize, &f32x4)| {
        let [r, g, b, _] = value.to_array();
        let [a, c, d] = gbuffer.albedo[pixel];
        if gbuffer.material[pixel] == BACKGROUND { [0.0; 3] } else { [r * a, g * c, b * d] }
    };
    values.levels[0].par_iter().enumerate().with_min_len(4096).map(pixel).collect()
}
