//! What the document says of one fitted channel.

use crate::document::{CHANNELS, ChannelFit, Derived, Flag, StandardErrors, StepReport};
use crate::lm::bounds::Bound;
use crate::lm::problem::LmError;
use crate::options::{FitOptions, Step2Solver};
use crate::steps::closed_form_fit::fit_g1;
use crate::steps::distribution_fit::{Step1, unknown_name};
use crate::steps::fresnel_fit::Step2;
use crate::steps::slice_rows::Row;
use brdfit_brdf::{G1Curve, Sgd, SgdParameters, directional_albedo};
use brdfit_measured::Slices;

/// Angles at which the model's albedo is reported, degrees.
const ALBEDO_DEGREES: [f64; 4] = [0.0, 30.0, 60.0, 80.0];
/// Condition number of step 1's column-scaled Jacobian beyond which the parameters are flagged.
const ILL_CONDITIONED: f64 = 1e4;
/// Relative standard error of rho_s beyond which it is flagged.
const WEAK: f64 = 0.3;
/// A lobe below this share of rho_d is none.
const NO_PEAK: f64 = 1e-3;
/// F this far outside of [0, 1] is outside.
const OUTSIDE: f64 = 1e-6;
/// Rows at the peak of the theta_h slice that are all zero in a channel out of gamut.
const PEAK_ROWS: usize = 3;

/// A channel with both steps done.
pub(crate) struct FittedChannel<'a> {
    /// R, G, B: 0, 1, 2.
    pub(crate) channel: usize,
    /// Its number among the channels of its step 1.
    pub(crate) n: usize,
    pub(crate) step1: &'a Step1,
    pub(crate) step2: &'a Step2,
    /// The rows of step 1 and of step 2.
    pub(crate) rows: [&'a [Row]; 2],
    pub(crate) slices: &'a Slices,
    pub(crate) options: &'a FitOptions,
}

impl FittedChannel<'_> {
    /// Everything that the document says of the channel.
    pub(crate) fn describe(&self) -> Result<ChannelFit, LmError> {
        let Self { step1, step2, n, .. } = *self;
        let parameters = SgdParameters {
            rho_d: step1.rho_d[n],
            rho_s: step2.rho_s,
            alpha: step1.distribution.alpha(),
            p: step1.distribution.p(),
            f0: step2.f0,
            f1: step2.f1,
        };
        let curve = G1Curve::new(&step1.distribution);
        let sgd = Sgd::new(parameters).expect("the box lies inside of the model's domain");
        let derived = Derived {
            k: step1.distribution.k(),
            fr: if step1.is_flat(n) { 0.0 } else { step1.fr(n) },
            anchor: step2.anchor,
            g1: fit_g1(&curve)?,
            albedo: ALBEDO_DEGREES.map(|degrees| directional_albedo(&sgd, &curve, degrees.to_radians())),
            fresnel_range: parameters.fresnel().range(),
        };
        let [rho_s, f0, f1] = step2.standard_errors;
        let standard_errors = StandardErrors { rho_s, f0, f1, ..self.standard_errors_of_step_1() };
        let steps = [self.report_step_1(), self.report_step_2()];
        let flags = self.flags(&parameters, &derived, &standard_errors, &steps);
        let name = CHANNELS[self.channel].to_owned();
        Ok(ChannelFit { name, parameters, derived, standard_errors, steps, flags })
    }

    fn report_step_1(&self) -> StepReport {
        let solution = &self.step1.solution;
        let channels = self.step1.rho_d.len();
        let active = solution.active.iter().enumerate().filter_map(|(index, bound)| {
            let name = unknown_name(index, channels);
            let of_many = channels > 1 && index < 2 * channels;
            let channel = if of_many { format!(" {}", CHANNELS[index / 2]) } else { String::new() };
            bound.map(|bound| match bound {
                Bound::Lower => format!("{name}{channel} at its lower bound"),
                Bound::Upper => format!("{name}{channel} at its upper bound"),
            })
        });
        StepReport {
            name: "theta_h".to_owned(),
            solver: "levenberg-marquardt".to_owned(),
            rows: solution.residuals.len(),
            cost: solution.cost,
            residual_norm: (2.0 * solution.cost).sqrt(),
            iterations: self.step1.iterations,
            termination: solution.termination,
            start: self.step1.start,
            active_bounds: active.collect(),
            condition_number: solution.uncertainty().condition_number,
        }
    }

    fn report_step_2(&self) -> StepReport {
        let step2 = self.step2;
        let solver = match self.options.step2_solver {
            Step2Solver::Convex => "convex",
            Step2Solver::LevenbergMarquardt => "levenberg-marquardt",
        };
        StepReport {
            name: "theta_d".to_owned(),
            solver: solver.to_owned(),
            rows: step2.rows,
            cost: step2.cost,
            residual_norm: (2.0 * step2.cost).sqrt(),
            iterations: step2.iterations,
            termination: step2.termination,
            start: 0,
            active_bounds: step2.active.clone(),
            condition_number: step2.condition_number,
        }
    }

    /// Standard errors of rho_d, Fr, alpha and p by the delta method from those of the unknowns ln rho_d, ln peak, ln alpha, p.
    fn standard_errors_of_step_1(&self) -> StandardErrors {
        let Self { step1, n, .. } = *self;
        let channels = step1.rho_d.len();
        let uncertainty = step1.solution.uncertainty();
        let of = |index: usize| uncertainty.standard_errors[index];
        let alpha = step1.distribution.alpha();
        // Fr = peak / D(0), ln D(0) = ln K - alpha - p ln alpha - ln pi
        let [by_alpha, by_p] = step1.distribution.ln_slopes(0.0);
        let slopes = [(2 * n + 1, 1.0), (2 * channels, -alpha * by_alpha), (2 * channels + 1, -by_p)];
        let variance: f64 = slopes
            .iter()
            .flat_map(|a| slopes.iter().map(move |b| (a, b)))
            .map(|(a, b)| a.1 * b.1 * uncertainty.covariance[(a.0, b.0)])
            .sum();
        let determined = slopes.iter().all(|&(index, _)| of(index).is_some() || step1.solution.active[index].is_some());
        StandardErrors {
            rho_d: of(2 * n).map(|error| error * step1.rho_d[n]),
            fr: (determined && of(2 * n + 1).is_some()).then(|| step1.fr(n).abs() * variance.max(0.0).sqrt()),
            alpha: of(2 * channels).map(|error| error * alpha),
            p: of(2 * channels + 1),
            rho_s: None,
            f0: None,
            f1: None,
        }
    }

    fn flags(
        &self,
        parameters: &SgdParameters,
        derived: &Derived,
        standard_errors: &StandardErrors,
        steps: &[StepReport],
    ) -> Vec<Flag> {
        let Self { step1, step2, n, rows, slices, options, .. } = *self;
        let few = |angles: &[f64], cutoff: f64, rows: &[Row]| {
            2 * rows.len() < angles.iter().filter(|angle| angle.to_degrees() <= cutoff).count()
        };
        let zero_peak = rows[0].iter().take(PEAK_ROWS).all(|row| row.measured[self.channel] == 0.0);
        let [low, high] = derived.fresnel_range;
        let specular = parameters.rho_s != 0.0;
        let weak = |error: f64| error > WEAK * parameters.rho_s.abs();
        let candidates = [
            (Flag::ZeroPeak, zero_peak),
            (Flag::NoPeak, step1.is_flat(n) || step1.peak[n].abs() <= NO_PEAK * parameters.rho_d),
            (Flag::NoSpecular, !specular),
            (Flag::Step1AtBound, !steps[0].active_bounds.is_empty()),
            (Flag::FresnelConstrained, specular && !steps[1].active_bounds.is_empty()),
            (Flag::FresnelOutsideUnit, specular && (low < -OUTSIDE || high > 1.0 + OUTSIDE)),
            (Flag::RhoSWeak, specular && standard_errors.rho_s.is_none_or(weak)),
            (Flag::Step1IllConditioned, steps[0].condition_number.is_none_or(|number| number > ILL_CONDITIONED)),
            (Flag::NotConverged, steps.iter().any(|step| !step.termination.converged())),
            (
                Flag::FewRows,
                few(&slices.theta_h, options.cutoff_theta_h_degrees, rows[0])
                    || few(&slices.theta_d, options.cutoff_theta_d_degrees, rows[1]),
            ),
            (Flag::PeakMissed, step2.peak_missed),
        ];
        candidates.into_iter().filter_map(|(flag, raised)| raised.then_some(flag)).collect()
    }
}
