//! A tabulated distribution of half vectors around the normal.

use crate::math::fraction_nodes::FractionNodes;
use wide::f32x8;

/// A distribution of `x = tan^2 theta_h`, uniform in azimuth, with a density that is linear between nodes, constant below the
/// first and zero beyond the last. What is drawn and its density belong together exactly, up to rounding, however coarse
/// the table: how well it follows its model only matters for the variance.
///
/// The nodes are the numbers in single precision whose fraction ends after 5 bits, 32 per power of two, so that interval and
/// place in it are read off the bits of x, without a logarithm. A density that falls like `e^(-x/alpha)` is reproduced within
/// `(x / alpha)^2 / 8192`.
///
/// The density of h in 1/sr is `density / (pi cos^3 theta_h)`, that of a direction reflected about it `1 / (4 cos theta_d)` of that.
#[derive(Clone, Debug)]
pub struct HalfVectorTable {
    nodes: FractionNodes,
    /// Density per unit of x at the nodes; the last twice.
    densities: Vec<f32>,
    intervals: Vec<Interval>,
    /// Entry c: the interval of the number `c / cells`. Four cells per interval or more: most hold no end of one.
    guide: Vec<u16>,
}

/// From one node to the next; the first from zero to the first node.
#[derive(Clone, Copy, Debug)]
struct Interval {
    /// The share of what lies beyond: the number below which a draw ends beyond.
    beyond: f32,
    inverse_share: f32,
    upper: f32,
    width: f32,
    /// Share of the upper end in the sum of the densities of both ends.
    at_upper: f32,
}

impl HalfVectorTable {
    /// Tabulates `density`, per unit of `x = tan^2 theta_h` and up to a factor, between the nodes around `low` and `high`.
    /// `None` if it is zero or not finite there.
    ///
    /// # Panics
    /// Unless 1e-37 < low < high < 1e37.
    pub fn new(density: impl Fn(f64) -> f64, low: f64, high: f64) -> Option<Self> {
        assert!(1e-37 < low && low < high && high < 1e37, "no range: {low} to {high}");
        let nodes = FractionNodes::around(low, high);
        let x: Vec<f32> = nodes.nodes().collect();
        let found: Vec<f64> = x.iter().map(|&x| density(f64::from(x)).max(0.0)).collect();
        // lower end, upper end, densities there
        let ends = |n: usize| match n {
            0 => [0.0, f64::from(x[0]), found[0], found[0]],
            _ => [f64::from(x[n - 1]), f64::from(x[n]), found[n - 1], found[n]],
        };
        let mut beyond = vec![0.0; x.len() + 1];
        for n in (0..x.len()).rev() {
            let [lower, upper, a, b] = ends(n);
            beyond[n] = beyond[n + 1] + 0.5 * (a + b) * (upper - lower);
        }
        let total = beyond[0];
        if !(total > 0.0 && total.is_finite()) {
            return None;
        }
        let intervals: Vec<Interval> = (0..x.len())
            .map(|n| {
                let [lower, upper, a, b] = ends(n);
                let [here, further] = [beyond[n], beyond[n + 1]].map(|share| (share / total) as f32);
                Interval {
                    beyond: further,
                    inverse_share: if here > further { 1.0 / (here - further) } else { 0.0 },
                    upper: upper as f32,
                    width: (upper - lower) as f32,
                    at_upper: if a + b > 0.0 { (b / (a + b)) as f32 } else { 0.5 },
                }
            })
            .collect();
        let cells = (4 * intervals.len()).next_power_of_two();
        let guide = (0..cells)
            .map(|cell| intervals.partition_point(|interval| interval.beyond > cell as f32 / cells as f32) as u16)
            .chain([0])
            .collect();
        let mut densities: Vec<f32> = found.iter().map(|density| (density / total) as f32).collect();
        densities.extend(densities.last().copied());
        Some(Self { nodes, densities, intervals, guide })
    }

    /// `tan^2 theta_h` drawn from numbers in [0, 1); it falls as they grow.
    #[inline]
    pub fn sample_tan_square(&self, u: f32x8) -> f32x8 {
        let mut found = [[0.0; 8]; 4];
        let cells = (self.guide.len() - 1) as f32;
        for (lane, u) in u.to_array().into_iter().enumerate() {
            let cell = (u * cells) as usize;
            // the first whose beyond is not above u
            let (mut first, mut end) = (self.guide[cell + 1] as usize, self.guide[cell] as usize);
            while first < end {
                let middle = (first + end) / 2;
                if self.intervals[middle].beyond > u {
                    first = middle + 1;
                } else {
                    end = middle;
                }
            }
            let Interval { beyond, inverse_share, upper, width, at_upper } = self.intervals[first];
            let share = ((u - beyond) * inverse_share).min(1.0);
            (found[0][lane], found[1][lane], found[2][lane], found[3][lane]) = (share, upper, width, at_upper);
        }
        let [share, upper, width, at_upper] = found.map(f32x8::new);
        // share = 2 t a + t^2 (1 - 2a), from the upper end downwards
        let root = (at_upper * at_upper + (1.0 - (at_upper + at_upper)) * share).fast_max(f32x8::ZERO).sqrt();
        let t = share / (at_upper + root).fast_max(f32x8::splat(f32::MIN_POSITIVE));
        (upper - width * t.fast_min(f32x8::ONE)).fast_max(f32x8::ZERO)
    }

    /// The density with which [`Self::sample_tan_square`] draws `tan^2 theta_h`, per unit of it.
    #[inline]
    pub fn density(&self, tan_square: f32x8) -> f32x8 {
        let inside = tan_square.simd_le(f32x8::splat(self.nodes.high()));
        let (places, share) = self.nodes.place(tan_square);
        let mut ends = [[0.0; 8]; 2];
        for (lane, node) in places.into_iter().enumerate() {
            (ends[0][lane], ends[1][lane]) = (self.densities[node], self.densities[node + 1]);
        }
        let [lower, upper] = ends.map(f32x8::new);
        inside & (lower + (upper - lower) * share)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A density with a core, a tail and a hole.
    fn table() -> (HalfVectorTable, impl Fn(f64) -> f64) {
        let density = |x: f64| if (0.02..0.03).contains(&x) { 0.0 } else { 1e4 / (1.0 + 1e4 * x).powi(2) };
        (HalfVectorTable::new(density, 1e-7, 1e3).unwrap(), density)
    }

    fn at(found: impl Fn(f32x8) -> f32x8, x: f32) -> f64 {
        f64::from(found(f32x8::splat(x)).to_array()[5])
    }

    /// Between what two numbers draw, the density integrates to their difference.
    #[test]
    fn what_is_drawn_has_its_density() {
        let (table, _) = table();
        let mut worst: f64 = 0.0;
        for n in 0..2000 {
            let u = (n as f32 + 0.5) / 2000.0;
            let step = 2.0_f32.powi(-8) * u.min(1.0 - u);
            let [low, high] = [u + step, u - step].map(|u| at(|u| table.sample_tan_square(u), u));
            let width = (high - low) / 200.0;
            let middle = |k: i32| (low + (f64::from(k) + 0.5) * width) as f32;
            let share: f64 = (0..200).map(|k| at(|x| table.density(x), middle(k)) * width).sum();
            worst = worst.max((share / f64::from((u + step) - (u - step)) - 1.0).abs());
        }
        println!("largest relative difference of a share: {worst:.1e}");
        assert!(worst < 2e-3, "{worst}");
    }

    #[test]
    fn it_follows_its_model() {
        let (table, density) = table();
        // what the hole takes away
        let total = 1.0 - (1.0 / 201.0 - 1.0 / 301.0);
        let mut worst: f64 = 0.0;
        for n in 0..1900 {
            let x = 1e-8 * 1.0135_f64.powi(n);
            if x < 900.0 && !(0.018..0.032).contains(&x) {
                worst = worst.max((at(|x| table.density(x), x as f32) * total / density(x) - 1.0).abs());
            }
        }
        println!("largest relative difference from the model: {worst:.1e}");
        // below the first node the model is not quite constant
        assert!(worst < 2e-3, "{worst}");
        assert_eq!(at(|x| table.density(x), 0.025), 0.0);
        assert_eq!(at(|x| table.density(x), 2e3), 0.0);
    }

    #[test]
    fn extreme_numbers_stay_inside() {
        let (table, _) = table();
        for u in [0.0, f32::MIN_POSITIVE, 1e-9, 0.5, 1.0 - f32::EPSILON / 2.0] {
            let x = table.sample_tan_square(f32x8::splat(u)).to_array()[0];
            assert!((0.0..=1.1e3).contains(&x) && table.density(f32x8::splat(x)).to_array()[0] > 0.0, "{u}: {x}");
        }
        assert!(HalfVectorTable::new(|_| 0.0, 1e-3, 1.0).is_none());
    }
}
