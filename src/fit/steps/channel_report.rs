//! The report of one fitted channel: parameters, derived values, standard errors, flags.

use crate::document::{ChannelFit, Derived, Flag, StepReport};
use crate::lm::bounds::Bound;
use crate::lm::problem::LmError;
use crate::lm::uncertainty::Uncertainty;
use crate::options::{FitOptions, Step2Solver};
use crate::steps::closed_form_fit::fit_g1;
use crate::steps::distribution_fit::DistributionFit;
use crate::steps::distribution_problem::Unknown;
use crate::steps::fresnel_fit::{FittedLobe, FresnelFit};
use crate::steps::slice_rows::Row;
use brdfit_brdf::{Microfacet, MicrofacetParameters, NamedValues, NormalDistribution};
use brdfit_measured::{CHANNEL_NAMES, Slices};

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
pub(crate) struct FittedChannel<'a, D> {
    pub(crate) lobe: FittedLobe<'a, D>,
    pub(crate) step2: &'a FresnelFit,
    /// The rows of step 1 and of step 2.
    pub(crate) rows: [&'a [Row]; 2],
    pub(crate) slices: &'a Slices,
    pub(crate) options: &'a FitOptions,
}

impl<D> FittedChannel<'_, D> {
    fn step1(&self) -> &DistributionFit<D> {
        self.lobe.step1
    }

    /// The parameters of the model.
    pub(crate) fn parameters<const N: usize>(&self) -> MicrofacetParameters<N>
    where
        D: NormalDistribution<N>,
    {
        let FresnelFit { rho_s, f0, f1, .. } = *self.step2;
        let rho_d = self.step1().rho_d[self.lobe.n];
        MicrofacetParameters { rho_d, rho_s, shape: self.step1().distribution.shape(), f0, f1 }
    }

    /// The report of the channel.
    pub(crate) fn describe<const N: usize>(&self, parameters: NamedValues<f64>) -> Result<ChannelFit, LmError>
    where
        D: NormalDistribution<N>,
    {
        let (step1, step2, n) = (self.step1(), self.step2, self.lobe.n);
        let model = Microfacet::<D, N>::new(self.parameters()).expect("the box lies inside of the model's domain");
        let masking = step1.distribution.masking();
        let derived = Derived {
            k: step1.distribution.normalisation(),
            fr: if step1.is_flat(n) { 0.0 } else { step1.fr(n) },
            anchor: step2.anchor,
            g1: fit_g1(&masking)?,
            albedo: ALBEDO_DEGREES.map(|degrees| model.directional_albedo(&masking, degrees.to_radians())),
            fresnel_range: model.parameters().fresnel().range(),
        };
        let standard_errors = self.standard_errors();
        let steps = [self.report_step_1(), self.report_step_2()];
        let flags = self.flags(&derived, &steps);
        let name = CHANNEL_NAMES[self.lobe.channel].to_owned();
        Ok(ChannelFit { name, parameters, derived, standard_errors, steps, flags })
    }

    fn report_step_1<const N: usize>(&self) -> StepReport
    where
        D: NormalDistribution<N>,
    {
        let (step1, solution) = (self.step1(), &self.step1().solution);
        let layout = step1.layout();
        let of_channel = |name: &str, n: usize| match layout.channels {
            1 => name.to_owned(),
            _ => format!("{name} {}", CHANNEL_NAMES[n]),
        };
        let active = solution.active.iter().enumerate().filter_map(|(index, bound)| {
            let side = match (*bound)? {
                Bound::Lower => "lower",
                Bound::Upper => "upper",
            };
            let name = match layout.unknown(index) {
                Unknown::Diffuse(n) => of_channel("rho_d", n),
                Unknown::Peak(n) => of_channel("peak", n),
                Unknown::Shape(k) => D::SHAPE[k].name.to_owned(),
            };
            Some(format!("{name} at its {side} bound"))
        });
        StepReport {
            name: "theta_h".to_owned(),
            solver: "levenberg-marquardt".to_owned(),
            rows: solution.residuals.len(),
            cost: solution.cost,
            residual_norm: (2.0 * solution.cost).sqrt(),
            iterations: step1.iterations,
            termination: solution.termination,
            start: step1.start,
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

    /// Standard errors of rho_d, Fr and the shape by the delta method from those of the unknowns of step 1, and those of step 2.
    fn standard_errors<const N: usize>(&self) -> NamedValues<Option<f64>>
    where
        D: NormalDistribution<N>,
    {
        let (step1, layout, n) = (self.step1(), self.step1().layout(), self.lobe.n);
        let uncertainty = step1.solution.uncertainty();
        let of = |index: usize| uncertainty.standard_errors[index];
        let shape = step1.distribution.shape();
        let step = |k: usize| D::SHAPE[k].transform.slope(shape[k]);
        let of_shape = (0..N).map(|k| (D::SHAPE[k].name, of(layout.shape(k)).map(|error| error * step(k))));
        let [rho_s, f0, f1] = self.step2.standard_errors;
        [("rho_d", of(layout.diffuse(n)).map(|error| error * step1.rho_d[n])), ("fr", self.fr_error(&uncertainty))]
            .into_iter()
            .chain(of_shape)
            .chain([("rho_s", rho_s), ("f0", f0), ("f1", f1)])
            .collect()
    }

    /// The standard error of `Fr = (c / pi) P / D(0)`.
    fn fr_error<const N: usize>(&self, uncertainty: &Uncertainty) -> Option<f64>
    where
        D: NormalDistribution<N>,
    {
        let (step1, layout, n) = (self.step1(), self.step1().layout(), self.lobe.n);
        let of = |index: usize| uncertainty.standard_errors[index];
        let (shape, ln_slopes) = (step1.distribution.shape(), step1.distribution.ln_slopes(0.0));
        let by_shape = |k: usize| (layout.shape(k), -(D::SHAPE[k].transform.slope(shape[k]) * ln_slopes[k]));
        let slopes: Vec<(usize, f64)> = [(layout.peak(n), 1.0)].into_iter().chain((0..N).map(by_shape)).collect();
        let variance: f64 = slopes
            .iter()
            .flat_map(|a| slopes.iter().map(move |b| (a, b)))
            .map(|(a, b)| a.1 * b.1 * uncertainty.covariance[(a.0, b.0)])
            .sum();
        let determined = slopes.iter().all(|&(index, _)| of(index).is_some() || step1.solution.active[index].is_some());
        (determined && of(layout.peak(n)).is_some()).then(|| step1.fr(n).abs() * variance.max(0.0).sqrt())
    }

    fn flags(&self, derived: &Derived, steps: &[StepReport]) -> Vec<Flag> {
        let (step1, step2, n) = (self.step1(), self.step2, self.lobe.n);
        let Self { rows, slices, options, .. } = *self;
        let few = |angles: &[f64], cutoff: f64, rows: &[Row]| {
            2 * rows.len() < angles.iter().filter(|angle| angle.to_degrees() <= cutoff).count()
        };
        let zero_peak = rows[0].iter().take(PEAK_ROWS).all(|row| row.measured[self.lobe.channel] == 0.0);
        let [low, high] = derived.fresnel_range;
        let specular = step2.rho_s != 0.0;
        let weak = |error: f64| error > WEAK * step2.rho_s.abs();
        let candidates = [
            (Flag::ZeroPeak, zero_peak),
            (Flag::NoPeak, step1.is_flat(n) || step1.peak[n].abs() <= NO_PEAK * step1.rho_d[n]),
            (Flag::NoSpecular, !specular),
            (Flag::Step1AtBound, !steps[0].active_bounds.is_empty()),
            (Flag::FresnelConstrained, specular && !steps[1].active_bounds.is_empty()),
            (Flag::FresnelOutsideUnit, specular && (low < -OUTSIDE || high > 1.0 + OUTSIDE)),
            (Flag::RhoSWeak, specular && step2.standard_errors[0].is_none_or(weak)),
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
