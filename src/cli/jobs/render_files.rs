//! The files of a rendering: image with layers, picture, map of the shading, light.

use std::fmt::Display;
use std::fs;
use std::path::Path;

use brdfit_figures::panel::{Panel, side_by_side};
use brdfit_figures::png;
use brdfit_renderer::{COARSEST_LEVEL, Exposure, Film, LatLong, Light, Radiance, shown};

use crate::commands::render::Frame;
use crate::jobs::render_plan::RenderPlan;
use crate::report::shading_map;
use crate::results::output;
use crate::terminal::exit_code::Problem;

/// Size of the map of the light.
const LIGHT_MAP: [usize; 2] = [2048, 1024];

/// What was rendered.
pub(crate) struct Rendered<'a> {
    pub(crate) frame: &'a Frame,
    /// With its background.
    pub(crate) image: &'a [[f32; 3]],
    pub(crate) exposure: Exposure,
    pub(crate) light: &'a Light,
}

/// Writes all files of the plan but the statistics.
///
/// # Errors
/// What the operating system reports.
pub(crate) fn write(plan: &RenderPlan, rendered: &Rendered<'_>) -> Result<(), Problem> {
    let Rendered { frame, image, exposure, light } = rendered;
    let gbuffer = &frame.gbuffer;
    let files = &plan.files;
    let mut film = Film::new(gbuffer.width, gbuffer.height).radiance(image);
    for &pass in &plan.passes {
        film = frame.renderer.add_to(film, pass, gbuffer, &frame.differentials, &frame.light_bandwidth);
    }
    if let Some(variance) = &frame.variance {
        film = film.scalar("variance", variance.iter().copied());
    }
    encoded(&files.image, film.to_exr())?;
    if let Some(path) = &files.png {
        encoded(path, png::encode(&shown(image, gbuffer.width, *exposure)))?;
    }
    if let Some(path) = &files.map {
        write_map(path, "", rendered)?;
    }
    if let Some(path) = &files.light_map {
        encoded(path, light_map(light, frame))?;
    }
    Ok(())
}

/// Writes the image beside the map of where it was shaded, under a title.
///
/// # Errors
/// What the operating system reports.
pub(crate) fn write_map(path: &Path, title: &str, rendered: &Rendered<'_>) -> Result<(), Problem> {
    let Frame { gbuffer, renderer, .. } = rendered.frame;
    let level = |&[level, ..]: &[f32; 3]| if level < 0.0 { u8::MAX } else { (level as u8).min(COARSEST_LEVEL as u8) };
    let levels: Vec<u8> = renderer.shading_of_pixels(gbuffer).iter().map(level).collect();
    let panels = [
        Panel::image("image", shown(rendered.image, gbuffer.width, rendered.exposure)),
        shading_map::panel(&levels, gbuffer.width),
    ];
    encoded(path, png::encode(&side_by_side(title, &panels, 2)))
}

/// Writes what an encoder made.
fn encoded(path: &Path, bytes: Result<Vec<u8>, impl Display>) -> Result<(), Problem> {
    match bytes {
        Ok(bytes) => output::write(path, &bytes),
        Err(error) => Err(Problem::computation(format!("{}: {error}", path.display()))),
    }
}

/// The light by latitude and longitude, with a layer of its bandwidth.
fn light_map(light: &Light, frame: &Frame) -> Result<Vec<u8>, brdfit_renderer::FilmError> {
    let [width, height] = LIGHT_MAP;
    let map = light.to_lat_long(width, height);
    let bandwidth = (0..width * height).map(|pixel| {
        let place = [(pixel % width) as f32 + 0.5, (pixel / width) as f32 + 0.5];
        let bandwidth = frame.light_bandwidth.at(LatLong::direction(place, [width, height]));
        if bandwidth.is_finite() { bandwidth } else { -1.0 }
    });
    Film::new(width, height).radiance(map.pixels()).scalar("bandwidth", bandwidth).to_exr()
}

/// An image of the given size to compare with.
///
/// # Errors
/// A file that cannot be read, is no such image, or has another size.
pub(crate) fn read_image(path: &Path, [width, height]: [usize; 2]) -> Result<Vec<[f32; 3]>, Problem> {
    let bytes = fs::read(path).map_err(|error| Problem::reading(path, &error))?;
    let image = Radiance::from_exr(&bytes).and_then(|image| image.sized(width, height));
    image.map(|image| image.pixels).map_err(|error| Problem::of(path.display(), &error))
}
