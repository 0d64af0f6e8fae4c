//! The passes of a frame: a bumpy sphere of gold paint under the sky, 512 x 512. The times of whole frames, pass by pass, are in
//! `brdfit render --stats`; here each part that can stand alone.

use std::hint::black_box;
use std::path::Path;

use brdfit_bandwidth::{Atlas, AtlasChannels, Layout, LobeGrid, LobeOptions, compute_atlas};
use brdfit_brdf::{SgdMaterial, SgdParameters};
use brdfit_renderer::{
    Backend, Bandwidth, Budget, Cpu, FrameInput, GBuffer, Light, LightSet, Material, Mode, Procedural, RenderOptions,
    Scene, SceneDocument,
};
use criterion::{Criterion, criterion_group, criterion_main};

const SCENE: &str = r#"{
    "camera": {"eye": [4.2, 0, 0.6], "target": [0, 0, 0], "vertical_fov": 31, "width": 512, "height": 512},
    "light": {"procedural": {"kind": "sky"}},
    "materials": {"gold": {"source": {"embedded": "gold-metallic-paint"}}},
    "objects": [{"mesh": {"displaced_sphere": {"amplitude": 0.05, "frequency": 2.5, "octaves": 2}}, "material": "gold"}]
}"#;

fn gold() -> SgdMaterial {
    let channel = |rho_d, f0| SgdParameters { rho_d, rho_s: 0.5, alpha: 0.03, p: 0.5, f0, f1: 0.1 };
    SgdMaterial::new([channel(0.03, 0.3), channel(0.02, 0.2), channel(0.01, 0.1)]).expect("inside of the domain")
}

struct Prepared {
    scene: Scene,
    gbuffer: GBuffer,
    light: Light,
    brdf: SgdMaterial,
    atlas: Atlas,
}

impl Prepared {
    fn new() -> Self {
        let document = SceneDocument::read(SCENE.as_bytes()).expect("a scene");
        let scene = Scene::load(&document, Path::new("")).expect("no files");
        let brdf = gold();
        let options = LobeOptions::default();
        let grid = LobeGrid::default();
        let (atlas, _) = compute_atlas(&brdf, Layout::Isotropic, AtlasChannels::Max, &grid, &options).expect("finite");
        Self { gbuffer: scene.gbuffer(), scene, light: Procedural::Sky.light(Light::SIZE), brdf, atlas }
    }

    fn input(&self) -> FrameInput<'_> {
        let materials = vec![Material::new(&self.brdf, Bandwidth::Atlas(&self.atlas))];
        FrameInput::new(self.gbuffer.clone(), materials, LightSet::from(self.light.clone())).expect("one material")
    }
}

fn preparation(c: &mut Criterion) {
    let prepared = Prepared::new();
    c.bench_function("gbuffer", |b| b.iter(|| black_box(prepared.scene.gbuffer())));
    c.bench_function("differentials and light bandwidth", |b| b.iter(|| prepared.input()));
}

fn frames(c: &mut Criterion) {
    let prepared = Prepared::new();
    let mut group = c.benchmark_group("frame");
    group.sample_size(20);
    let cases = [
        ("reference, 4 per pixel", Mode::Reference, 4.0),
        // the least: the pilot, the decisions and four samples per shading point
        ("adaptive, least", Mode::Adaptive, 0.01),
        ("adaptive, 4 per pixel", Mode::Adaptive, 4.0),
        ("adaptive, 16 per pixel", Mode::Adaptive, 16.0),
    ];
    for (name, mode, spp) in cases {
        let options = RenderOptions { mode, budget: Budget::SamplesPerPixel(spp), ..RenderOptions::default() };
        let mut frame = Cpu.prepare(prepared.input());
        group.bench_function(name, |b| b.iter(|| Cpu.render(&mut frame, black_box(&options))));
    }
    group.finish();
}

criterion_group!(passes, preparation, frames);
criterion_main!(passes);
