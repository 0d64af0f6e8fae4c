//! What a look-up in an atlas returns against the bandwidth of the lobe of exactly that incident direction.
//!
//!     cargo run --release --example lookup_error -- FIT.json|FILE.binary...      (scripts/figures/atlas_study.sh)
//!
//! Pairs of directions are drawn as a renderer meets them: the incident one with the density of the projected hemisphere, the outgoing
//! one by the material's own sampling. Prints quantiles of log2(look-up / truth), with a floor of 0.1 cycles per radian under
//! both, for two truths: the texel that the atlas would hold if it had a tile for this incident direction, and the value at the
//! sample itself, without the maximum over the texel. Ends with 7 where the nearest look-up in the isotropic layout lies outside
//! of +-0.15 octaves of the first truth in more than 5 % on either side.

use std::error::Error;
use std::f64::consts::TAU;
use std::process::ExitCode;
use std::sync::OnceLock;

use brdfit_bandwidth::{
    AngularMap, Atlas, AtlasChannels, AtlasPlace, Estimator, LOBE_TEXELS, Layout, Lobe, LobeEstimator, LobeGrid,
    LobeMemory, LobeOptions, compute_atlas,
};
use brdfit_brdf::{Brdf, Direction, Directions, FixedOutgoing, cosine_sample, direction};
use rayon::prelude::*;

mod support;

/// Pairs, each with an incident direction of its own.
const PAIRS: usize = 10_000;
/// The second truth needs a map of all samples per incident direction: fewer of them, with more outgoing ones each.
const FEW: usize = 100;
const FLOOR: f32 = 0.1;
/// Octaves, 5 to 95 %.
const BAR: f32 = 0.15;

/// A pair of unit vectors.
#[derive(Clone, Copy)]
struct Pair {
    i: Direction,
    o: Direction,
}

/// The atlases of a material.
struct Atlases {
    isotropic: Atlas,
    hemisphere: Atlas,
}

/// What is read of them.
/// A way to look a pair up.
type LookUp = fn(&Atlases, &Pair) -> f32;

const LOOKUPS: [(&str, LookUp); 4] = [
    ("isotropic", |all, pair| all.isotropic.nearest(&place(Layout::Isotropic, pair), 0)[0]),
    ("isotropic, bilinear", |all, pair| all.isotropic.bilinear(&place(Layout::Isotropic, pair), 0)[0]),
    ("isotropic, level 2", |all, pair| all.isotropic.nearest(&place(Layout::Isotropic, pair), 2)[0]),
    ("hemisphere", |all, pair| all.hemisphere.nearest(&place(Layout::Hemisphere, pair), 0)[0]),
];

fn main() -> Result<ExitCode, Box<dyn Error>> {
    let grid = LobeGrid::default();
    let mut within = true;
    println!(
        "log2(look-up / truth), octaves, floor {FLOOR}. Texel: {PAIRS} incident directions. Sample: {FEW}, {} pairs each.\n",
        PAIRS / FEW
    );
    println!(
        "| material | look-up | texel 5 % | 50 % | 95 % | sample 5 % | 50 % | 95 % |\n|---|---|---|---|---|---|---|---|"
    );
    for path in std::env::args().skip(1) {
        let (name, brdf) = support::open(&path)?;
        let brdf = brdf.as_ref();
        let options = LobeOptions::default();
        let atlas = |layout| compute_atlas(brdf, layout, AtlasChannels::Max, &grid, &options).map(|made| made.0);
        let atlases = Atlases { isotropic: atlas(Layout::Isotropic)?, hemisphere: atlas(Layout::Hemisphere)? };
        let lobes = LobeEstimator::new(brdf, &grid, true, options);
        let texels = by_texel(brdf, &lobes);
        let samples = by_sample(brdf, &lobes);
        for (lookup, read) in LOOKUPS {
            let [texel, sample] = [&texels, &samples].map(|truths| quantiles(&atlases, read, truths));
            let line: Vec<String> = texel.iter().chain(&sample).map(|octaves| format!("{octaves:+.2}")).collect();
            println!("| {name} | {lookup} | {} |", line.join(" | "));
            within &= lookup != "isotropic" || texel[0] >= -BAR && texel[2] <= BAR;
        }
    }
    Ok(if within { ExitCode::SUCCESS } else { ExitCode::from(7) })
}

/// The 5, 50 and 95 % quantiles of log2(look-up / truth).
fn quantiles(atlases: &Atlases, read: fn(&Atlases, &Pair) -> f32, truths: &[(Pair, f32)]) -> [f32; 3] {
    let octaves = |(pair, truth): &(Pair, f32)| (read(atlases, pair).max(FLOOR) / truth.max(FLOOR)).log2();
    let mut errors: Vec<f32> = truths.iter().map(octaves).collect();
    errors.sort_unstable_by(f32::total_cmp);
    [0.05, 0.5, 0.95].map(|share| errors[(share * errors.len() as f64) as usize])
}

fn place(layout: Layout, pair: &Pair) -> AtlasPlace {
    let [i, o] = [pair.i, pair.o].map(|d| [d.x as f32, d.y as f32, d.z as f32]);
    AtlasPlace::new(layout, i, o)
}

/// The column and row of the outgoing direction on a map of n x n about the plane of incidence.
fn map_texel(pair: &Pair, n: usize) -> [usize; 2] {
    place(Layout::Isotropic, pair).position.map(|position| ((position * n as f32) as usize).min(n - 1))
}

/// The incident direction turned to azimuth 0.
fn turned(i: &Direction) -> Direction {
    direction(libm::acos(i.z.min(1.0)), 0.0)
}

/// Point n of Roberts' R sequence in five dimensions (2018, "The unreasonable effectiveness of quasirandom sequences"): evenly
/// spread and without a period.
fn spread(n: usize) -> [f64; 5] {
    // the root of x^6 = x + 1
    const ROOT: f64 = 1.134_724_138_401_519_5;
    std::array::from_fn(|d| (0.5 + n as f64 * ROOT.powi(-1 - d as i32)).fract())
}

/// The first sample above the horizon from draw `n` on.
fn outgoing(brdf: &dyn Brdf, i: &Direction, n: usize) -> Direction {
    let draws = (n..).step_by(PAIRS).map(spread);
    draws.filter_map(|[_, _, a, b, c]| brdf.sample(i, [a, b, c])).find(|o| o.z > 0.0).expect("draws never end")
}

/// Pairs with the texel of the lobe of exactly their incident direction.
fn by_texel(brdf: &dyn Brdf, lobes: &LobeEstimator<'_>) -> Vec<(Pair, f32)> {
    let truth = |memory: &mut LobeMemory, n: usize| {
        let [a, b, ..] = spread(n);
        let i = cosine_sample([a, b]);
        let pair = Pair { i, o: outgoing(brdf, &i, n) };
        let lobe = lobes.estimate(&turned(&i), memory);
        let [column, row] = map_texel(&pair, LOBE_TEXELS);
        let texel = row * LOBE_TEXELS + column;
        (pair, lobe.texels.iter().map(|channel| channel[texel]).fold(0.0, f32::max))
    };
    (0..PAIRS).into_par_iter().map_init(LobeMemory::default, truth).collect()
}

/// Pairs with the bandwidth at the sample of the lobe, drawn at the resolution that the atlas gives it, that lies nearest to the
/// outgoing direction. Here the whole lobe is transformed, by the estimator for images of any kind.
fn by_sample(brdf: &dyn Brdf, lobes: &LobeEstimator<'_>) -> Vec<(Pair, f32)> {
    let directions: [OnceLock<Directions>; 3] = Default::default();
    let prepared: [OnceLock<Box<dyn FixedOutgoing + '_>>; 3] = Default::default();
    let truths = |memory: &mut LobeMemory, k: usize| {
        let i = direction(libm::asin(((k as f64 + 0.5) / FEW as f64).sqrt()), TAU * spread(k)[0]);
        let Lobe { resolution: size, .. } = lobes.estimate(&turned(&i), memory);
        let map = AngularMap::new(size);
        let which = size.ilog2() as usize - 8;
        let directions =
            directions[which].get_or_init(|| (0..size * size).map(|n| map.direction(n / size, n % size)).collect());
        let prepared = prepared[which].get_or_init(|| brdf.towards(directions));
        let mut values: [Vec<f32>; 3] = std::array::from_fn(|_| vec![0.0; size * size]);
        prepared.values(&turned(&i), 0, values.each_mut().map(Vec::as_mut_slice));
        let maps = values.map(|values| Estimator::default().local_bandwidth(&values, size, size));
        let pairs = (0..PAIRS / FEW).map(|n| Pair { i, o: outgoing(brdf, &i, k * PAIRS / FEW + n) });
        let truth = |pair: Pair| {
            let [column, row] = map_texel(&pair, size);
            let highest = maps.iter().map(|map| map[row * size + column]).fold(0.0, f32::max);
            (pair, highest * map.cycles_per_radian(row, column) as f32)
        };
        pairs.map(truth).collect::<Vec<_>>()
    };
    (0..FEW).into_par_iter().map_init(LobeMemory::default, truths).collect::<Vec<_>>().concat()
}
