//! The files of a rendering: image with layers, picture, map of the shading, light.

use std::fmt::Display;
use std::fs;
use std::path::Path;

use brdfit_figures::panel::{Panel, side_by_side};
use brdfit_figures::png;
use brdfit_renderer::{
    COARSEST_LEVEL, Exposure, Film, FilmError, LatLong, LayerGroup, Light, LightBandwidth, Radiance,
    finite_or_minus_one, shown,
};

use crate::jobs::render::frame::RenderedScene;
use crate::jobs::render::plan::RenderPlan;
use crate::report::shading_map;
use crate::results::output;
use crate::terminal::exit_code::Problem;

/// Size of the map of the light.
const LIGHT_MAP: [usize; 2] = [2048, 1024];

/// The rendered frame.
pub(crate) struct Rendered<'a> {
    pub(crate) scene: &'a RenderedScene<'a>,
    /// With its background.
    pub(crate) image: &'a [[f32; 3]],
    pub(crate) exposure: Exposure,
}

/// Writes all files of the plan but the statistics.
///
/// # Errors
/// Errors of the operating system.
pub(crate) fn write(plan: &RenderPlan, rendered: &Rendered<'_>) -> Result<(), Problem> {
    let Rendered { scene, image, exposure } = rendered;
    let [width, height] = scene.gbuffer().size();
    let files = &plan.files;
    let layers = plan.layers.iter().flat_map(|&group| scene.layers(group));
    let mut film = layers.fold(Film::new(width, height).radiance(image), |film, layer| film.layer(&layer));
    if let Some(variance) = &scene.variance {
        film = film.scalar("variance", variance.iter().copied());
    }
    encoded(&files.image, film.to_exr())?;
    if let Some(path) = &files.png {
        encoded(path, png::encode(&shown(image, width, *exposure)))?;
    }
    if let Some(path) = &files.map {
        write_map(path, "", rendered)?;
    }
    if let Some(path) = &files.light_map
        && let Some((light, bandwidth)) = scene.input().lights().environment()
    {
        encoded(path, light_map(light, bandwidth))?;
    }
    Ok(())
}

/// Writes the image beside the map of where it was shaded, under a title.
///
/// # Errors
/// Errors of the operating system.
pub(crate) fn write_map(path: &Path, title: &str, rendered: &Rendered<'_>) -> Result<(), Problem> {
    let width = rendered.scene.gbuffer().size()[0];
    let level = |&level: &f32| if level < 0.0 { u8::MAX } else { (level as u8).min(COARSEST_LEVEL as u8) };
    let list = rendered.scene.layers(LayerGroup::List);
    let mut planes = list.iter().flat_map(|layer| layer.planes());
    let levels = planes.find(|(component, _)| *component == "LEVEL").map_or(&[][..], |(_, plane)| plane);
    let levels: Vec<u8> = levels.iter().map(level).collect();
    let panels =
        [Panel::image("image", shown(rendered.image, width, rendered.exposure)), shading_map::panel(&levels, width)];
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
fn light_map(light: &Light, bandwidth: &LightBandwidth) -> Result<Vec<u8>, FilmError> {
    let [width, height] = LIGHT_MAP;
    let map = light.to_lat_long(width, height);
    let bandwidth = (0..width * height).map(|pixel| {
        let place = [(pixel % width) as f32 + 0.5, (pixel / width) as f32 + 0.5];
        finite_or_minus_one(bandwidth.at(LatLong::direction(place, [width, height])))
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

/// The name of a file without its folder.
pub(crate) fn file_name(path: &Path) -> String {
    path.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default()
}
