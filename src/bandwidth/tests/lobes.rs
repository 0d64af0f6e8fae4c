//! What must hold for the bandwidth of every lobe, and readings that are known.

mod materials;

use std::f64::consts::{FRAC_PI_2, PI};

use brdfit_bandwidth::{
    AngularMap, Estimator, LOBE_TEXELS, Layout, Lobe, LobeEstimator, LobeGrid, LobeMemory, LobeOptions,
    direction_to_position, incident_direction,
};
use brdfit_brdf::{Brdf, Direction, GgxMaterial, Lambert, direction};

/// The default, up to some samples along a side.
fn at_most(max_resolution: usize) -> LobeOptions {
    LobeOptions { max_resolution, ..LobeOptions::default() }
}

fn ggx(alpha: f64) -> GgxMaterial {
    GgxMaterial::without_fresnel([0.0; 3], [1.0; 3], alpha).unwrap()
}

/// As glossy as paint, in three colours.
fn glossy() -> GgxMaterial {
    GgxMaterial::without_fresnel([0.1, 0.2, 0.4], [0.3, 0.4, 0.5], 0.12).unwrap()
}

/// One lobe; `mirrored` where its symmetry may be used.
fn lobe(brdf: &dyn Brdf, i: &Direction, mirrored: bool, options: LobeOptions) -> Lobe {
    LobeEstimator::new(brdf, &LobeGrid::default(), mirrored, options).estimate(i, &mut LobeMemory::default())
}

/// The largest bandwidth of a channel in the texels that the mirror direction of `i` lies in, or at the edge of.
fn at_mirror(lobe: &Lobe, channel: usize, i: &Direction) -> f32 {
    let [x, y] = direction_to_position(&Direction::new(-i.x, -i.y, i.z)).map(|p| (p + 1.0) * 0.5 * LOBE_TEXELS as f64);
    let touched = |x: f64| [x - 1e-9, x + 1e-9].map(|x| x as usize);
    let texels = touched(y).into_iter().flat_map(|r| touched(x).map(|c| lobe.texels[channel][r * LOBE_TEXELS + c]));
    texels.fold(0.0, f32::max)
}

fn at_40_degrees() -> Direction {
    direction(40.0_f64.to_radians(), 0.0)
}

#[derive(serde::Deserialize)]
struct Fixture {
    /// alpha, cycles per radian of the lobe as it is, and of the mean over its reflections.
    readings: Vec<(f64, f32, f32)>,
}

/// Within 1e-4 of the definition in double precision (`scripts/fixtures/make_lobes.py`, NumPy and PyWavelets; docs/theory.md, section 10), and
/// never higher for a rougher material.
#[test]
fn lobes_of_ggx_read_as_by_the_definition() {
    let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../data-fixtures/lobes.json");
    let fixture: Fixture = serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap();
    assert_eq!(fixture.readings.len(), 11);
    let averaged = at_most(256);
    let single = LobeOptions { estimator: Estimator { reflections: false, ..averaged.estimator }, ..averaged };
    let mut before = [f32::INFINITY; 2];
    for (alpha, by_one, by_four) in fixture.readings {
        let i = at_40_degrees();
        // without the reflections the map of a symmetric lobe is not symmetric: all of it is computed
        let found = [(single, false), (averaged, true)]
            .map(|(options, mirrored)| at_mirror(&lobe(&ggx(alpha), &i, mirrored, options), 0, &i));
        println!("GGX {alpha}: {found:?} cycles per radian, expected {by_one}, {by_four}");
        for ((found, expected), before) in found.into_iter().zip([by_one, by_four]).zip(&mut before) {
            assert!((found / expected - 1.0).abs() < 1e-4, "GGX {alpha}: {found} instead of {expected}");
            assert!(found <= *before, "GGX {alpha}: {found} after {before}");
            *before = found;
        }
    }
}

#[test]
fn a_constant_has_exactly_none() {
    let (grid, mut memory) = (LobeGrid::default(), LobeMemory::default());
    let lambert = Lambert { albedo: [0.1, 0.35, 0.9] };
    for mirrored in [true, false] {
        let lobes = LobeEstimator::new(&lambert, &grid, mirrored, at_most(1024));
        for layout in [Layout::Isotropic, Layout::Hemisphere] {
            for tile in [0, 5, 128, 200, 255] {
                let lobe = lobes.estimate(&incident_direction(layout, tile), &mut memory);
                assert!(lobe.texels.iter().flatten().all(|&texel| texel == 0.0), "{layout:?} {tile}");
                assert_eq!((lobe.resolution, lobe.saturated), (256, false));
            }
        }
    }
}

/// Another material with all values times a factor.
struct Scaled<B>(B, f64);

impl<B: Brdf> Brdf for Scaled<B> {
    fn value(&self, i: &Direction, o: &Direction) -> [f64; 3] {
        self.0.value(i, o).map(|value| value * self.1)
    }
}

/// Largest of |a / b - 1| over the texels of all channels; 0 must be 0 in both.
fn deviation(a: &Lobe, b: &Lobe) -> f32 {
    let pairs = a.texels.iter().flatten().zip(b.texels.iter().flatten());
    pairs.map(|(a, b)| if a == b { 0.0 } else { (a / b - 1.0).abs().min(f32::MAX) }).fold(0.0, f32::max)
}

#[test]
fn scale_changes_nothing() {
    let i = direction(0.9, 0.0);
    let one = lobe(&glossy(), &i, true, at_most(1024));
    assert_eq!(lobe(&Scaled(glossy(), 2.0_f64.powi(-9)), &i, true, at_most(1024)), one);
    for factor in [3.0, 1e-4, 777.0] {
        let other = lobe(&Scaled(glossy(), factor), &i, true, at_most(1024));
        let found = deviation(&other, &one);
        println!("times {factor}: {found:.1e}");
        assert!(found < 1e-5 && other.resolution == one.resolution, "{factor}: {found}");
    }
}

/// A lobe without any symmetry, as of brushed metal under a tilted coat: cheap, and different in all channels.
struct Skewed;

impl Brdf for Skewed {
    fn value(&self, i: &Direction, o: &Direction) -> [f64; 3] {
        let (x, y) = (i.x + o.x, i.y + o.y);
        [8.0, 20.0, 60.0].map(|k| 0.1 + (1.0 + 0.5 * o.y - 0.3 * o.x) / (1.0 + k * (x * x + 3.0 * y * y + x * y)))
    }
}

/// Another material seen in a mirror along x or y.
struct Mirrored<B>(B, [f64; 2]);

impl<B: Brdf> Brdf for Mirrored<B> {
    fn value(&self, i: &Direction, o: &Direction) -> [f64; 3] {
        let [x, y] = self.1;
        let turn = |d: &Direction| Direction::new(x * d.x, y * d.y, d.z);
        self.0.value(&turn(i), &turn(o))
    }
}

fn reflected(lobe: &Lobe, [x, y]: [f64; 2]) -> Lobe {
    let turn = |n: usize, sign: f64| if sign < 0.0 { LOBE_TEXELS - 1 - n } else { n };
    let texels = lobe.texels.each_ref().map(|texels| {
        let place = |n: usize| turn(n / LOBE_TEXELS, y) * LOBE_TEXELS + turn(n % LOBE_TEXELS, x);
        (0..texels.len()).map(|n| texels[place(n)]).collect()
    });
    Lobe { texels, ..*lobe }
}

#[test]
fn mirrored_lobes_have_mirrored_maps() {
    let i = direction(0.7, 0.4);
    let one = lobe(&Skewed, &i, false, at_most(1024));
    for signs in [[-1.0, 1.0], [1.0, -1.0], [-1.0, -1.0]] {
        let mirror = Direction::new(signs[0] * i.x, signs[1] * i.y, i.z);
        let other = lobe(&Mirrored(Skewed, signs), &mirror, false, at_most(1024));
        let found = deviation(&other, &reflected(&one, signs));
        println!("mirrored {signs:?} at {}: {found:.1e}", one.resolution);
        assert!(found < 1e-5, "{signs:?}: {found}");
    }
}

#[test]
fn the_symmetry_of_a_lobe_saves_work_only() {
    for (brdf, theta) in [(ggx(0.3), 0.1), (glossy(), 0.9), (ggx(0.02), 0.7), (ggx(0.006), 1.3)] {
        let i = direction(theta, 0.0);
        let [half, whole] = [true, false].map(|mirrored| lobe(&brdf, &i, mirrored, at_most(1024)));
        let found = deviation(&half, &whole);
        println!("theta {theta} at {}: {found:.1e}", half.resolution);
        assert_eq!((half.resolution, half.saturated), (whole.resolution, whole.saturated));
        assert!(found < 1e-5, "theta {theta}: {found}");
        assert_eq!(half, reflected(&half, [1.0, -1.0]));
    }
}

/// The lobe of an isotropic material turns with the incident direction, and so does its bandwidth: within 0.1 octave, in the mean
/// over the texels around the mirror direction, where it is above 2 cycles per radian. Broader lobes also depend on how
/// they lie on the grid of the largest wavelets.
#[test]
fn turned_lobes_have_turned_maps() {
    let (grid, map, mut memory) = (LobeGrid::default(), AngularMap::new(LOBE_TEXELS), LobeMemory::default());
    for (m, bar) in [(0.05, 0.1), (0.1, 0.1), (0.2, 0.15), (0.3, 0.3)] {
        let brdf = ggx(m);
        let lobes = LobeEstimator::new(&brdf, &grid, false, at_most(1024));
        let (mut low, mut high) = (f32::INFINITY, f32::NEG_INFINITY);
        for k in 0..12 {
            let i = direction(40.0_f64.to_radians(), PI * f64::from(k) / 12.0);
            let mirror = direction_to_position(&Direction::new(-i.x, -i.y, i.z));
            let lobe = lobes.estimate(&i, &mut memory);
            let near = (0..LOBE_TEXELS * LOBE_TEXELS).filter(|n| {
                let [u, v] = map.position(n / LOBE_TEXELS, n % LOBE_TEXELS);
                libm::hypot(u - mirror[0], v - mirror[1]) < 0.1
            });
            let near: Vec<f32> = near.map(|n| lobe.texels[0][n].log2()).collect();
            let octave = near.iter().sum::<f32>() / near.len() as f32;
            (low, high) = (low.min(octave), high.max(octave));
        }
        println!("GGX {m}, turned: {low:.3} to {high:.3} octaves above one cycle per radian");
        assert!(high - low < bar, "GGX {m}: {low} to {high}");
    }
}

#[test]
fn channels_are_apart() {
    let i = direction(0.6, 0.0);
    let both = GgxMaterial::without_fresnel([0.2, 0.5, 0.0], [0.5, 0.0, 0.0], 0.03).unwrap();
    let found = lobe(&both, &i, true, at_most(1024));
    assert!(found.resolution > 256 && at_mirror(&found, 0, &i) > 8.0);
    assert!(found.texels[1..].iter().flatten().all(|&texel| texel == 0.0));
    let alone = lobe(&GgxMaterial::without_fresnel([0.2; 3], [0.5; 3], 0.03).unwrap(), &i, true, at_most(1024));
    assert_eq!(found.texels[0], alone.texels[2]);
}

#[test]
fn published_mirrors_are_resolved() {
    let Some(data) = materials::data::genuine() else { return };
    let i = at_40_degrees();
    for name in ["chrome", "red-metallic-paint", "specular-black-phenolic"] {
        let lobe = lobe(&materials::published(&data, name), &i, true, at_most(1024));
        let bandwidth = [0, 1, 2].map(|channel| at_mirror(&lobe, channel, &i)).into_iter().fold(0.0, f32::max);
        println!("{name}: {bandwidth:.1} cycles per radian at {}, saturated {}", lobe.resolution, lobe.saturated);
        assert_eq!(lobe.resolution, 1024);
        assert!(bandwidth > 60.0, "{name}: {bandwidth}");
    }
}

#[test]
fn resolution_follows_sharpness_up_to_its_limit() {
    let i = at_40_degrees();
    for (m, max_resolution, resolution, saturated) in [
        (0.3, 1024, 256, false),
        (0.03, 1024, 512, false),
        (0.03, 512, 512, false),
        (0.02, 1024, 1024, false),
        (0.012, 1024, 1024, true),
        (0.012, 512, 512, true),
        (0.012, 256, 256, true),
        (5e-4, 1024, 1024, true),
    ] {
        let lobe = lobe(&ggx(m), &i, true, at_most(max_resolution));
        let found = (lobe.resolution, lobe.saturated);
        println!("GGX {m} with at most {max_resolution} samples: {found:?}, {:.1}", at_mirror(&lobe, 0, &i));
        assert_eq!(found, (resolution, saturated), "GGX {m} with at most {max_resolution} samples");
    }
}

#[test]
#[should_panic(expected = "no resolution 300")]
fn other_resolutions_are_refused() {
    let _ = LobeEstimator::new(&Lambert { albedo: [0.5; 3] }, &LobeGrid::default(), true, at_most(300));
}

#[test]
fn memory_and_grid_can_be_used_again() {
    let (grid, mut memory) = (LobeGrid::default(), LobeMemory::default());
    let (sharp, broad) = (ggx(0.01), glossy());
    let [sharp, broad] = [&sharp, &broad].map(|brdf| LobeEstimator::new(brdf, &grid, true, at_most(1024)));
    let (i, turned) = (direction(0.8, 0.0), direction(FRAC_PI_2 - 0.1, 0.5));
    let first =
        (sharp.estimate(&i, &mut memory), broad.estimate(&i, &mut memory), broad.estimate(&turned, &mut memory));
    let again =
        (sharp.estimate(&i, &mut memory), broad.estimate(&i, &mut memory), broad.estimate(&turned, &mut memory));
    assert_eq!(first, again);
    assert_eq!(first.2, broad.estimate(&turned, &mut LobeMemory::default()));
}
