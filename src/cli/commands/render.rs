//! `brdfit render`: renders a scene adaptively.

use brdfit_renderer::Mode;

use crate::args::render::RenderArgs;
use crate::jobs::batch::in_pool;
use crate::jobs::render::files::{self, Rendered, file_name, read_image};
use crate::jobs::render::frame::RenderedScene;
use crate::jobs::render::options::OptionsEntry;
use crate::jobs::render::plan::RenderPlan;
use crate::jobs::render::scene::LoadedScene;
use crate::jobs::render::stats::{RenderDocument, SceneEntry};
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
    let scene = in_pool(|| RenderedScene::render(&loaded, &plan.options, plan.frames, plan.repeat))?;
    let exposure = plan.exposure.unwrap_or_else(|| scene.exposure(reference.as_deref()));
    let entry = SceneEntry { name: file_name(&plan.scene), sha256: loaded.sha256.clone() };
    let options = OptionsEntry::new(args, &plan.options);
    let mut document = RenderDocument::new(entry, options, size, &scene.statistics, scene.times.clone());
    if let (Some(reference), Some(path)) = (&reference, &plan.reference) {
        document.quality = Some(scene.quality(reference, exposure, file_name(path)));
    }
    let image = scene.image(plan.background);
    files::write(&plan, &Rendered { scene: &scene, image: &image, exposure })?;
    if let Some(path) = &plan.files.stats {
        output::deliver(Some(path), &json::to_vec(&document))?;
    }
    console.note(&summary(&document, &plan));
    Ok(Outcome::Done)
}

/// The final message.
fn summary(document: &RenderDocument, plan: &RenderPlan) -> String {
    let shaded: u64 = document.shaded_per_level.iter().sum();
    let share = 100.0 * shaded as f64 / document.foreground.max(1) as f64;
    let points = if plan.options.mode == Mode::Reference {
        String::new()
    } else {
        format!(", {share:.0} % of the pixels shaded")
    };
    let quality = document.quality.as_ref().map_or(String::new(), |quality| {
        let psnr = quality.psnr.map_or("identical".to_owned(), |psnr| format!("{psnr:.1} dB"));
        format!(", {psnr}, relMSE {:.2e}, FLIP {:.3}", quality.relmse, quality.flip)
    });
    format!(
        "{:.1} samples per pixel{points}, {:.0} ms{quality}: {}",
        document.samples.per_pixel,
        document.milliseconds.frame,
        plan.files.image.display()
    )
}
