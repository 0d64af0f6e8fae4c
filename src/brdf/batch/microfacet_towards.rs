//! Microfacet models towards many fixed directions, eight at a time in single precision.

use crate::batch::fixed_outgoing::{Directions, FixedOutgoing};
use crate::batch::microfacet_channel::{HalfAngles, MicrofacetChannel};
use crate::distributions::normal_distribution::NormalDistribution;
use crate::masking::curve::G1Curve;
use crate::masking::masking::Masking;
use crate::math::direction::{Direction, sine};
use crate::math::log_exp::log2;
use crate::models::microfacet::Microfacet;
use wide::f32x8;

/// Directions that are evaluated together.
const LANES: usize = 8;
/// `tan^2 theta_h` is cut here: even the widest distribution is zero before, and its square stays finite.
const LARGEST_TAN_SQUARE: f32 = 1e9;

/// [`FixedOutgoing`] of three channels.
///
/// # Accuracy
/// Against the evaluation in double precision at the same `o` (that is [`Directions::get`]), for the SGD model with alpha in [1e-6, 1], p in
/// [0, 2] and both angles up to arccos 0.02, without a diffuse term: within 3e-6 relative where `f` is above 1e-3 of its value in
/// the mirror direction, within 3e-5 down to 1e-30 of it (test below). This includes the core of the sharpest lobes, where
/// `tan theta_h` of 1e-7 matters: the sum of `i` and `o` is formed with what single precision leaves of `i` and of the length
/// of `o`. It does not include the distance of up to 6e-8 rad between a direction that is meant and the nearest that
/// [`Directions`] can hold, which in the core at alpha = 1e-6 moves `f` itself by several percent.
pub(crate) struct MicrofacetTowards<'a, D: NormalDistribution<N>, const N: usize> {
    o: &'a Directions,
    /// Lengths of the directions, less one: rounding leaves some 1e-7.
    excess: Vec<f32>,
    /// `G1(theta_o) / cos theta_o` per channel and direction.
    masking: [Vec<f32>; 3],
    curves: [&'a D::Masking; 3],
    channels: [MicrofacetChannel<D::Lanes>; 3],
}

/// One incident direction.
struct Incident {
    /// Components rounded to single precision.
    rounded: [f32; 3],
    /// What rounding took from those along the surface.
    rest: [f32; 2],
    /// `rho_s height G1(theta_i) / (c pi cos theta_i)` per channel.
    specular: [f32; 3],
}

impl<'a, D: NormalDistribution<N>, const N: usize> MicrofacetTowards<'a, D, N> {
    pub(crate) fn new(channels: [(&'a Microfacet<D, N>, &'a D::Masking); 3], o: &'a Directions) -> Self {
        let length_excess = |((&x, &y), &z): ((&f32, &f32), &f32)| {
            let [x, y, z] = [x, y, z].map(f64::from);
            (0.5 * (x * x + y * y + z * z - 1.0)) as f32
        };
        let excess = o.x.iter().zip(&o.y).zip(&o.z).map(length_excess).collect();
        let mut masking = [0; 3].map(|_| vec![0.0; o.len()]);
        for n in (0..o.len()).step_by(LANES) {
            let [x, y, cos] = [&o.x, &o.y, &o.z].map(|component| f32x8::from(eight_from(&component[n..])));
            let above = cos.simd_gt(f32x8::ZERO);
            let sin = (x * x + y * y).sqrt().fast_max(f32x8::splat(1e-12));
            let log2_cot = log2((cos / sin).fast_max(f32x8::splat(1e-30))).to_array();
            let positions = log2_cot.map(|log2_cot| G1Curve::position_from_log2(log2_cot.into()));
            let (cosines, sines) = (cos.to_array().map(f64::from), sin.to_array().map(f64::from));
            for (masking, (_, curve)) in masking.iter_mut().zip(channels) {
                let mu_lambda = |n: usize| curve.mu_lambda(cosines[n], sines[n], positions[n]) as f32;
                let inverse = cos + sin * f32x8::from(std::array::from_fn(mu_lambda));
                // finite: infinity times a lobe of zero is no number
                let g1_over_cos = above & (1.0 / inverse.fast_max(f32x8::splat(f32::MIN_POSITIVE)));
                let count = masking.len().min(n + LANES) - n;
                masking[n..n + count].copy_from_slice(&g1_over_cos.as_array()[..count]);
            }
        }
        Self {
            o,
            excess,
            masking,
            curves: channels.map(|(_, curve)| curve),
            channels: channels.map(|(channel, _)| MicrofacetChannel::new(channel)),
        }
    }

    /// The three channels towards directions in number a multiple of eight: `stored` are their components, excess and masking.
    fn blocks(&self, i: &Incident, stored: [&[f32]; 7], values: [&mut [f32]; 3]) {
        let [x, y, z, excess, masking_r, masking_g, masking_b] = stored.map(|numbers| numbers.as_chunks::<LANES>().0);
        let [r, g, b] = values.map(|channel| channel.as_chunks_mut::<LANES>().0);
        for n in 0..excess.len() {
            let o = [x[n], y[n], z[n]].map(f32x8::from);
            let masking = [masking_r[n], masking_g[n], masking_b[n]].map(f32x8::from);
            [r[n], g[n], b[n]] = self.eight(i, o, excess[n].into(), masking).map(f32x8::to_array);
        }
    }

    /// The three channels towards eight directions.
    #[inline(always)]
    fn eight(&self, i: &Incident, [x, y, z]: [f32x8; 3], excess: f32x8, masking: [f32x8; 3]) -> [f32x8; 3] {
        let [ix, iy, iz] = i.rounded.map(f32x8::splat);
        // i |o| + o, of length 2 cos theta_d: near the mirror direction the first sum is exact
        let h_x = (ix + x) + (ix * excess + i.rest[0]);
        let h_y = (iy + y) + (iy * excess + i.rest[1]);
        let h_z = iz + z;
        let across = h_x * h_x + h_y * h_y;
        let along = h_z * h_z;
        let tan_square = (across / along).fast_min(f32x8::splat(LARGEST_TAN_SQUARE));
        let half = HalfAngles::new(tan_square, (across + along).sqrt() * 0.5);
        let above = z.simd_gt(f32x8::ZERO);
        [0, 1, 2].map(|c: usize| {
            let channel = &self.channels[c];
            let scale = f32x8::splat(i.specular[c]);
            above & channel.value(channel.lobe(&half), &half, scale, [masking[c], f32x8::ONE])
        })
    }
}

impl<D: NormalDistribution<N>, const N: usize> FixedOutgoing for MicrofacetTowards<'_, D, N> {
    fn values(&self, i: &Direction, first: usize, mut values: [&mut [f32]; 3]) {
        let count = values[0].len();
        assert!(values.iter().all(|channel| channel.len() == count), "the channels differ in length");
        if i.z <= 0.0 {
            return values.into_iter().for_each(|channel| channel.fill(0.0));
        }
        let specular = self.channels.each_ref().map(|channel| channel.specular);
        let i = Incident::new(i, specular, self.curves);
        let [masking_r, masking_g, masking_b] = &self.masking;
        let stored = [&self.o.x, &self.o.y, &self.o.z, &self.excess, masking_r, masking_g, masking_b]
            .map(|numbers| &numbers[first..first + count]);
        let whole = count - count % LANES;
        self.blocks(
            &i,
            stored.map(|numbers| &numbers[..whole]),
            values.each_mut().map(|channel| &mut channel[..whole]),
        );
        let rest = stored.map(|numbers| eight_from(&numbers[whole..]));
        let mut last = [[0.0; LANES]; 3];
        self.blocks(
            &i,
            rest.each_ref().map(|numbers| numbers.as_slice()),
            last.each_mut().map(|channel| channel.as_mut_slice()),
        );
        for (values, last) in values.iter_mut().zip(last) {
            values[whole..].copy_from_slice(&last[..count - whole]);
        }
    }
}

impl Incident {
    fn new<M: Masking>(i: &Direction, specular: [f64; 3], curves: [&M; 3]) -> Self {
        let rounded = [i.x as f32, i.y as f32, i.z as f32];
        let [cos, sin, position] = place(i.z);
        Self {
            rounded,
            rest: [(i.x - f64::from(rounded[0])) as f32, (i.y - f64::from(rounded[1])) as f32],
            specular: std::array::from_fn(|c| {
                let specular = specular[c] * curves[c].g1_over_cos(cos, sin, position);
                // finite, as above
                (specular as f32).clamp(-f32::MAX, f32::MAX)
            }),
        }
    }
}

/// The first eight numbers; zeros for those that are missing.
fn eight_from(numbers: &[f32]) -> [f32; LANES] {
    let mut eight = [0.0; LANES];
    let count = numbers.len().min(LANES);
    eight[..count].copy_from_slice(&numbers[..count]);
    eight
}

/// Cosine above zero, sine and position in the masking curves.
fn place(cos: f64) -> [f64; 3] {
    let sin = sine(cos).max(1e-12);
    [cos, sin, G1Curve::position(cos, sin)]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::brdf::Brdf;
    use crate::math::direction::{direction, reflect};
    use crate::models::sgd::{SgdMaterial, SgdParameters};
    use std::f64::consts::PI;

    const LIMIT: f64 = 0.02;

    fn values(material: &SgdMaterial, i: &Direction, o: &Directions) -> [Vec<f32>; 3] {
        let mut values = [0; 3].map(|_| vec![f32::NAN; o.len()]);
        material.towards(o).values(i, 0, values.each_mut().map(Vec::as_mut_slice));
        values
    }

    /// Mirror directions about normals from the core of the distribution to its tail, and a grid over the hemisphere.
    fn directions(i: &Direction, alpha: f64) -> Directions {
        let around = |theta_h: f64| (0..7).map(move |n| direction(theta_h, 0.2 + f64::from(n)));
        let normals = (0..40)
            .flat_map(|n| around(0.02 * alpha * libm::exp2(0.25 * f64::from(n))))
            .chain((0..40).flat_map(|n| around(0.2 * f64::from(n) * alpha.sqrt())));
        let mirrored = normals.map(|h| reflect(i, &h));
        let grid = (0..900).map(|n| direction(f64::from(n / 30) / 29.0 * libm::acos(LIMIT), f64::from(n % 30) / 5.0));
        mirrored.chain(grid).filter(|o| o.z >= LIMIT).collect()
    }

    #[test]
    fn stay_close_to_double_precision() {
        // down to 1e-3 and to 1e-30 of the value in the mirror direction
        let mut worst = [0.0_f64; 2];
        for alpha in [1e-6, 1e-5, 1e-4, 1e-3, 0.01, 0.1, 1.0] {
            for p in [[0.0, 0.3, 0.6], [0.9, 1.0, 1.1], [1.4, 1.7, 2.0]] {
                let channel = |p| SgdParameters { rho_d: 0.0, rho_s: 0.5, alpha, p, f0: 0.2, f1: -0.1 };
                let material = SgdMaterial::new(p.map(channel)).unwrap();
                for cos in [1.0, 0.9, 0.5, 0.1, LIMIT] {
                    let i = direction(libm::acos(cos), 0.7);
                    let o = directions(&i, alpha);
                    let peak = material.value(&i, &direction(libm::acos(cos), 0.7 + PI));
                    let ours = values(&material, &i, &o);
                    for n in 0..o.len() {
                        let exact = material.value(&i, &o.get(n));
                        for c in 0..3 {
                            let (ours, share) = (f64::from(ours[c][n]), exact[c] / peak[c]);
                            if share < 1e-30 {
                                assert!(ours < 1e-29 * peak[c], "alpha {alpha} p {}: {ours} {}", p[c], exact[c]);
                                continue;
                            }
                            let depth = usize::from(share < 1e-3);
                            worst[depth] = worst[depth].max((ours / exact[c] - 1.0).abs());
                        }
                    }
                }
            }
        }
        println!(
            "largest relative errors down to 1e-3 and 1e-30 of the mirror direction: {:.1e} {:.1e}",
            worst[0], worst[1]
        );
        assert!(worst[0] < 3e-6 && worst[1] < 3e-5, "{worst:?}");
    }

    #[test]
    fn the_whole_domain_gives_numbers() {
        for (alpha, p) in [(1e-12, 2.0), (1e-6, -89.0), (1.0, -80.0), (100.0, 19.0), (100.0, -89.0), (0.01, 19.0)] {
            let channel = |rho_s| SgdParameters { rho_d: 0.1, rho_s, alpha, p, f0: 0.2, f1: -0.1 };
            let material = SgdMaterial::new([channel(0.5), channel(0.0), channel(-0.3)]).unwrap();
            for theta in [0.0, 1.0, 1.57, PI / 2.0 - 1e-9] {
                let i = direction(theta, 2.0);
                let mut o = directions(&i, alpha.min(1.0));
                for [x, z] in [[0.0, 1.0], [1.0, 1e-30], [0.6, -0.8], [1.0, 0.0]] {
                    o.x.push(x);
                    o.y.push(0.0);
                    o.z.push(z);
                }
                let ours = values(&material, &i, &o);
                for n in 0..o.len() {
                    let exact = if o.z[n] > 0.0 { material.value(&i, &o.get(n)) } else { [0.0; 3] };
                    for c in 0..3 {
                        let ours = f64::from(ours[c][n]);
                        assert!(
                            (ours - exact[c]).abs() <= 1e-3 * exact[c].abs(),
                            "alpha {alpha} p {p}: {ours} {}",
                            exact[c]
                        );
                    }
                }
            }
            let below = values(&material, &direction(1.6, 0.0), &directions(&direction(0.3, 0.0), 1.0));
            assert!(below.iter().flatten().all(|&f| f == 0.0));
        }
    }

    #[test]
    fn values_do_not_depend_on_the_block_and_mirrored_ones_are_the_same() {
        let channel = |alpha| SgdParameters { rho_d: 0.05, rho_s: 0.3, alpha, p: 0.6, f0: 0.3, f1: 0.1 };
        let material = SgdMaterial::new([channel(0.002), channel(0.01), channel(0.15)]).unwrap();
        let i = direction(0.5, 0.0);
        let o = directions(&direction(0.5, 1.0), 0.01);
        let all = values(&material, &i, &o);
        let lobes = material.towards(&o);
        for (first, count) in [(0, 1), (3, 7), (5, 8), (9, 17), (o.len() - 5, 5), (o.len(), 0)] {
            let mut some = [0; 3].map(|_| vec![f32::NAN; count]);
            lobes.values(&i, first, some.each_mut().map(Vec::as_mut_slice));
            assert_eq!(some, all.each_ref().map(|channel| channel[first..first + count].to_vec()));
        }
        let mirrored = Directions { y: o.y.iter().map(|y| -y).collect(), ..o.clone() };
        assert_eq!(values(&material, &i, &mirrored), all);
    }
}
