//! Renders a scene.

use std::time::Instant;

use brdfit_renderer::{
    BACKGROUND, Backend, Cpu, CpuFrame, Exposure, FrameError, FrameInput, FrameStatistics, GBuffer, Layer, LayerGroup,
    RenderOptions, Times, flip, luminance, psnr, relmse,
};

use crate::args::value_enums::BackgroundArg;
use crate::jobs::render::scene::{LoadedMaterial, LoadedScene};
use crate::jobs::render::stats::{QualityEntry, TimesEntry};
use crate::terminal::exit_code::Problem;

/// An image and what it was made from.
pub(crate) struct RenderedScene<'a> {
    /// The last frame.
    frame: CpuFrame<'a>,
    /// Outgoing radiance, black in the background.
    pub(crate) radiance: Vec<[f32; 3]>,
    /// Variance of the luminance of one frame, with a texture of 1, where several were averaged.
    pub(crate) variance: Option<Vec<f32>>,
    pub(crate) statistics: FrameStatistics,
    pub(crate) times: TimesEntry,
}

impl<'a> RenderedScene<'a> {
    /// The mean of so many frames with consecutive seeds, each rendered `repeat` times for the sake of its times.
    ///
    /// # Errors
    /// None for a scene that was loaded and options that were checked.
    pub(crate) fn render(
        loaded: &'a LoadedScene,
        options: &RenderOptions,
        frames: u32,
        repeat: usize,
    ) -> Result<Self, Problem> {
        let failed = |error: FrameError| Problem::computation(error.to_string());
        let start = Instant::now();
        let gbuffer = loaded.scene.gbuffer();
        let materials = loaded.materials.iter().map(LoadedMaterial::for_frames).collect();
        let input = FrameInput::new(gbuffer, materials, loaded.lights.clone()).map_err(failed)?;
        let seen = start.elapsed();
        let mut frame = Cpu.prepare(input);
        let mut times: Vec<Times> = Vec::new();
        let mut mean = MeanFrame::default();
        let mut statistics = FrameStatistics::default();
        for n in 0..frames {
            let options = RenderOptions { seed: options.seed.wrapping_add(n), ..*options };
            let mut radiance = Vec::new();
            for _ in 0..repeat {
                let rendered = Cpu.render(&mut frame, &options).map_err(failed)?;
                (radiance, statistics) = (rendered.radiance, rendered.statistics);
                times.push(statistics.times);
            }
            mean.add(&radiance, &Cpu.layers(&frame, LayerGroup::Upsampled));
        }
        let times = TimesEntry::new(seen, loaded.light_bandwidth, &times);
        let (radiance, variance) = mean.finish();
        Ok(Self { frame, radiance, variance, statistics, times })
    }

    /// The G-buffer.
    pub(crate) fn gbuffer(&self) -> &GBuffer {
        self.frame.input().gbuffer()
    }

    /// Its input.
    pub(crate) fn input(&self) -> &FrameInput<'a> {
        self.frame.input()
    }

    /// Layers of the last frame.
    pub(crate) fn layers(&self, group: LayerGroup) -> Vec<Layer> {
        Cpu.layers(&self.frame, group)
    }

    /// The default exposure: of the reference if there is one, else of the image.
    pub(crate) fn exposure(&self, reference: Option<&[[f32; 3]]>) -> Exposure {
        Exposure::of(reference.unwrap_or(&self.radiance), &self.gbuffer().foreground())
    }

    /// The image with the lights that the camera sees, and behind all of them the environment.
    pub(crate) fn image(&self, background: BackgroundArg) -> Vec<[f32; 3]> {
        let (gbuffer, lights) = (self.gbuffer(), self.input().lights());
        let mut image = self.radiance.clone();
        for (pixel, radiance) in image.iter_mut().enumerate() {
            if gbuffer.material()[pixel] == BACKGROUND {
                let seen = lights.seen(gbuffer.eye(), -gbuffer.view()[pixel], background == BackgroundArg::Light);
                *radiance = seen.unwrap_or_default();
            }
        }
        image
    }

    /// Comparison over the pixels of surfaces.
    pub(crate) fn quality(&self, reference: &[[f32; 3]], exposure: Exposure, name: String) -> QualityEntry {
        let gbuffer = self.gbuffer();
        let foreground = gbuffer.foreground();
        let radiance = &self.radiance;
        // FLIP looks at the surroundings of a pixel, and what is behind the surfaces is not compared
        let reference: Vec<[f32; 3]> = (0..radiance.len())
            .map(|pixel| if foreground[pixel] { reference[pixel] } else { radiance[pixel] })
            .collect();
        let psnr = psnr(radiance, &reference, &foreground, exposure);
        let flip = flip::flip(radiance, &reference, gbuffer.size()[0], exposure, flip::PIXELS_PER_DEGREE);
        QualityEntry {
            reference: name,
            exposure: exposure.factor(),
            psnr: psnr.is_finite().then_some(psnr),
            relmse: relmse(radiance, &reference, &foreground, exposure),
            flip: flip::mean(&flip, &foreground),
        }
    }
}

/// Running sums over frames.
#[derive(Default)]
struct MeanFrame {
    count: f64,
    radiance: Vec<[f64; 3]>,
    /// Sum and sum of squares of the luminance with a texture of 1.
    luminance: Vec<[f64; 2]>,
}

impl MeanFrame {
    /// Adds a frame: its radiance and the layer before the texture.
    fn add(&mut self, radiance: &[[f32; 3]], upsampled: &[Layer]) {
        self.radiance.resize(radiance.len(), [0.0; 3]);
        self.luminance.resize(radiance.len(), [0.0; 2]);
        self.count += 1.0;
        for (sum, radiance) in self.radiance.iter_mut().zip(radiance) {
            *sum = std::array::from_fn(|c| sum[c] + f64::from(radiance[c]));
        }
        for (sum, radiance) in self.luminance.iter_mut().zip(colours(upsampled)) {
            let luminance = f64::from(luminance(radiance));
            *sum = [sum[0] + luminance, sum[1] + luminance * luminance];
        }
    }

    /// The mean, and the variance of one frame where there are several.
    fn finish(self) -> (Vec<[f32; 3]>, Option<Vec<f32>>) {
        let Self { count: n, radiance, luminance } = self;
        let mean = radiance.into_iter().map(|sum| sum.map(|sum| (sum / n) as f32)).collect();
        let variance = |[first, second]: [f64; 2]| ((second - first * first / n).max(0.0) / (n - 1.0)) as f32;
        (mean, (n > 1.0).then(|| luminance.into_iter().map(variance).collect()))
    }
}

/// The pixels of the one layer of three colours.
fn colours(layers: &[Layer]) -> impl Iterator<Item = [f32; 3]> {
    let planes = layers.iter().flat_map(Layer::planes).map(|(_, plane)| plane.as_slice());
    let planes: Vec<&[f32]> = planes.collect();
    (0..planes.first().map_or(0, |plane| plane.len())).map(move |pixel| [0, 1, 2].map(|c: usize| planes[c][pixel]))
}
