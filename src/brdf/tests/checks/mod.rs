//! What holds for the batch of every model: draws follow the density, and weights average to the albedo.

use brdfit_brdf::{BatchBrdf, direction};
use std::f64::consts::{FRAC_PI_2, TAU};

/// Pseudorandom numbers in [0, 1) (Steele et al. 2014, SplitMix64).
fn random(seed: u64, count: usize) -> [Vec<f32>; 2] {
    let mut state = seed;
    let mut next = || {
        state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (state ^ (state >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 40) as f32 / 16_777_216.0
    };
    let pairs: Vec<[f32; 2]> = (0..count).map(|_| [next(), next()]).collect();
    [0, 1].map(|axis: usize| pairs.iter().map(|pair| pair[axis]).collect())
}

/// Kronecker's sequence of the golden ratio of dimension two: deterministic, even.
fn even(count: usize) -> [Vec<f32>; 2] {
    [0.754_877_666_246_692_7, 0.569_840_290_998_053_3].map(|step| {
        let at = |n: usize| ((0.5 + n as f64 * step).fract() as f32).min(1.0 - f32::EPSILON / 2.0);
        (0..count).map(at).collect()
    })
}

fn toward(theta_o: f64, count: usize) -> [Vec<f32>; 3] {
    let o = direction(theta_o, 0.4);
    [o.x, o.y, o.z].map(|v| vec![v as f32; count])
}

fn drawn(batch: &dyn BatchBrdf, o: &[Vec<f32>; 3], u: &[Vec<f32>; 2]) -> [Vec<f32>; 3] {
    let mut i = [0; 3].map(|_| vec![f32::NAN; u[0].len()]);
    batch.sample(o.each_ref().map(Vec::as_slice), u.each_ref().map(Vec::as_slice), i.each_mut().map(Vec::as_mut_slice));
    i
}

/// Values and density.
pub(crate) fn evaluated(batch: &dyn BatchBrdf, i: &[Vec<f32>; 3], o: &[Vec<f32>; 3]) -> ([Vec<f32>; 3], Vec<f32>) {
    let count = i[0].len();
    let (mut values, mut density) = ([0; 3].map(|_| vec![f32::NAN; count]), vec![f32::NAN; count]);
    batch.evaluate(
        i.each_ref().map(Vec::as_slice),
        o.each_ref().map(Vec::as_slice),
        values.each_mut().map(Vec::as_mut_slice),
        &mut density,
    );
    (values, density)
}

/// `ln tan theta_h` and azimuth of the half vectors of what was drawn above the horizon.
fn half_vectors(i: &[Vec<f32>; 3], o: &[Vec<f32>; 3]) -> Vec<[f64; 2]> {
    (0..i[0].len())
        .filter(|&n| i[2][n] > 0.0)
        .map(|n| {
            let [x, y, z] = [0, 1, 2].map(|axis: usize| f64::from(i[axis][n]) + f64::from(o[axis][n]));
            [libm::log(libm::hypot(x, y).max(1e-9) / z), libm::atan2(y, x).rem_euclid(TAU)]
        })
        .collect()
}

/// Pearson's test of 200 000 draws against the integrals of the density over 24 rings of half vectors, as full as each other,
/// and 8 azimuths. Returns chi-square as a standard normal deviate (Wilson and Hilferty 1931), the integral over all and the
/// share that was drawn above the horizon.
fn chi_square(batch: &dyn BatchBrdf, theta_o: f64, seed: u64) -> [f64; 3] {
    const COUNT: usize = 200_000;
    const RINGS: usize = 24;
    const AZIMUTHS: usize = 8;
    const STEPS: usize = 40;
    let o = toward(theta_o, COUNT);
    // rings from other draws than those that are counted
    let mut places: Vec<f64> =
        half_vectors(&drawn(batch, &o, &random(seed ^ 0xabcd, COUNT)), &o).iter().map(|h| h[0]).collect();
    places.sort_by(f64::total_cmp);
    let edges: Vec<f64> = (1..RINGS).map(|n| places[n * places.len() / RINGS]).collect();
    let mut counts = vec![0.0; RINGS * AZIMUTHS];
    let half = half_vectors(&drawn(batch, &o, &random(seed, COUNT)), &o);
    for [place, azimuth] in &half {
        let ring = edges.partition_point(|edge| edge <= place);
        counts[ring * AZIMUTHS + ((azimuth / TAU * AZIMUTHS as f64) as usize).min(AZIMUTHS - 1)] += 1.0;
    }
    let o_direction = direction(theta_o, 0.4);
    let (mut statistic, mut degrees, mut total) = (0.0, -1.0, 0.0);
    let mut pooled = [0.0; 2];
    for ring in 0..RINGS {
        // the innermost and outermost rings in theta, the others in ln tan theta
        let theta = |n: f64| match ring {
            0 => n * libm::atan(libm::exp(edges[0])),
            _ if ring == RINGS - 1 => {
                let inner = libm::atan(libm::exp(edges[ring - 1]));
                // dense towards the inner edge
                inner * libm::pow(FRAC_PI_2 / inner, n)
            }
            _ => libm::atan(libm::exp(edges[ring - 1] + n * (edges[ring] - edges[ring - 1]))),
        };
        let steps = if ring == RINGS - 1 { 8 * STEPS } else { STEPS };
        for sector in 0..AZIMUTHS {
            let (mut i, mut weights) = ([0; 3].map(|_| Vec::new()), Vec::new());
            for a in 0..steps {
                let (low, high) = (theta(a as f64 / steps as f64), theta((a + 1) as f64 / steps as f64));
                let middle = 0.5 * (low + high);
                let area = 2.0 * libm::sin(middle) * libm::sin(0.5 * (high - low)) * TAU / (AZIMUTHS * STEPS) as f64;
                for b in 0..STEPS {
                    let h =
                        direction(middle, (sector as f64 + (b as f64 + 0.5) / STEPS as f64) / AZIMUTHS as f64 * TAU);
                    let cos_d = o_direction.dot(&h);
                    let drawn = h * (2.0 * cos_d) - o_direction;
                    for (i, v) in i.iter_mut().zip([drawn.x, drawn.y, drawn.z]) {
                        i.push(v as f32);
                    }
                    weights.push(area * 4.0 * cos_d.max(0.0));
                }
            }
            let (_, density) = evaluated(batch, &i, &toward(theta_o, weights.len()));
            let share: f64 = density.iter().zip(&weights).map(|(&density, weight)| f64::from(density) * weight).sum();
            total += share;
            pooled[0] += counts[ring * AZIMUTHS + sector];
            pooled[1] += share * COUNT as f64;
            if pooled[1] > 20.0 {
                statistic += (pooled[0] - pooled[1]).powi(2) / pooled[1];
                degrees += 1.0;
                pooled = [0.0; 2];
            }
        }
    }
    let spread = 2.0 / (9.0 * degrees);
    let deviate = (libm::cbrt(statistic / degrees) - (1.0 - spread)) / f64::sqrt(spread);
    [deviate, total, half.len() as f64 / COUNT as f64]
}

/// The directional albedo by draws, and the largest weight `f cos / density` of any channel.
pub(crate) fn furnace(batch: &dyn BatchBrdf, theta_o: f64, count: usize) -> ([f64; 3], f64) {
    let o = toward(theta_o, count);
    let i = drawn(batch, &o, &even(count));
    let (values, density) = evaluated(batch, &i, &o);
    let (mut sums, mut largest) = ([0.0; 3], 0.0_f64);
    for n in (0..count).filter(|&n| i[2][n] > 0.0) {
        assert!(density[n] > 0.0, "a direction that cannot be drawn was drawn");
        for c in 0..3 {
            let weight = f64::from(values[c][n]) * f64::from(i[2][n]) / f64::from(density[n]);
            sums[c] += weight / count as f64;
            largest = largest.max(weight);
        }
    }
    (sums, largest)
}

/// Draws and the density belong together, seen from several directions.
pub(crate) fn check_draws(name: &str, batch: &dyn BatchBrdf) {
    for (n, theta_o) in [0.1, 0.8, 1.35].into_iter().enumerate() {
        let [deviate, integral, above] = chi_square(batch, theta_o, 77 + n as u64);
        println!(
            "{name} {theta_o}: chi-square {deviate:+.2} standard deviations, integral {integral:.4}, above {above:.4}"
        );
        assert!(deviate < 4.0, "{name} {theta_o}: {deviate}");
        assert!((integral - above).abs() < 4e-3, "{name} {theta_o}: {integral} {above}");
    }
}
