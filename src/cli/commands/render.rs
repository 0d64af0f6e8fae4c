//! `brdfit render`: a scene to an image, adaptively.

use std::path::Path;
use std::time::Instant;

use brdfit_renderer::{
    BACKGROUND, Differentials, Exposure, FrameStatistics, GBuffer, LightSet, Material, Mode, RenderOptions, Renderer,
    Times, View, flip, luminance, psnr, relmse,
};
use clap::ValueEnum;

use crate::args::render::RenderArgs;
use crate::args::value_enums::BackgroundArg;
use crate::jobs::batch::in_pool;
use crate::jobs::render_files::{self, Rendered, read_image};
use crate::jobs::render_plan::RenderPlan;
use crate::jobs::render_scene::LoadedScene;
use crate::jobs::render_stats::{OptionsEntry, QualityEntry, RenderDocument, SceneEntry, TimesEntry};
use crate::results::json;
use crate::results::output;
use crate::terminal::console::Console;
use crate::terminal::exit_code::{Outcome, Problem};

pub(crate) fn run(args: &RenderArgs, console: &Console) -> anyhow::Result<Outcome> {
    let plan = RenderPlan::new(args)?;
    let loaded = LoadedScene::open(&plan.scene, plan.materials.as_deref())?;
    if plan.files.light_map.is_some() && loaded.lights.environment().is_none() {
        let scene = plan.scene.display();
        let why = "lights: --light-map needs an environment or procedural light among them";
        return Err(Problem::invalid(format!("{scene}: {why}")).into());
    }
    let camera = loaded.scene.camera();
    let size = [camera.width, camera.height];
    let reference = plan.reference.as_deref().map(|path| read_image(path, size)).transpose()?;
    let frame = in_pool(|| Frame::render(&loaded, &plan.options, plan.frames, plan.repeat));
    let exposure = plan.exposure.unwrap_or_else(|| frame.exposure(reference.as_deref()));
    let words = [word(args.mode), word(args.geometry), word(args.allocation), word(args.upsample)];
    let scene = SceneEntry { name: file_name(&plan.scene), sha256: loaded.sha256.clone() };
    let options = OptionsEntry::new(&plan.options, plan.frames, words);
    let mut document = RenderDocument::new(scene, options, size, &frame.statistics, frame.times.clone());
    if let (Some(reference), Some(path)) = (&reference, &plan.reference) {
        document.quality = Some(quality(&frame, reference, exposure, file_name(path)));
    }
    let image = frame.image(&loaded.lights, plan.background);
    render_files::write(&plan, &Rendered { frame: &frame, image: &image, exposure, lights: &loaded.lights })?;
    if let Some(path) = &plan.files.stats {
        output::deliver(Some(path), &json::to_vec(&document))?;
    }
    console.note(&summary(&document, &plan));
    Ok(Outcome::Done)
}

/// A frame and what it was made from.
pub(crate) struct Frame {
    pub(crate) gbuffer: GBuffer,
    pub(crate) differentials: Differentials,
    pub(crate) renderer: Renderer,
    /// Outgoing radiance, black in the background.
    pub(crate) radiance: Vec<[f32; 3]>,
    /// Variance of the luminance of one frame, with a texture of 1, where several were averaged.
    pub(crate) variance: Option<Vec<f32>>,
    statistics: FrameStatistics,
    times: TimesEntry,
}

impl Frame {
    /// The mean of so many frames with consecutive seeds, each rendered `repeat` times for the sake of its times.
    pub(crate) fn render(loaded: &LoadedScene, options: &RenderOptions, frames: u32, repeat: usize) -> Self {
        let start = Instant::now();
        let gbuffer = loaded.scene.gbuffer();
        let mut differentials = Differentials::default();
        differentials.compute(&gbuffer);
        let seen = start.elapsed();
        let materials: Vec<Material<'_>> =
            loaded.materials.iter().map(|material| Material::new(material.brdf.as_ref(), &material.atlas)).collect();
        let view =
            View { gbuffer: &gbuffer, differentials: &differentials, materials: &materials, lights: &loaded.lights };
        let mut renderer = Renderer::default();
        let mut times: Vec<Times> = Vec::new();
        let mut mean = MeanFrame::default();
        let mut statistics = FrameStatistics::default();
        for frame in 0..frames {
            let options = RenderOptions { seed: options.seed.wrapping_add(frame), ..*options };
            let mut radiance = Vec::new();
            for _ in 0..repeat {
                (radiance, statistics) = renderer.render(&view, &options);
                times.push(statistics.times);
            }
            mean.add(radiance, &renderer);
        }
        let times = TimesEntry::new(seen, loaded.light_bandwidth, &times);
        let (radiance, variance) = mean.finish();
        Self { gbuffer, differentials, renderer, radiance, variance, statistics, times }
    }

    /// What suits the image, or a reference that it is compared with.
    pub(crate) fn exposure(&self, reference: Option<&[[f32; 3]]>) -> Exposure {
        Exposure::of(reference.unwrap_or(&self.radiance), &self.gbuffer.foreground())
    }

    /// The image with the lights that the camera sees, and behind all of them the environment.
    pub(crate) fn image(&self, lights: &LightSet, background: BackgroundArg) -> Vec<[f32; 3]> {
        let gbuffer = &self.gbuffer;
        let mut image = self.radiance.clone();
        for (pixel, radiance) in image.iter_mut().enumerate() {
            if gbuffer.material[pixel] == BACKGROUND {
                let seen = lights.seen(gbuffer.eye, -gbuffer.view[pixel], background == BackgroundArg::Light);
                *radiance = seen.unwrap_or_default();
            }
        }
        image
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
    fn add(&mut self, radiance: Vec<[f32; 3]>, renderer: &Renderer) {
        self.radiance.resize(radiance.len(), [0.0; 3]);
        self.luminance.resize(radiance.len(), [0.0; 2]);
        self.count += 1.0;
        for (sum, radiance) in self.radiance.iter_mut().zip(radiance) {
            *sum = std::array::from_fn(|c| sum[c] + f64::from(radiance[c]));
        }
        for (sum, radiance) in self.luminance.iter_mut().zip(renderer.upsampled()) {
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

/// Comparison over the pixels of surfaces.
fn quality(frame: &Frame, reference: &[[f32; 3]], exposure: Exposure, name: String) -> QualityEntry {
    let foreground = frame.gbuffer.foreground();
    let radiance = &frame.radiance;
    // FLIP looks at the surroundings of a pixel, and what is behind the surfaces is not compared
    let reference: Vec<[f32; 3]> =
        (0..radiance.len()).map(|pixel| if foreground[pixel] { reference[pixel] } else { radiance[pixel] }).collect();
    let psnr = psnr(radiance, &reference, &foreground, exposure);
    let flip = flip::flip(radiance, &reference, frame.gbuffer.width, exposure, flip::PIXELS_PER_DEGREE);
    QualityEntry {
        reference: name,
        exposure: exposure.factor(),
        psnr: psnr.is_finite().then_some(psnr),
        relmse: relmse(radiance, &reference, &foreground, exposure),
        flip: flip::mean(&flip, &foreground),
    }
}

/// What is said at the end.
fn summary(document: &RenderDocument, plan: &RenderPlan) -> String {
    let shaded: u64 = document.shaded_per_level.iter().sum();
    let share = 100.0 * shaded as f64 / document.foreground.max(1) as f64;
    let points = if plan.options.mode == Mode::Reference {
        String::new()
    } else {
        format!(", {share:.0} % of the pixels shaded")
    };
    let quality = document.quality.as_ref().map_or(String::new(), |quality| {
        let psnr = quality.psnr.map_or("the same".to_owned(), |psnr| format!("{psnr:.1} dB"));
        format!(", {psnr}, relMSE {:.2e}, FLIP {:.3}", quality.relmse, quality.flip)
    });
    format!(
        "{:.1} samples per pixel{points}, {:.0} ms{quality}: {}",
        document.samples.per_pixel,
        document.milliseconds.frame,
        plan.files.image.display()
    )
}

/// The word of the command line that a value has.
fn word(value: impl ValueEnum) -> String {
    value.to_possible_value().map_or_else(String::new, |value| value.get_name().to_owned())
}

fn file_name(path: &Path) -> String {
    path.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default()
}
