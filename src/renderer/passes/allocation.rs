//! Sample allocation: the number of samples of each shading point.

use rayon::prelude::*;

use crate::geometry::gbuffer::GBuffer;
use crate::passes::image_bandwidth::COARSEST_LEVEL;
use crate::passes::pass::Pass;
use crate::passes::pilot::Pilot;
use crate::passes::shading_list::ShadingPoint;

/// Fewest samples of a shading point.
const LEAST_SAMPLES: u32 = 4;
/// Most samples of a shading point.
const MOST_SAMPLES: u32 = 16_384;
/// Added to a mean, in units of the mean of the image: regularises the relative error of dark pixels.
const DARK: f32 = 0.06;
/// Least share of the mean request.
const LEAST_REQUEST: f64 = 0.05;
/// Steps of the search for the scale of the requests.
const STEPS: usize = 12;
/// Pixels along a side of the grid that predictions of a cell are averaged over.
const GRID: usize = 4;

/// From predictions to relative requests.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Allocation {
    /// `q = sqrt(v A) / (L + e)`: the least mean relative error of the image for the budget.
    #[default]
    Variance,
    /// The published bound of the variance, maximum over the cell (Bagher et al. 2013, equation 9).
    Published,
    /// The same for every point.
    Even,
}

/// Criterion of the sample allocation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Budget {
    /// Mean samples per pixel of a surface, the pilot's not counted.
    SamplesPerPixel(f64),
    /// Predicted relative error, root mean square over the pixels.
    TargetError(f64),
}

/// When the light is prefiltered and sampled by the BRDF alone (filtered importance sampling).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Prefilter {
    /// Never: every shaded pixel is unbiased.
    #[default]
    Never,
    /// At points whose predicted relative error with unbiased samples is larger than this.
    Above(f32),
    /// Everywhere.
    Always,
}

/// Prediction for the cell of a shading point: means over its grid, the maximum for the published bound.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct CellPrediction {
    mean: f32,
    variance: f32,
    published: f32,
}

/// Samples of each shading point, in the order of the list.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct SampleCounts {
    /// Samples that a point takes.
    pub(crate) samples: Vec<u32>,
    /// Whether the light is prefiltered at a point: less noise, some bias.
    pub(crate) prefiltered: Vec<bool>,
}

impl SampleCounts {
    /// Samples of all points.
    pub(crate) fn total(&self) -> u64 {
        self.samples.iter().map(|&samples| u64::from(samples)).sum()
    }
}

/// The same number of samples for every point.
pub(crate) struct EqualCountsPass {
    /// Number of shading points.
    pub(crate) points: usize,
    /// Samples of each.
    pub(crate) samples: u32,
    /// Whether the light is prefiltered.
    pub(crate) prefiltered: bool,
}

impl Pass for EqualCountsPass {
    type Output = SampleCounts;

    fn run(&self, counts: &mut SampleCounts) {
        counts.samples.clear();
        counts.samples.resize(self.points, self.samples);
        counts.prefiltered.clear();
        counts.prefiltered.resize(self.points, self.prefiltered);
    }
}

/// Distributes a budget over the shading points by their predictions.
pub(crate) struct AllocationPass<'a> {
    pub(crate) gbuffer: &'a GBuffer,
    pub(crate) pilot: &'a Pilot,
    pub(crate) points: &'a [ShadingPoint],
    pub(crate) allocation: Allocation,
    pub(crate) budget: Budget,
    /// Surface pixels.
    pub(crate) foreground: usize,
    pub(crate) prefilter: Prefilter,
}

impl Pass for AllocationPass<'_> {
    type Output = SampleCounts;

    fn run(&self, counts: &mut SampleCounts) {
        let predict = |point| cell_prediction(self.gbuffer, self.pilot, point);
        let predictions: Vec<CellPrediction> = self.points.par_iter().with_min_len(256).map(predict).collect();
        let dark = dark(self.pilot);
        let requests = self.requests(&predictions, dark);
        let scale = match self.budget {
            Budget::SamplesPerPixel(samples) => scale_for_total(&requests, samples * self.foreground as f64),
            Budget::TargetError(error) => {
                let areas: f64 = self.points.iter().map(area).sum();
                scale_for_error(&requests, &self.errors(&predictions, dark), error * error * areas)
            }
        };
        counts.samples.clear();
        counts.samples.extend(requests.iter().map(|&request| count(scale, request)));
        let prefiltered = |(cell, &samples): (&CellPrediction, &u32)| match self.prefilter {
            Prefilter::Never => false,
            Prefilter::Always => true,
            Prefilter::Above(threshold) => (cell.variance / samples as f32).sqrt() > threshold * (cell.mean + dark),
        };
        counts.prefiltered.clear();
        counts.prefiltered.extend(predictions.iter().zip(&counts.samples).map(prefiltered));
    }
}

impl AllocationPass<'_> {
    /// Relative number of samples of each point, at least a share of their mean.
    fn requests(&self, predictions: &[CellPrediction], dark: f32) -> Vec<f64> {
        let request = |(point, cell): (&ShadingPoint, &CellPrediction)| match self.allocation {
            Allocation::Variance => (f64::from(cell.variance) * area(point)).sqrt() / cell.mean_above(dark),
            Allocation::Published => f64::from(cell.published),
            Allocation::Even => 1.0,
        };
        let mut requests: Vec<f64> = self.points.par_iter().zip(predictions).map(request).collect();
        let mean = requests.iter().sum::<f64>() / requests.len().max(1) as f64;
        let least = if mean > 0.0 { LEAST_REQUEST * mean } else { 1.0 };
        requests.iter_mut().for_each(|request| *request = request.max(least));
        requests
    }

    /// Squared relative error of each point with one sample, times its area.
    fn errors(&self, predictions: &[CellPrediction], dark: f32) -> Vec<f64> {
        let error = |(point, cell): (&ShadingPoint, &CellPrediction)| {
            let mean = cell.mean_above(dark);
            area(point) * f64::from(cell.variance) / (mean * mean)
        };
        self.points.par_iter().zip(predictions).map(error).collect()
    }
}

impl CellPrediction {
    /// The mean and what counts as dark, above zero.
    fn mean_above(&self, dark: f32) -> f64 {
        f64::from((self.mean + dark).max(f32::MIN_POSITIVE))
    }
}

/// Pixels of a point's cell.
fn area(point: &ShadingPoint) -> f64 {
    f64::from(1_u32 << (2 * point.level.min(COARSEST_LEVEL as u8)))
}

/// Luminance below which relative error is regularised: a share of the mean prediction over the surface pixels.
fn dark(pilot: &Pilot) -> f32 {
    let (mut sum, mut count) = (0.0_f64, 0_u32);
    for prediction in pilot.points.of_pixel.iter().filter_map(|&point| pilot.predictions.get(point as usize)) {
        sum += f64::from(prediction.mean);
        count += 1;
    }
    (sum / f64::from(count.max(1))) as f32 * DARK
}

/// The prediction for the cell of a point, from up to 4 x 4 of its pixels on a regular grid.
fn cell_prediction(gbuffer: &GBuffer, pilot: &Pilot, point: &ShadingPoint) -> CellPrediction {
    let k = usize::from(point.level);
    let (left, top) = ((point.column as usize) << k, (point.row as usize) << k);
    let side = 1_usize << k;
    let (step, first) = (side.div_ceil(GRID), side.div_ceil(GRID) / 2);
    let mut cell = CellPrediction::default();
    let mut count = 0;
    for y in (top + first..(top + side).min(gbuffer.height)).step_by(step) {
        for x in (left + first..(left + side).min(gbuffer.width)).step_by(step) {
            if let Some(prediction) = pilot.at(y * gbuffer.width + x) {
                cell.mean += prediction.mean;
                cell.variance += prediction.variance;
                cell.published = cell.published.max(prediction.published);
                count += 1;
            }
        }
    }
    let share = 1.0 / count.max(1) as f32;
    CellPrediction { mean: cell.mean * share, variance: cell.variance * share, ..cell }
}

/// Samples for a request.
fn count(scale: f64, request: f64) -> u32 {
    (scale * request).round().clamp(LEAST_SAMPLES.into(), MOST_SAMPLES.into()) as u32
}

/// The scale with which the counts sum to a total, as near as the limits allow.
fn scale_for_total(requests: &[f64], total: f64) -> f64 {
    let mut scale = total / requests.iter().sum::<f64>().max(f64::MIN_POSITIVE);
    for _ in 0..STEPS {
        let sum: u64 = requests.iter().map(|&request| u64::from(count(scale, request))).sum();
        scale *= (total / (sum as f64).max(1.0)).clamp(0.2, 5.0);
    }
    scale
}

/// The scale with which the sum of `error / N` is `total`, as near as the limits allow: bisection on its logarithm.
fn scale_for_error(requests: &[f64], errors: &[f64], total: f64) -> f64 {
    let sum = |scale: f64| -> f64 {
        requests.iter().zip(errors).map(|(&request, error)| error / f64::from(count(scale, request))).sum()
    };
    let largest = requests.iter().fold(f64::MIN_POSITIVE, |largest, &request| largest.max(request));
    let least = requests.iter().fold(largest, |least, &request| least.min(request));
    let (mut low, mut high) = (f64::from(LEAST_SAMPLES) / largest, f64::from(MOST_SAMPLES) / least);
    for _ in 0..40 {
        let middle = (low * high).sqrt();
        if sum(middle) > total {
            low = middle;
        } else {
            high = middle;
        }
    }
    high
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn counts_sum_to_the_budget() {
        let requests: Vec<f64> = (1..2000).map(|n| f64::from(n % 37) + 0.1).collect();
        for total in [20_000.0, 100_000.0, 3e6] {
            let scale = scale_for_total(&requests, total);
            let sum: u64 = requests.iter().map(|&request| u64::from(count(scale, request))).sum();
            assert!((sum as f64 / total - 1.0).abs() < 0.01, "{sum} {total}");
        }
        // less than the least of all, more than the most of all
        assert!(requests.iter().all(|&request| count(scale_for_total(&requests, 10.0), request) == LEAST_SAMPLES));
        assert!(requests.iter().all(|&request| count(scale_for_total(&requests, 1e12), request) == MOST_SAMPLES));
    }

    #[test]
    fn the_target_error_is_met() {
        let requests: Vec<f64> = (1..2000).map(|n| f64::from(n % 37) + 1.0).collect();
        let errors: Vec<f64> = requests.iter().map(|request| request * request).collect();
        for target in [0.01, 0.1, 1.0] {
            let total = target * target * errors.len() as f64;
            let scale = scale_for_error(&requests, &errors, total);
            let sum: f64 = requests.iter().zip(&errors).map(|(&r, e)| e / f64::from(count(scale, r))).sum();
            // met as closely as whole numbers of samples allow; not below what the limits can reach
            let [least, most] = [LEAST_SAMPLES, MOST_SAMPLES]
                .map(|limit| requests.iter().zip(&errors).map(|(_, e)| e / f64::from(limit)).sum());
            let (low, high): (f64, f64) = (0.97 * total.clamp(most, least), 1.001 * total.clamp(most, least));
            assert!((low..=high).contains(&sum), "{sum} {total}");
        }
    }

    use crate::passes::pilot::Prediction;
    use crate::passes::pilot::points::PilotPoints;
    use crate::test_scenes::plane;

    /// A pilot with a point of its own at every pixel.
    fn pilot(predictions: &[(f32, f32)]) -> Pilot {
        let prediction = |&(mean, variance): &(f32, f32)| Prediction {
            mean,
            variance,
            published: 7.0 * mean,
            ..Prediction::default()
        };
        let points: Vec<u32> = (0..predictions.len() as u32).collect();
        Pilot {
            points: PilotPoints { of_pixel: points.clone(), pixels: points },
            predictions: predictions.iter().map(prediction).collect(),
            ..Pilot::default()
        }
    }

    fn point(level: u8, column: u16) -> ShadingPoint {
        ShadingPoint { level, material: 0, column, row: 0 }
    }

    fn counts(
        gbuffer: &GBuffer,
        pilot: &Pilot,
        points: &[ShadingPoint],
        allocation: Allocation,
        budget: Budget,
    ) -> Vec<u32> {
        let mut counts = SampleCounts::default();
        let prefilter = Prefilter::Never;
        let foreground = gbuffer.material.len();
        AllocationPass { gbuffer, pilot, points, allocation, budget, foreground, prefilter }.run(&mut counts);
        counts.samples
    }

    #[test]
    fn samples_follow_the_relative_error_of_a_cell() {
        // v = 1 and v = 4 at the same mean: q is as 1 to 2
        let pair = [point(0, 0), point(0, 1)];
        let budget = Budget::SamplesPerPixel(300.0);
        let same_mean = pilot(&[(1.0, 1.0), (1.0, 4.0)]);
        let gbuffer = plane(2, 1, 1.0);
        assert_eq!(counts(&gbuffer, &same_mean, &pair, Allocation::Variance, budget), [200, 400]);
        assert_eq!(counts(&gbuffer, &same_mean, &pair, Allocation::Even, budget), [300, 300]);
        // L = 1 and 3, e = 0.06 x 2: q is as 1/1.12 to 1/3.12
        let other_mean = pilot(&[(1.0, 1.0), (3.0, 1.0)]);
        let first = 600.0 * 3.12 / (1.12 + 3.12);
        let found = counts(&gbuffer, &other_mean, &pair, Allocation::Variance, budget);
        assert!(
            (f64::from(found[0]) - first).abs() <= 1.0 && found.iter().sum::<u32>().abs_diff(600) <= 1,
            "{found:?}"
        );
        // the published bound is taken as it is, 7 L
        assert_eq!(counts(&gbuffer, &other_mean, &pair, Allocation::Published, budget), [150, 450]);
    }

    #[test]
    fn an_error_in_a_coarse_cell_counts_for_all_of_its_pixels() {
        // a cell of 4 x 4 pixels beside a pixel: q is as sqrt(16) to 1
        let gbuffer = plane(5, 4, 1.0);
        let points = [point(2, 0), point(0, 4)];
        let found =
            counts(&gbuffer, &pilot(&[(1.0, 1.0); 20]), &points, Allocation::Variance, Budget::SamplesPerPixel(50.0));
        assert_eq!(found, [800, 200]);
    }

    #[test]
    fn no_point_takes_less_than_a_twentieth_of_the_mean_request() {
        let mut predictions = vec![(1.0, 1.0); 99];
        predictions.push((1.0, 0.0));
        let points: Vec<ShadingPoint> = (0..100).map(|column| point(0, column)).collect();
        let found = counts(
            &plane(100, 1, 1.0),
            &pilot(&predictions),
            &points,
            Allocation::Variance,
            Budget::SamplesPerPixel(1000.0),
        );
        let share = f64::from(found[99]) / f64::from(found[0]);
        assert!((share - 0.05 * 0.99).abs() < 1e-3, "{share}");
    }

    #[test]
    fn the_light_is_prefiltered_where_the_predicted_error_is_too_large() {
        let gbuffer = plane(2, 1, 1.0);
        let pilot = pilot(&[(1.0, 1.0), (1.0, 4.0)]);
        let prefiltered = |prefilter| {
            let mut counts = SampleCounts::default();
            let pass = AllocationPass {
                gbuffer: &gbuffer,
                pilot: &pilot,
                points: &[point(0, 0), point(0, 1)],
                allocation: Allocation::Even,
                budget: Budget::SamplesPerPixel(100.0),
                foreground: 2,
                prefilter,
            };
            pass.run(&mut counts);
            counts.prefiltered
        };
        // sqrt(v / N) / (L + e) is 0.1/1.06 and 0.2/1.06
        assert_eq!(prefiltered(Prefilter::Above(0.15)), [false, true]);
        assert_eq!(prefiltered(Prefilter::Above(0.2)), [false, false]);
        assert_eq!(prefiltered(Prefilter::Above(0.09)), [true, true]);
        assert_eq!(prefiltered(Prefilter::Always), [true, true]);
    }

    #[test]
    fn the_published_bound_of_a_cell_is_its_largest() {
        let predictions: Vec<(f32, f32)> = (0..16).map(|n| (n as f32, 2.0 * n as f32)).collect();
        let cell = cell_prediction(&plane(4, 4, 1.0), &pilot(&predictions), &point(2, 0));
        assert_eq!(cell, CellPrediction { mean: 7.5, variance: 15.0, published: 105.0 });
    }
}
