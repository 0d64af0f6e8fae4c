//! Comparison of two fits of the same measurement: data, minimum and curves.
//!
//! Raw parameters are never compared. A third of all channels are degenerate (docs/theory.md, section 4): very different
//! parameters give the same curve and the same cost.

pub(crate) mod subset;
#[cfg(test)]
pub(crate) mod test_document;
pub(crate) mod tolerance;

pub use subset::{
    ComparableChannel, ComparableErrors, ComparableFit, ComparableInput, ComparableOptions, ComparableSlices,
    ComparableStep, CompareError,
};
pub use tolerance::{Tolerance, Tolerances, Verdict};

use serde::{Deserialize, Serialize};

/// Largest angle of the comparison of the fitted curves if neither document names its cut-off, degrees.
const DEFAULT_CUTOFF_DEGREES: f64 = 75.0;
/// Sample angles that differ by less than this (radians) are the same angle.
const SAME_ANGLE: f64 = 1e-9;

/// One material: ours against the reference.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Comparison {
    /// The material, as our document calls it.
    pub name: String,
    /// R, G and B.
    pub channels: Vec<ChannelComparison>,
    /// The worst verdict of the channels.
    pub verdict: Verdict,
}

/// One channel.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ChannelComparison {
    /// R, G or B.
    pub name: String,
    /// The measured slices.
    pub measured: MeasuredComparison,
    /// Final costs of step 1 and step 2.
    pub costs: [CostComparison; 2],
    /// Fitted curves over theta_h and theta_d, up to the cut-offs.
    pub curves: [CurveComparison; 2],
    /// E, L and C, if both documents have them.
    pub errors: Option<ErrorsComparison>,
    /// The worst verdict of all of these.
    pub verdict: Verdict,
}

/// Whether both fits used the same measured values.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct MeasuredComparison {
    /// Largest relative difference over both slices; null if the angles or the rows with a measurement are not the same.
    pub largest: Option<f64>,
    /// Fail beyond the tolerance; there is no warning, as both read the same file.
    pub verdict: Verdict,
}

/// Two costs of one step.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct CostComparison {
    /// Ours.
    pub ours: f64,
    /// The reference's.
    pub reference: f64,
    /// `(ours - reference) / reference`, negative if ours is better; 0 if both are below the floor.
    pub relative: f64,
    /// False for step 2 where the costs of step 1 already differ.
    pub judged: bool,
    /// The verdict.
    pub verdict: Verdict,
}

/// Two fitted curves.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct CurveComparison {
    /// Root mean square of the relative differences.
    pub rms: f64,
    /// Largest relative difference.
    pub largest: f64,
    /// Angle of the largest difference, radians.
    pub at: f64,
    /// Rows compared.
    pub rows: usize,
    /// False if the costs already differ, or if there is nothing to compare.
    pub judged: bool,
    /// The verdict on the root mean square.
    pub verdict: Verdict,
}

/// Relative differences `(ours - reference) / reference` of the error panel.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct ErrorsComparison {
    /// Of the cosine-weighted error.
    #[serde(rename = "E")]
    pub e: f64,
    /// Of the logarithmic error.
    #[serde(rename = "L")]
    pub l: f64,
    /// Of the cube root error.
    #[serde(rename = "C")]
    pub c: f64,
    /// False if the costs already differ.
    pub judged: bool,
    /// The worst verdict of the three.
    pub verdict: Verdict,
}

/// Compares our fit with a reference.
///
/// - The measured slices must agree, or the programs did not read the same data.
/// - A cost may not be above the reference's by more than its tolerance; a better one is no difference, unless
///   [`Tolerances::two_sided`].
/// - Step 2 takes rho_d and the distribution from step 1. Where the costs of step 1 differ, on whichever side, the two
///   programs solved different second problems, and only step 1 is judged.
/// - Where both costs of the channel agree on either side, its curves and errors must agree. Where one program found its specular
///   part negligible and dropped it after step 2 and the other kept it, the theta_d curve and the errors are not judged.
///
/// # Errors
/// [`CompareError::Incomparable`] if the fits belong to different files, sample positions, models or objectives.
pub fn compare(
    ours: &ComparableFit,
    reference: &ComparableFit,
    tolerances: &Tolerances,
) -> Result<Comparison, CompareError> {
    ours.check_comparable(reference)?;
    let channels: Vec<_> = (0..3).map(|channel| compare_channel(ours, reference, channel, tolerances)).collect();
    let verdict = channels.iter().map(|channel| channel.verdict).max().unwrap_or(Verdict::Agree);
    Ok(Comparison { name: ours.input.name.clone(), channels, verdict })
}

fn compare_channel(a: &ComparableFit, b: &ComparableFit, channel: usize, t: &Tolerances) -> ChannelComparison {
    let measured = compare_measured(&a.slices, &b.slices, channel, t);
    let cost = |step: usize, judged: bool| {
        compare_costs(a.channels[channel].steps[step].cost, b.channels[channel].steps[step].cost, judged, t)
    };
    let same = |cost: &CostComparison| t.two_sided || cost.relative.abs() <= t.cost.fail;
    let first = cost(0, true);
    let second = cost(1, same(&first));
    let judged = same(&first) && same(&second) && measured.verdict == Verdict::Agree;
    let costs = [first, second];
    let same_parts = a.channels[channel].is_without_specular() == b.channels[channel].is_without_specular();
    let cutoff =
        |of: fn(&ComparableOptions) -> Option<f64>| of(&a.options).or(of(&b.options)).unwrap_or(DEFAULT_CUTOFF_DEGREES);
    let (x, y) = (&a.slices, &b.slices);
    let curves = [
        compare_curves(
            Rows {
                angles: &x.theta_h,
                ours: &x.fitted.theta_h[channel],
                reference: &y.fitted.theta_h[channel],
                cutoff_degrees: cutoff(|options| options.cutoff_theta_h_degrees),
            },
            judged,
            t,
        ),
        compare_curves(
            Rows {
                angles: &x.theta_d,
                ours: &x.fitted.theta_d[channel],
                reference: &y.fitted.theta_d[channel],
                cutoff_degrees: cutoff(|options| options.cutoff_theta_d_degrees),
            },
            judged && same_parts,
            t,
        ),
    ];
    let errors = a.errors.as_ref().zip(b.errors.as_ref()).map(|(x, y)| {
        let [e, l, c] = [(&x.E, &y.E), (&x.L, &y.L), (&x.C, &y.C)].map(|(x, y)| relative(x[channel], y[channel]));
        let worst = [e, l, c].into_iter().map(|difference| t.errors.judge(difference.abs())).max();
        let judged = judged && same_parts;
        ErrorsComparison { e, l, c, judged, verdict: worst.filter(|_| judged).unwrap_or(Verdict::Agree) }
    });
    let verdict = [measured.verdict, costs[0].verdict, costs[1].verdict, curves[0].verdict, curves[1].verdict]
        .into_iter()
        .chain(errors.map(|errors| errors.verdict))
        .max()
        .unwrap_or(Verdict::Agree);
    ChannelComparison { name: a.channels[channel].name.clone(), measured, costs, curves, errors, verdict }
}

fn compare_measured(a: &ComparableSlices, b: &ComparableSlices, channel: usize, t: &Tolerances) -> MeasuredComparison {
    let largest = match (
        largest_measured(&a.theta_h, &b.theta_h, &a.measured.theta_h[channel], &b.measured.theta_h[channel]),
        largest_measured(&a.theta_d, &b.theta_d, &a.measured.theta_d[channel], &b.measured.theta_d[channel]),
    ) {
        (Some(h), Some(d)) => Some(h.max(d)),
        _ => None,
    };
    let same = largest.is_some_and(|largest| largest <= t.measured);
    MeasuredComparison { largest, verdict: if same { Verdict::Agree } else { Verdict::Fail } }
}

/// Largest relative difference of two measured curves; `None` if they do not have the same rows.
fn largest_measured(x: &[f64], y: &[f64], ours: &[Option<f64>], reference: &[Option<f64>]) -> Option<f64> {
    let same_angles = x.len() == y.len() && x.iter().zip(y).all(|(x, y)| (x - y).abs() <= SAME_ANGLE);
    if !same_angles {
        return None;
    }
    ours.iter().zip(reference).try_fold(0.0_f64, |largest, pair| match pair {
        (Some(a), Some(b)) => Some(largest.max(relative(*a, *b).abs())),
        (None, None) => Some(largest),
        _ => None,
    })
}

fn compare_costs(ours: f64, reference: f64, judged: bool, t: &Tolerances) -> CostComparison {
    let through_the_data = ours <= t.cost_floor && reference <= t.cost_floor;
    let relative = if through_the_data { 0.0 } else { (ours - reference) / reference.max(t.cost_floor) };
    let difference = if t.two_sided { relative.abs() } else { relative };
    let verdict = if judged { t.cost.judge(difference) } else { Verdict::Agree };
    CostComparison { ours, reference, relative, judged, verdict }
}

/// One slice of both fits.
struct Rows<'a> {
    angles: &'a [f64],
    ours: &'a [Option<f64>],
    reference: &'a [Option<f64>],
    cutoff_degrees: f64,
}

fn compare_curves(slice: Rows<'_>, judged: bool, t: &Tolerances) -> CurveComparison {
    let cutoff = slice.cutoff_degrees.to_radians() + SAME_ANGLE;
    let (mut sum, mut rows, mut largest, mut at) = (0.0, 0_usize, 0.0_f64, 0.0);
    for ((&angle, ours), reference) in slice.angles.iter().zip(slice.ours).zip(slice.reference) {
        let (Some(ours), Some(reference)) = (ours, reference) else { continue };
        if angle <= cutoff {
            let difference = (ours - reference).abs() / reference.abs().max(t.curve_floor);
            sum += difference * difference;
            rows += 1;
            if difference > largest {
                (largest, at) = (difference, angle);
            }
        }
    }
    let rms = (sum / rows.max(1) as f64).sqrt();
    let judged = judged && rows > 0;
    let verdict = if judged { t.curve.judge(rms) } else { Verdict::Agree };
    CurveComparison { rms, largest, at, rows, judged, verdict }
}

/// `(ours - reference) / reference`, 0 for two equal values.
fn relative(ours: f64, reference: f64) -> f64 {
    if ours == reference { 0.0 } else { (ours - reference) / reference.abs() }
}

#[cfg(test)]
mod tests {
    use super::test_document::fit;
    use super::*;

    fn verdict(change: impl FnOnce(&mut ComparableFit)) -> Comparison {
        let mut ours = fit();
        change(&mut ours);
        compare(&ours, &fit(), &Tolerances::default()).unwrap()
    }

    #[test]
    fn a_fit_agrees_with_itself() {
        let same = verdict(|_| ());
        assert_eq!(same.verdict, Verdict::Agree);
        for channel in &same.channels {
            assert_eq!(channel.measured.largest, Some(0.0));
            assert_eq!(channel.costs.map(|cost| cost.relative), [0.0, 0.0]);
            assert_eq!(channel.curves.map(|curve| (curve.rms, curve.largest, curve.judged)), [(0.0, 0.0, true); 2]);
            assert_eq!(channel.errors.map(|errors| (errors.e, errors.judged)), Some((0.0, true)));
        }
    }

    #[test]
    fn a_cost_is_judged_by_how_far_it_is_above_the_reference() {
        for (factor, expected) in [
            (1.0 + 9e-7, Verdict::Agree),
            (1.0 + 2e-6, Verdict::Warn),
            (1.0 + 9.9e-5, Verdict::Warn),
            (1.0 + 1.1e-4, Verdict::Fail),
            (0.5, Verdict::Agree),
        ] {
            let result = verdict(|ours| ours.channels[1].steps[1].cost *= factor);
            assert_eq!(result.verdict, expected, "{factor}");
            assert_eq!(result.channels[1].costs[1].verdict, expected);
            assert!((result.channels[1].costs[1].relative - (factor - 1.0)).abs() < 1e-12);
            assert_eq!(result.channels[0].verdict, Verdict::Agree);
        }
    }

    #[test]
    fn two_sided_holds_a_better_cost_against_us() {
        let mut ours = fit();
        ours.channels[2].steps[0].cost *= 0.5;
        let tolerances = Tolerances { two_sided: true, ..Tolerances::default() };
        assert_eq!(compare(&ours, &fit(), &tolerances).unwrap().channels[2].costs[0].verdict, Verdict::Fail);
    }

    #[test]
    fn vanishing_costs_are_equal() {
        let (mut ours, mut reference) = (fit(), fit());
        ours.channels[0].steps[0].cost = 3e-15;
        reference.channels[0].steps[0].cost = 1e-28;
        let result = compare(&ours, &reference, &Tolerances::default()).unwrap();
        assert_eq!((result.verdict, result.channels[0].costs[0].relative), (Verdict::Agree, 0.0));
        ours.channels[0].steps[0].cost = 1e-9;
        assert_eq!(compare(&ours, &reference, &Tolerances::default()).unwrap().verdict, Verdict::Fail);
    }

    #[test]
    fn measured_slices_must_be_the_same_data() {
        let largest = |change: fn(&mut ComparableFit)| {
            let result = verdict(change);
            (result.channels[0].measured.largest, result.verdict)
        };
        let (tiny, agree) = largest(|ours| scale(&mut ours.slices.measured.theta_d[0][2], 1.0 + 5e-10));
        assert!((tiny.unwrap() - 5e-10).abs() < 1e-12 && agree == Verdict::Agree);
        assert_eq!(largest(|ours| scale(&mut ours.slices.measured.theta_h[0][1], 1.0 + 2e-9)).1, Verdict::Fail);
        assert_eq!(largest(|ours| ours.slices.measured.theta_h[0][1] = None), (None, Verdict::Fail));
        assert_eq!(largest(|ours| ours.slices.theta_d[1] += 1e-6), (None, Verdict::Fail));
    }

    #[test]
    fn curves_are_judged_up_to_the_cutoff_by_their_root_mean_square() {
        for (factor, expected) in [(1.0005, Verdict::Agree), (1.003, Verdict::Warn), (1.03, Verdict::Fail)] {
            let result = verdict(|ours| {
                for value in &mut ours.slices.fitted.theta_h[0] {
                    scale(value, factor);
                }
            });
            let curve = result.channels[0].curves[0];
            assert_eq!((result.verdict, curve.verdict, curve.judged), (expected, expected, true), "{factor}");
            assert!((curve.rms - (factor - 1.0)).abs() < 1e-12 && (curve.largest - (factor - 1.0)).abs() < 1e-12);
        }
        let beyond = verdict(|ours| scale(ours.slices.fitted.theta_d[0].last_mut().unwrap(), 5.0));
        assert_eq!((beyond.verdict, beyond.channels[0].curves[1].largest), (Verdict::Agree, 0.0));
    }

    #[test]
    fn dark_rows_are_compared_on_the_floor() {
        let (mut ours, mut reference) = (fit(), fit());
        ours.slices.fitted.theta_h[0][3] = Some(3e-6);
        reference.slices.fitted.theta_h[0][3] = Some(1e-6);
        let curve = compare(&ours, &reference, &Tolerances::default()).unwrap().channels[0].curves[0];
        assert!((curve.largest - 2e-3).abs() < 1e-12 && (curve.rms - 2e-3 / 3.0_f64.sqrt()).abs() < 1e-12);
        assert_eq!((curve.at, curve.rows, curve.verdict), (ours.slices.theta_h[3], 3, Verdict::Warn));
    }

    #[test]
    fn errors_are_judged_on_both_sides() {
        for (factor, expected) in
            [(1.0005, Verdict::Agree), (0.995, Verdict::Warn), (1.02, Verdict::Fail), (0.98, Verdict::Fail)]
        {
            let result = verdict(|ours| ours.errors.as_mut().unwrap().L[2] *= factor);
            assert_eq!(result.verdict, expected, "{factor}");
            assert!((result.channels[2].errors.unwrap().l - (factor - 1.0)).abs() < 1e-12);
        }
    }

    #[test]
    fn another_minimum_is_the_business_of_the_costs_alone() {
        let result = verdict(|ours| {
            ours.channels[0].steps[0].cost *= 0.9;
            scale(&mut ours.slices.fitted.theta_h[0][0], 3.0);
            ours.errors.as_mut().unwrap().E[0] *= 2.0;
        });
        let channel = &result.channels[0];
        assert_eq!(result.verdict, Verdict::Agree);
        assert!(!channel.curves[0].judged && !channel.errors.unwrap().judged);
        assert!(channel.curves[0].largest > 1.9);
    }

    #[test]
    fn a_part_that_only_one_side_dropped_is_not_judged() {
        let (mut ours, reference) = (fit(), fit());
        ours.slices.fitted.theta_d[0] = vec![Some(1.0); 4];
        ours.errors.as_mut().unwrap().E[0] = 9.0;
        let judge = |ours: &ComparableFit| compare(ours, &reference, &Tolerances::default()).unwrap().verdict;
        assert_eq!(judge(&ours), Verdict::Fail);
        ours.channels[0].flags = vec!["no_specular".to_owned()];
        assert_eq!(judge(&ours), Verdict::Agree);
        ours.slices.fitted.theta_h[0] = vec![Some(1.0); 4];
        assert_eq!(judge(&ours), Verdict::Fail, "step 1's curve is judged all the same");
    }

    #[test]
    fn step_2_is_judged_where_step_1_agrees() {
        for (first, expected) in [(0.96, Verdict::Agree), (1.0 - 9e-5, Verdict::Fail), (1.0, Verdict::Fail)] {
            let result = verdict(|ours| {
                ours.channels[0].steps[0].cost *= first;
                ours.channels[0].steps[1].cost *= 1.3;
            });
            let second = result.channels[0].costs[1];
            assert_eq!((second.verdict, second.judged), (expected, expected == Verdict::Fail), "{first}");
        }
    }

    #[test]
    fn errors_are_optional() {
        let result = verdict(|ours| ours.errors = None);
        assert!(result.verdict == Verdict::Agree && result.channels.iter().all(|channel| channel.errors.is_none()));
    }

    fn scale(value: &mut Option<f64>, factor: f64) {
        *value = value.map(|value| value * factor);
    }
}
