//! Whole frames: what must hold whatever is rendered.

use brdfit_bandwidth::{Atlas, AtlasChannels, Layout, LobeGrid, LobeOptions, compute_atlas};
use brdfit_brdf::{Brdf, GgxMaterial, Lambert, SgdMaterial, SgdParameters};
use brdfit_renderer::{
    BACKGROUND, Backend, Bandwidth, Budget, Cpu, Frame, FrameInput, GBuffer, Geometry, LayerGroup, Light, LightSet,
    Material, Mode, Prefilter, Procedural, RenderOptions, Scene, SceneDocument, Upsampling,
};

/// A sphere on a plane with a chequerboard, two materials.
const SCENE: &str = r#"{
    "camera": {"eye": [4.2, 0, 1.2], "target": [0, 0, 0], "vertical_fov": 34, "width": 96, "height": 80},
    "light": {"procedural": {"kind": "sky"}},
    "materials": {
        "ball": {"source": {"lambert": [1, 1, 1]}},
        "floor": {"source": {"lambert": [1, 1, 1]}, "albedo": {"checker": {"colors": [[0.9, 0.8, 0.7], [0.2, 0.2, 0.3]]}}}
    },
    "objects": [
        {"mesh": {"sphere": {}}, "material": "ball"},
        {"mesh": {"plane": {"size": 8}}, "material": "floor", "translate": [0, 0, -1]}
    ]
}"#;

fn gbuffer(scene: &str) -> GBuffer {
    let document = SceneDocument::read(scene.as_bytes()).unwrap();
    Scene::load(&document, std::path::Path::new("")).unwrap().gbuffer()
}

fn atlas(brdf: &dyn Brdf) -> Atlas {
    let options = LobeOptions { max_resolution: 256, ..LobeOptions::default() };
    compute_atlas(brdf, Layout::Isotropic, AtlasChannels::Max, &LobeGrid::default(), &options).unwrap().0
}

fn paint() -> SgdMaterial {
    let channel = |rho_d| SgdParameters { rho_d, rho_s: 0.3, alpha: 0.01, p: 0.7, f0: 0.3, f1: 0.1 };
    SgdMaterial::new([channel(0.2), channel(0.05), channel(0.04)]).unwrap()
}

fn render(gbuffer: &GBuffer, light: &Light, materials: &[Material<'_>], options: &RenderOptions) -> Frame {
    let input = FrameInput::new(gbuffer.clone(), materials.to_vec(), LightSet::from(light.clone())).unwrap();
    Cpu.render(&mut Cpu.prepare(input), options).unwrap()
}

#[test]
fn the_number_of_threads_changes_nothing() {
    let gbuffer = gbuffer(SCENE);
    let light = Procedural::Sky.light(128);
    let (paint, grey) = (paint(), Lambert { albedo: [0.6; 3] });
    let sharp = atlas(&paint);
    let materials = [Material::new(&paint, Bandwidth::Atlas(&sharp)), Material::diffuse(&grey)];
    let default = RenderOptions::default();
    for options in [
        default,
        RenderOptions { mode: Mode::AdaptivePixels, geometry: Geometry::Operators, ..default },
        RenderOptions { mode: Mode::AdaptiveCounts, prefilter: Prefilter::Above(0.2), ..default },
        RenderOptions { mode: Mode::Reference, ..default },
        RenderOptions {
            budget: Budget::TargetError(0.1),
            upsampling: Upsampling::Published,
            pilot_samples: 600,
            ..default
        },
    ] {
        let on = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            let frame = pool.install(|| render(&gbuffer, &light, &materials, &options));
            let bits: Vec<[u32; 3]> = frame.radiance.into_iter().map(|pixel| pixel.map(f32::to_bits)).collect();
            (bits, frame.statistics.shading_samples, frame.statistics.shaded)
        };
        let one = on(1);
        assert!(one == on(2) && one == on(5), "{options:?}");
    }
}

#[test]
fn a_white_furnace_shows_the_albedo() {
    // under radiance 1 a Lambert surface shows its albedo, a GGX one without diffuse part no more than 1
    let gbuffer = gbuffer(SCENE);
    let light = Procedural::Uniform.light(64);
    let (grey, mirror) =
        (Lambert { albedo: [0.6, 0.3, 0.1] }, GgxMaterial::without_fresnel([0.0; 3], [1.0; 3], 0.3).unwrap());
    let materials = [Material::diffuse(&grey), Material::new(&mirror, Bandwidth::Constant(0.0))];
    for mode in [Mode::Adaptive, Mode::AdaptivePixels, Mode::AdaptiveCounts, Mode::Reference] {
        let options = RenderOptions { mode, budget: Budget::SamplesPerPixel(64.0), ..RenderOptions::default() };
        let image = render(&gbuffer, &light, &materials, &options).radiance;
        let (mut sum, mut count) = ([0.0_f64; 3], 0.0);
        for (pixel, &material) in gbuffer.material().iter().enumerate() {
            match material {
                0 => {
                    sum = std::array::from_fn(|c| sum[c] + f64::from(image[pixel][c]));
                    count += 1.0;
                }
                1 => assert!((0..3).all(|c| image[pixel][c] <= 1.1 * gbuffer.albedo()[pixel][c]), "{:?}", image[pixel]),
                BACKGROUND => assert_eq!(image[pixel], [0.0; 3]),
                _ => unreachable!(),
            }
        }
        for (sum, albedo) in sum.into_iter().zip(grey.albedo) {
            assert!((sum / count / albedo - 1.0).abs() < 5e-3, "{mode:?}: {} {albedo}", sum / count);
        }
    }
}

#[test]
fn every_mode_spends_its_budget_and_approaches_the_reference() {
    let gbuffer = gbuffer(SCENE);
    let light = Procedural::Studio.light(128);
    let (paint, grey) = (paint(), Lambert { albedo: [0.6; 3] });
    let sharp = atlas(&paint);
    let materials = [Material::new(&paint, Bandwidth::Atlas(&sharp)), Material::diffuse(&grey)];
    let at = |mode, spp, seed| {
        let options = RenderOptions { mode, budget: Budget::SamplesPerPixel(spp), seed, ..RenderOptions::default() };
        render(&gbuffer, &light, &materials, &options)
    };
    let reference = at(Mode::Reference, 1024.0, 9).radiance;
    let error = |image: &[[f32; 3]]| -> f64 {
        let pairs = image.iter().flatten().zip(reference.iter().flatten());
        pairs.map(|(x, y)| f64::from((x - y).powi(2) / (y * y + 0.01))).sum::<f64>() / image.len() as f64
    };
    for mode in [Mode::Adaptive, Mode::AdaptivePixels, Mode::AdaptiveCounts] {
        let Frame { radiance: image, statistics } = at(mode, 32.0, 1);
        let per_pixel = statistics.shading_samples as f64 / statistics.foreground as f64;
        assert!((per_pixel / 32.0 - 1.0).abs() < 0.02, "{mode:?}: {per_pixel}");
        let constant = at(Mode::Reference, 32.0, 1).radiance;
        let (ours, theirs) = (error(&image), error(&constant));
        println!("{mode:?}: relative error {ours:.2e}, constant {theirs:.2e}, shaded {:?}", statistics.shaded);
        assert!(ours < 0.03, "{mode:?}: {ours}");
        assert!(mode != Mode::Adaptive || ours < theirs, "{ours} {theirs}");
    }
}

#[test]
fn operators_agree_with_the_mirror_direction_at_the_centre_of_a_sphere() {
    let scene = SCENE
        .replace("[4.2, 0, 1.2]", "[4.2, 0, 0]")
        .replace("[0, 0, -1]", "[0, 0, -50]")
        .replace("96", "97")
        .replace("80", "97");
    let gbuffer = gbuffer(&scene);
    let light = Procedural::Sky.light(256);
    let paint = paint();
    let sharp = atlas(&paint);
    let bandwidth = |geometry| {
        let materials = vec![Material::new(&paint, Bandwidth::Atlas(&sharp)); 2];
        let mut frame =
            Cpu.prepare(FrameInput::new(gbuffer.clone(), materials, LightSet::from(light.clone())).unwrap());
        Cpu.render(&mut frame, &RenderOptions { geometry, ..RenderOptions::default() }).unwrap();
        let layers = Cpu.layers(&frame, LayerGroup::Bandwidth);
        assert_eq!(layers[0].name(), "bandwidth");
        layers[0].planes()[0].1[48 * 97 + 48]
    };
    let (reflected, operators) = (bandwidth(Geometry::Reflected), bandwidth(Geometry::Operators));
    println!("reflected {reflected}, operators {operators} cycles per pixel");
    assert!(reflected > 0.0 && (operators / reflected - 1.0).abs() < 0.02, "{reflected} {operators}");
}
