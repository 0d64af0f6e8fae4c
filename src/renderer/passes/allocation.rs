//! How many samples each shading point takes.

use rayon::prelude::*;

use crate::geometry::gbuffer::GBuffer;
use crate::passes::image_bandwidth::COARSEST_LEVEL;
use crate::passes::pilot::Pilot;
use crate::passes::shading::ShadingPoint;

/// Fewest and most samples of a shading point.
pub const SAMPLES: [u32; 2] = [4, 16_384];
/// Added to a mean, in units of the mean of the image: what is dark need not be exact relative to itself.
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
    /// The published bound of the variance, maximum over the cell (paper 000, equation 9).
    Printed,
    /// The same for every point.
    Even,
}

/// What the samples are spent on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Budget {
    /// Mean samples per pixel of a surface, the pilot's not counted.
    SamplesPerPixel(f64),
    /// Predicted relative error, root mean square over the pixels.
    TargetError(f64),
}

/// What is predicted for the cell of a shading point: means over its grid, the maximum for the printed bound.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct CellPrediction {
    pub(crate) mean: f32,
    pub(crate) variance: f32,
    printed: f32,
}

/// Luminance that counts as dark: a share of the mean prediction over the pixels of surfaces.
pub(crate) fn dark(pilot: &Pilot) -> f32 {
    let (mut sum, mut count) = (0.0_f64, 0_u32);
    for prediction in pilot.of_pixel.iter().filter_map(|&point| pilot.predictions.get(point as usize)) {
        sum += f64::from(prediction.mean);
        count += 1;
    }
    (sum / f64::from(count.max(1))) as f32 * DARK
}

/// The prediction for the cell of a point, from up to 4 x 4 of its pixels on a regular grid.
pub(crate) fn predict(gbuffer: &GBuffer, pilot: &Pilot, point: &ShadingPoint) -> CellPrediction {
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
                cell.printed = cell.printed.max(prediction.printed);
                count += 1;
            }
        }
    }
    let share = 1.0 / count.max(1) as f32;
    CellPrediction { mean: cell.mean * share, variance: cell.variance * share, ..cell }
}

/// Fills in the counts of all points.
pub(crate) fn allocate(
    points: &mut [ShadingPoint],
    predictions: &[CellPrediction],
    allocation: Allocation,
    budget: Budget,
    dark: f32,
    foreground: usize,
) {
    let area = |point: &ShadingPoint| f64::from(1_u32 << (2 * point.level.min(COARSEST_LEVEL as u8)));
    let request = |(point, cell): (&ShadingPoint, &CellPrediction)| match allocation {
        Allocation::Variance => {
            (f64::from(cell.variance) * area(point)).sqrt() / f64::from((cell.mean + dark).max(f32::MIN_POSITIVE))
        }
        Allocation::Printed => f64::from(cell.printed),
        Allocation::Even => 1.0,
    };
    let mut requests: Vec<f64> = points.par_iter().zip(predictions).map(request).collect();
    let mean = requests.iter().sum::<f64>() / requests.len().max(1) as f64;
    let least = if mean > 0.0 { LEAST_REQUEST * mean } else { 1.0 };
    requests.iter_mut().for_each(|request| *request = request.max(least));
    let scale = match budget {
        Budget::SamplesPerPixel(spp) => scale_for_total(&requests, spp * foreground as f64),
        Budget::TargetError(error) => {
            let weighted = |(point, cell): (&ShadingPoint, &CellPrediction)| {
                let mean = f64::from((cell.mean + dark).max(f32::MIN_POSITIVE));
                area(point) * f64::from(cell.variance) / (mean * mean)
            };
            let errors: Vec<f64> = points.par_iter().zip(predictions).map(weighted).collect();
            let areas: f64 = points.iter().map(area).sum();
            scale_for_error(&requests, &errors, error * error * areas)
        }
    };
    points.iter_mut().zip(&requests).for_each(|(point, request)| point.samples = count(scale, *request));
}

/// Samples for a request.
fn count(scale: f64, request: f64) -> u32 {
    let [least, most] = SAMPLES.map(f64::from);
    (scale * request).round().clamp(least, most) as u32
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
    let (mut low, mut high) = (f64::from(SAMPLES[0]) / largest, f64::from(SAMPLES[1]) / least);
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
        assert!(requests.iter().all(|&request| count(scale_for_total(&requests, 10.0), request) == SAMPLES[0]));
        assert!(requests.iter().all(|&request| count(scale_for_total(&requests, 1e12), request) == SAMPLES[1]));
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
            let [least, most] =
                SAMPLES.map(|limit| requests.iter().zip(&errors).map(|(_, e)| e / f64::from(limit)).sum());
            let (low, high): (f64, f64) = (0.97 * total.clamp(most, least), 1.001 * total.clamp(most, least));
            assert!((low..=high).contains(&sum), "{sum} {total}");
        }
    }
}
