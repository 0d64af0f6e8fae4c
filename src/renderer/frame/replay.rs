//! Every pass of a frame, run alone on its recorded inputs.

use std::sync::LazyLock;

use brdfit_brdf::{GgxMaterial, Lambert};

use crate::frame::backend::Backend;
use crate::frame::buffers::FrameBuffers;
use crate::frame::cpu::{Cpu, CpuFrame};
use crate::frame::input::FrameInput;
use crate::frame::options::{Mode, RenderOptions};
use crate::geometry::gbuffer::{BACKGROUND, GBuffer};
use crate::lights::light_set::LightSet;
use crate::lights::procedural::Procedural;
use crate::passes::allocation::{Allocation, AllocationPass, Budget, EqualCountsPass, Prefilter, SampleCounts};
use crate::passes::decision::{DecisionPass, EveryPixelPass};
use crate::passes::image_bandwidth::{Geometry, ImageBandwidthPass};
use crate::passes::material::{Bandwidth, Material};
use crate::passes::pass::Pass;
use crate::passes::pilot::PilotPass;
use crate::passes::pyramid::PyramidPass;
use crate::passes::resolve::ResolvePass;
use crate::passes::shading::ShadingPass;
use crate::passes::shading_list::ShadingListPass;
use crate::passes::upsampling::UpsamplingPass;
use crate::passes::upsampling_stencil::Upsampling;
use crate::test_scenes::sphere;

static GLOSSY: LazyLock<GgxMaterial> = LazyLock::new(|| {
    GgxMaterial::without_fresnel([0.1, 0.2, 0.1], [0.5; 3], 0.2).expect("inside of the model's domain")
});
const CHALK: Lambert = Lambert { albedo: [0.7, 0.6, 0.5] };
/// The sample counts of this frame need more batches than one, its pilot more lanes than a batch has.
const OPTIONS: RenderOptions = RenderOptions {
    mode: Mode::Adaptive,
    budget: Budget::SamplesPerPixel(8.0),
    seed: 3,
    pilot_samples: 300,
    geometry: Geometry::Operators,
    sampling_rate: 1.0,
    allocation: Allocation::Variance,
    upsampling: Upsampling::EdgeAware,
    prefilter: Prefilter::Never,
};

/// A sphere of two materials.
fn surfaces(size: usize) -> GBuffer {
    let mut gbuffer = sphere(size, 4.0);
    for (pixel, material) in gbuffer.material.iter_mut().enumerate() {
        if *material != BACKGROUND && pixel % size > size / 2 {
            *material = 1;
        }
    }
    gbuffer
}

fn rendered(lights: &LightSet, size: usize, options: &RenderOptions) -> (CpuFrame<'static>, Vec<[f32; 3]>) {
    let materials = vec![Material::new(&*GLOSSY, Bandwidth::Constant(4.0)), Material::diffuse(&CHALK)];
    let mut frame = Cpu.prepare(FrameInput::new(surfaces(size), materials, lights.clone()).unwrap());
    let image = Cpu.render(&mut frame, options).unwrap().radiance;
    (frame, image)
}

/// Runs a pass into an empty buffer on one thread, and into one that another frame has left, and compares with what the frame recorded.
fn replay<P: Pass + Sync>(name: &str, pass: &P, recorded: &P::Output, left: &P::Output)
where
    P::Output: Clone + Default + PartialEq + Send,
{
    let one_thread = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    let alone = one_thread.install(|| {
        let mut output = P::Output::default();
        pass.run(&mut output);
        output
    });
    assert!(alone == *recorded, "{name}, alone");
    let mut used = left.clone();
    assert!(used != *recorded, "{name}: the other frame is another one");
    pass.run(&mut used);
    assert!(used == *recorded, "{name}, into the buffer of another frame");
}

#[test]
fn every_pass_of_an_adaptive_frame_can_be_replayed() {
    let lights = LightSet::from(Procedural::Studio.light(64));
    // a threshold that some points exceed and some do not
    let both = |counts: &SampleCounts| counts.prefiltered.contains(&true) && counts.prefiltered.contains(&false);
    let thresholds = [0.4, 0.3, 0.2, 0.15, 0.1, 0.07, 0.05, 0.03, 0.02, 0.01];
    let (options, frame, image) = thresholds
        .map(|threshold| RenderOptions { prefilter: Prefilter::Above(threshold), ..OPTIONS })
        .into_iter()
        .map(|options| (options, rendered(&lights, 61, &options)))
        .find(|(_, (frame, _))| both(&frame.buffers.counts))
        .map(|(options, (frame, image))| (options, frame, image))
        .expect("errors differ from point to point");
    let (other, other_image) = rendered(&lights, 40, &options);
    let CpuFrame { input, materials, buffers } = &frame;
    let FrameBuffers { pilot, bandwidth, pyramid, decisions, list, counts, shaded, radiance } = buffers;
    let (gbuffer, left) = (input.gbuffer(), &other.buffers);

    let pass = PilotPass {
        gbuffer,
        materials,
        lights: &lights,
        samples: OPTIONS.pilot_samples,
        seed: OPTIONS.seed,
        keep_paths: true,
    };
    replay("pilot", &pass, pilot, &left.pilot);
    let differentials = input.differentials();
    let pass = ImageBandwidthPass { gbuffer, differentials, pilot, geometry: OPTIONS.geometry, rate: 1.0 };
    replay("image bandwidth", &pass, bandwidth, &left.bandwidth);
    replay("pyramid", &PyramidPass { gbuffer }, pyramid, &left.pyramid);
    let pass = DecisionPass { gbuffer, pyramid, levels: &bandwidth.level, upsampling: OPTIONS.upsampling };
    replay("decision", &pass, decisions, &left.decisions);
    let pass = ShadingListPass { gbuffer, decisions, pyramid, materials: 2 };
    replay("list", &pass, list, &left.list);
    let points = &list.points;
    let pass = AllocationPass {
        gbuffer,
        pilot,
        points,
        allocation: OPTIONS.allocation,
        budget: OPTIONS.budget,
        foreground: input.foreground(),
        prefilter: options.prefilter,
    };
    replay("allocation", &pass, counts, &left.counts);
    let pass = ShadingPass { gbuffer, materials, lights: &lights, seed: OPTIONS.seed, points, counts };
    replay("shading", &pass, shaded, &left.shaded);
    let pass = UpsamplingPass { gbuffer, pyramid, decisions, points, shaded };
    replay("up-sampling", &pass, radiance, &left.radiance);
    replay("resolve", &ResolvePass { gbuffer, radiance: &radiance.levels[0] }, &image, &other_image);
}

#[test]
fn the_passes_of_a_reference_frame_can_be_replayed() {
    let lights = LightSet::from(Procedural::Sky.light(64));
    let options = RenderOptions { mode: Mode::Reference, ..OPTIONS };
    let (frame, _) = rendered(&lights, 33, &options);
    let (other, _) = rendered(&lights, 20, &OPTIONS);
    let FrameBuffers { decisions, list, counts, .. } = &frame.buffers;
    let gbuffer = frame.input.gbuffer();
    replay("every pixel", &EveryPixelPass { gbuffer }, decisions, &other.buffers.decisions);
    let pass = EqualCountsPass { points: list.points.len(), samples: 8, prefiltered: false };
    replay("equal counts", &pass, counts, &other.buffers.counts);
}
