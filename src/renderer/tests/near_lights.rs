//! Lights at a finite distance in whole frames, against closed forms and against each other.

use std::path::Path;

use brdfit_brdf::Lambert;
use brdfit_renderer::{
    BACKGROUND, Backend, Budget, Cpu, Frame, FrameInput, FrameStatistics, GBuffer, Geometry, LightSet, Material, Mode,
    Prefilter, RenderOptions, Scene, SceneDocument, Vec3,
};

/// Radiance of the rectangle of all scenes here.
const RADIANCE: [f64; 3] = [4.0, 2.0, 1.0];

/// A floor under a square at a height of 1, or under what `lights` says.
fn scene(lights: &str, size: usize) -> SceneDocument {
    let json = format!(
        r#"{{
            "camera": {{"eye": [0, -2.6, 0.9], "target": [0, 0.2, 0], "vertical_fov": 32, "width": {size}, "height": {size}}},
            "lights": [{lights}],
            "materials": {{"floor": {{"source": {{"lambert": [0.8, 0.5, 0.2]}}}}}},
            "objects": [{{"mesh": {{"plane": {{"size": 8}}}}, "material": "floor"}}]
        }}"#
    );
    SceneDocument::read(json.as_bytes()).unwrap()
}

const SQUARE: &str = r#"{"rect": {"corner": [-0.5, -0.5, 1], "edges": [[0, 1, 0], [1, 0, 0]], "radiance": [4, 2, 1]}}"#;
/// Stands on an edge below the floor and leans over it.
const LEANING: &str =
    r#"{"rect": {"corner": [-0.6, 1.2, -0.4], "edges": [[1.2, 0, 0], [0, 0.6, 0.8]], "radiance": [4, 2, 1]}}"#;
const GREY: &str = r#"{"procedural": {"kind": "uniform", "scale": 0.2}}"#;
const SKY: &str = r#"{"procedural": {"kind": "sky", "scale": 0.3}}"#;

fn render(document: &SceneDocument, options: &RenderOptions) -> (GBuffer, Vec<[f32; 3]>, FrameStatistics) {
    let folder = Path::new("");
    let gbuffer = Scene::load(document, folder).unwrap().gbuffer();
    let lights = LightSet::new(document.environment(folder, 64).unwrap(), document.near_lights());
    let floor = Lambert { albedo: [0.8, 0.5, 0.2] };
    let input = FrameInput::new(gbuffer.clone(), vec![Material::diffuse(&floor)], lights).unwrap();
    let Frame { radiance, statistics } = Cpu.render(&mut Cpu.prepare(input), options).unwrap();
    (gbuffer, radiance, statistics)
}

fn reference(samples: f64, seed: u32) -> RenderOptions {
    RenderOptions { mode: Mode::Reference, budget: Budget::SamplesPerPixel(samples), seed, ..RenderOptions::default() }
}

/// `int cos theta d omega` over a polygon seen from a point on the plane z = 0, by Lambert's formula: each edge contributes the angle that
/// it subtends times the component along z of the unit normal of its plane. The polygon is clipped at the horizon.
fn form_integral(point: Vec3, polygon: &[[f64; 3]]) -> f64 {
    let point = point.cast::<f64>();
    let corners: Vec<_> = polygon.iter().map(|&corner| nalgebra::Vector3::from(corner) - point).collect();
    let mut clipped = Vec::new();
    for (n, a) in corners.iter().enumerate() {
        let b = corners[(n + 1) % corners.len()];
        if a.z >= 0.0 {
            clipped.push(*a);
        }
        if a.z * b.z < 0.0 {
            clipped.push(a + (b - a) * (a.z / (a.z - b.z)));
        }
    }
    let edge = |n: usize| {
        let (a, b) = (clipped[n], clipped[(n + 1) % clipped.len()]);
        let across = a.cross(&b);
        libm::atan2(across.norm(), a.dot(&b)) * across.z / across.norm()
    };
    0.5 * (0..clipped.len()).map(edge).sum::<f64>().abs()
}

/// The radiance of the floor per channel.
fn closed_form(point: Vec3, polygon: &[[f64; 3]]) -> [f64; 3] {
    let integral = form_integral(point, polygon) / std::f64::consts::PI;
    [0.8, 0.5, 0.2].into_iter().zip(RADIANCE).map(|(rho, l)| rho * l * integral).collect::<Vec<_>>().try_into().unwrap()
}

/// Means over blocks of 32 x 32 pixels that show the floor, as all pixels up to `margin` around them do.
fn blocks(gbuffer: &GBuffer, margin: usize, value: impl Fn(usize) -> [f64; 3]) -> Vec<[f64; 3]> {
    let mut means = Vec::new();
    let [width, height] = gbuffer.size();
    for top in (margin..height - margin).step_by(32) {
        for left in (margin..width - margin).step_by(32) {
            let square = |margin: usize| {
                let side = 32 + 2 * margin;
                let (top, left) = (top - margin, left - margin);
                (0..side * side).map(move |n| (top + n / side) * width + left + n % side)
            };
            if square(margin).all(|pixel| gbuffer.material()[pixel] != BACKGROUND) {
                let sum = square(0).map(&value).fold([0.0; 3], |sum, x| std::array::from_fn(|c| sum[c] + x[c]));
                means.push(sum.map(|sum| sum / 1024.0));
            }
        }
    }
    means
}

fn largest_difference(ours: &[[f64; 3]], exact: &[[f64; 3]]) -> f64 {
    assert!(!exact.is_empty() && ours.len() == exact.len());
    ours.iter().flatten().zip(exact.iter().flatten()).map(|(a, b)| (a / b - 1.0).abs()).fold(0.0, f64::max)
}

fn of_image(image: &[[f32; 3]]) -> impl Fn(usize) -> [f64; 3] {
    |pixel| image[pixel].map(f64::from)
}

#[test]
fn a_lambertian_floor_agrees_with_the_closed_form() {
    let square = [[-0.5, -0.5, 1.0], [-0.5, 0.5, 1.0], [0.5, 0.5, 1.0], [0.5, -0.5, 1.0]];
    let leaning = [[-0.6, 1.2, -0.4], [0.6, 1.2, -0.4], [0.6, 1.8, 0.4], [-0.6, 1.8, 0.4]];
    for (light, polygon) in [(SQUARE, square), (LEANING, leaning)] {
        let (gbuffer, image, _) = render(&scene(light, 96), &reference(1024.0, 0));
        let exact = blocks(&gbuffer, 0, |pixel| closed_form(gbuffer.position()[pixel], &polygon));
        let ours = blocks(&gbuffer, 0, of_image(&image));
        let worst = largest_difference(&ours, &exact);
        println!("{} blocks of 32 x 32, 1024 samples: largest difference {worst:.1e}", exact.len());
        assert!(worst < 1e-3, "{worst}");
    }
}

/// A light that fills the hemisphere shows the albedo.
#[test]
fn a_light_that_fills_the_hemisphere_shows_the_albedo() {
    let wide =
        r#"{"rect": {"corner": [-2000, -2000, 1], "edges": [[0, 4000, 0], [4000, 0, 0]], "radiance": [1, 1, 1]}}"#;
    let (gbuffer, image, _) = render(&scene(wide, 64), &reference(1024.0, 0));
    let worst = largest_difference(&blocks(&gbuffer, 0, of_image(&image)), &[[0.8, 0.5, 0.2]; 2]);
    println!("light that fills the hemisphere: largest difference {worst:.1e}");
    assert!(worst < 1e-3, "{worst}");
}

#[test]
fn lights_add_up() {
    let mean = |lights: &str, seed: u32| {
        let (gbuffer, image, _) = render(&scene(lights, 64), &reference(256.0, seed));
        blocks(&gbuffer, 0, of_image(&image))
    };
    let (sky, square, leaning) = (mean(SKY, 1), mean(SQUARE, 2), mean(LEANING, 3));
    let sum = |parts: &[&Vec<[f64; 3]>]| -> Vec<[f64; 3]> {
        (0..sky.len()).map(|n| std::array::from_fn(|c| parts.iter().map(|part| part[n][c]).sum())).collect()
    };
    let two = largest_difference(&mean(&format!("{SQUARE}, {SKY}"), 4), &sum(&[&sky, &square]));
    let three = largest_difference(&mean(&format!("{SQUARE}, {SKY}, {LEANING}"), 5), &sum(&[&sky, &square, &leaning]));
    println!("sum of two {two:.1e}, of three {three:.1e}");
    assert!(two < 3e-3 && three < 3e-3, "{two} {three}");
}

/// Prediction and interpolation keep the mean: every mode, both geometries, with and without averages of the light. Cells
/// at the border of the image or the floor have no parents beyond it and do not count.
#[test]
fn all_modes_have_the_same_mean() {
    let document = scene(&format!("{SQUARE}, {GREY}"), 160);
    let (gbuffer, image, _) = render(&document, &reference(256.0, 0));
    let exact = blocks(&gbuffer, 32, of_image(&image));
    let default = RenderOptions { budget: Budget::SamplesPerPixel(64.0), seed: 1, ..RenderOptions::default() };
    let cases = [
        (RenderOptions { mode: Mode::AdaptiveCounts, ..default }, 0.01),
        (RenderOptions { mode: Mode::AdaptivePixels, ..default }, 0.01),
        (default, 0.01),
        (RenderOptions { geometry: Geometry::Operators, ..default }, 0.01),
        (RenderOptions { geometry: Geometry::OperatorsPublished, ..default }, 0.01),
        // averages of the environment have no bias where it is the same everywhere
        (RenderOptions { mode: Mode::Reference, prefilter: Prefilter::Always, ..default }, 0.01),
        (RenderOptions { prefilter: Prefilter::Above(0.05), ..default }, 0.01),
    ];
    let mut wrong = Vec::new();
    for (options, tolerance) in cases {
        let (gbuffer, image, statistics) = render(&document, &options);
        let worst = largest_difference(&blocks(&gbuffer, 32, of_image(&image)), &exact);
        println!(
            "{:?}, {:?}, {:?}: {worst:.1e}, shaded {:?}",
            options.mode, options.geometry, options.prefilter, statistics.shaded
        );
        if worst >= tolerance {
            wrong.push((options, worst));
        }
    }
    assert!(wrong.is_empty(), "{wrong:?}");
}

/// A rectangle in front of the floor takes the floor's pixels out of all passes, one behind it changes nothing.
#[test]
fn pixels_that_show_a_light_take_part_in_no_pass() {
    let in_front =
        r#"{"rect": {"corner": [-0.3, -1, 0.2], "edges": [[0.6, 0, 0], [0, 0, 0.4]], "radiance": [4, 2, 1]}}"#;
    let below =
        r#"{"rect": {"corner": [-0.3, 0.3, -0.5], "edges": [[0.6, 0, 0], [0, 0, 0.4]], "radiance": [4, 2, 1]}}"#;
    let document = scene(in_front, 64);
    let (gbuffer, image, statistics) = render(&document, &RenderOptions::default());
    let lights = LightSet::new(None, document.near_lights());
    let centre = 32 * 64 + 32;
    assert_eq!((gbuffer.material()[centre], image[centre]), (BACKGROUND, [0.0; 3]));
    assert!(gbuffer.depth()[centre].is_infinite());
    // edges[0] x edges[1] points to -y, towards the eye
    assert_eq!(lights.seen(gbuffer.eye(), -gbuffer.view()[centre], false), Some([4.0, 2.0, 1.0]));
    let shown = |gbuffer: &GBuffer| gbuffer.material().iter().filter(|&&material| material != BACKGROUND).count();
    let (hidden, _, _) = render(&scene(below, 64), &RenderOptions::default());
    assert!(shown(&gbuffer) < shown(&hidden) - 100);
    assert_eq!(statistics.foreground as usize, shown(&gbuffer));
    let nothing = Vec3::new(0.0, -1.0, 0.0);
    assert_eq!(lights.seen(gbuffer.eye(), nothing, true), None);
}

#[test]
fn the_number_of_threads_changes_nothing() {
    let document = scene(&format!("{SQUARE}, {SKY}, {LEANING}"), 64);
    for geometry in [Geometry::Reflected, Geometry::Operators] {
        let options = RenderOptions { geometry, pilot_samples: 300, ..RenderOptions::default() };
        let on = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            let (_, image, statistics) = pool.install(|| render(&document, &options));
            let bits: Vec<[u32; 3]> = image.into_iter().map(|pixel| pixel.map(f32::to_bits)).collect();
            (bits, statistics.shading_samples, statistics.pilot_samples)
        };
        assert!(on(1) == on(3), "{geometry:?}");
    }
}
