//! The fit of a material: both steps for three channels, and what is reported about them.

use crate::document::{CHANNELS, ChannelFit, CurvePair, Derived, Flag, SliceCurves, StandardErrors, StepReport};
use crate::g1_fit::fit_g1;
use crate::lm::{Bound, LmError};
use crate::options::{DistributionSharing, FitOptions, OptionsError, Step2Solver};
use crate::rows::{Row, rows_within};
use crate::step1::{Step1, unknown_name};
use crate::step2::Step2;
use brdfit_brdf::{G1Curve, ParameterError, Sgd, SgdParameters, SmithG1, directional_albedo};
use brdfit_merl::Slices;
use rayon::prelude::*;

/// Angles at which the model's albedo is reported, degrees.
const ALBEDO_DEGREES: [f64; 4] = [0.0, 30.0, 60.0, 80.0];
/// Condition number of step 1's column-scaled Jacobian beyond which the parameters are flagged.
const ILL_CONDITIONED: f64 = 1e4;
/// Relative standard error of rho_s beyond which it is flagged.
const WEAK: f64 = 0.3;

/// The fit of one material.
#[derive(Clone, Debug, PartialEq)]
pub struct MaterialFit {
    /// R, G, B.
    pub channels: [ChannelFit; 3],
    /// The slices with the fitted curves.
    pub slices: SliceCurves,
}

impl MaterialFit {
    /// The parameters of the three channels.
    pub fn parameters(&self) -> [SgdParameters; 3] {
        [0, 1, 2].map(|c: usize| self.channels[c].parameters)
    }
}

/// Why a material could not be fitted.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum FitError {
    /// The options cannot be followed.
    #[error(transparent)]
    Options(#[from] OptionsError),
    /// A slice has too few measured rows inside its cut-off.
    #[error("only {found} rows of the {slice} slice have a measurement up to {cutoff} degrees, the fit needs {needed}")]
    FewRows {
        /// Which slice.
        slice: &'static str,
        /// Rows with a measurement.
        found: usize,
        /// Rows that are needed.
        needed: usize,
        /// The cut-off in degrees.
        cutoff: f64,
    },
    /// The model cannot be evaluated with these parameters.
    #[error(transparent)]
    Parameters(#[from] ParameterError),
    /// The solver refused: a measurement far outside of any BRDF's range.
    #[error("the solver failed in channel {channel}: {source}")]
    Solver {
        /// Which channel.
        channel: &'static str,
        /// What it said.
        source: LmError,
    },
}

/// Fits a material in two steps (docs/theory.md, section 4; thesis V.4): the distribution from the theta_h slice, then the
/// Fresnel term from the theta_d slice, per channel or with one distribution for all.
///
/// Channels and starts run in parallel on rayon's current pool; the result does not depend on the number of threads.
///
/// # Errors
/// [`FitError`] for options outside of their range, slices with fewer than eight (theta_h) or four (theta_d) measured rows, or values that overflow.
pub fn fit_slices(slices: &Slices, options: &FitOptions) -> Result<MaterialFit, FitError> {
    let [rows_h, rows_d] = rows_of(slices, options)?;
    let solver_error = |c: usize| move |source| FitError::Solver { channel: CHANNELS[c], source };
    let joint = match options.distribution {
        DistributionSharing::PerChannel => None,
        DistributionSharing::Joint => Some(Step1::fit(&rows_h, &[0, 1, 2], options).map_err(solver_error(0))?),
    };
    let fits: Vec<(ChannelFit, Vec<f64>, Vec<f64>)> = (0..3)
        .into_par_iter()
        .map(|c| {
            let own = match &joint {
                Some(_) => None,
                None => Some(Step1::fit(&rows_h, &[c], options).map_err(solver_error(c))?),
            };
            let (step1, n) = match (&joint, &own) {
                (Some(joint), _) => (joint, c),
                (None, Some(own)) => (own, 0),
                (None, None) => unreachable!("one of the two was fitted"),
            };
            let step2 = Step2::fit(&rows_d, &rows_h, c, step1, n, options).map_err(solver_error(c))?;
            let smith = SmithG1::new(&step1.distribution);
            let fitted_h = slices.theta_h.iter().map(|&theta| step1.curve(n, &smith, theta)).collect();
            let fitted_d = slices.theta_d.iter().map(|&theta| step2.curve(&smith, theta)).collect();
            let fit = describe(c, n, step1, &step2, &rows_h, slices, options).map_err(solver_error(c))?;
            Ok((fit, fitted_h, fitted_d))
        })
        .collect::<Result<_, FitError>>()?;
    let [r, g, b]: [_; 3] = fits.try_into().expect("three channels");
    Ok(MaterialFit {
        channels: [r.0, g.0, b.0],
        slices: SliceCurves {
            theta_h: slices.theta_h.clone(),
            theta_d: slices.theta_d.clone(),
            measured: CurvePair { theta_h: slices.measured_h.clone(), theta_d: slices.measured_d.clone() },
            fitted: CurvePair { theta_h: [r.1, g.1, b.1], theta_d: [r.2, g.2, b.2] },
        },
    })
}

/// The costs of given parameters in both steps, per channel: what [`fit_slices`] minimises, with `Fr = rho_s F(0)` and the peak
/// height D(0) (a fit's own step 2 may take another, see [`crate::Anchor`]).
///
/// # Errors
/// As [`fit_slices`]; [`FitError::Parameters`] where the model cannot be evaluated.
pub fn step_costs(
    slices: &Slices,
    options: &FitOptions,
    parameters: &[SgdParameters; 3],
) -> Result<[[f64; 2]; 3], FitError> {
    let [rows_h, rows_d] = rows_of(slices, options)?;
    let mut costs = [[0.0; 2]; 3];
    for c in 0..3 {
        let sgd = Sgd::new(parameters[c])?;
        costs[c] = [Step1::cost_of(&rows_h, c, &sgd, options), Step2::cost_of(&rows_d, c, &sgd, options)];
    }
    Ok(costs)
}

/// The rows of both slices that the options leave.
fn rows_of(slices: &Slices, options: &FitOptions) -> Result<[Vec<Row>; 2], FitError> {
    options.check()?;
    let rows = |angles, measured, slice, cutoff, needed| {
        let rows = rows_within(angles, measured, cutoff);
        if rows.len() < needed {
            return Err(FitError::FewRows { slice, found: rows.len(), needed, cutoff });
        }
        Ok(rows)
    };
    Ok([
        rows(&slices.theta_h, &slices.measured_h, "theta_h", options.cutoff_theta_h_degrees, 8)?,
        rows(&slices.theta_d, &slices.measured_d, "theta_d", options.cutoff_theta_d_degrees, 4)?,
    ])
}

/// Puts together what the document says of one channel.
fn describe(
    channel: usize,
    n: usize,
    step1: &Step1,
    step2: &Step2,
    rows_h: &[Row],
    slices: &Slices,
    options: &FitOptions,
) -> Result<ChannelFit, LmError> {
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
    let reports = [report_step1(step1), report_step2(step2, options)];
    let mut standard_errors = standard_errors_step1(n, step1);
    step2.enter_standard_errors(&mut standard_errors);
    let derived = Derived {
        k: step1.distribution.k(),
        fr: if step1.is_flat(n) { 0.0 } else { step1.fr(n) },
        anchor: step2.anchor,
        g1: fit_g1(&curve)?,
        albedo: ALBEDO_DEGREES.map(|degrees| directional_albedo(&sgd, &curve, degrees.to_radians())),
        fresnel_range: parameters.fresnel().range(),
    };
    let flags = flags(channel, &parameters, &derived, &standard_errors, &reports, step2, rows_h, slices, options);
    Ok(ChannelFit {
        name: CHANNELS[channel].to_owned(),
        parameters,
        derived,
        standard_errors,
        steps: reports.into(),
        flags,
    })
}

fn report_step1(step1: &Step1) -> StepReport {
    let solution = &step1.solution;
    let channels = step1.rho_d.len();
    let active = solution.active.iter().enumerate().filter_map(|(index, bound)| {
        let name = unknown_name(index, channels);
        let channel =
            if channels > 1 && index < 2 * channels { format!(" {}", CHANNELS[index / 2]) } else { String::new() };
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
        iterations: step1.iterations,
        termination: solution.termination,
        start: step1.start,
        active_bounds: active.collect(),
        condition_number: solution.uncertainty().condition_number,
    }
}

fn report_step2(step2: &Step2, options: &FitOptions) -> StepReport {
    StepReport {
        name: "theta_d".to_owned(),
        solver: match options.step2_solver {
            Step2Solver::Convex => "convex",
            Step2Solver::LevenbergMarquardt => "levenberg-marquardt",
        }
        .to_owned(),
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
fn standard_errors_step1(n: usize, step1: &Step1) -> StandardErrors {
    let channels = step1.rho_d.len();
    let uncertainty = step1.solution.uncertainty();
    let of = |index: usize| uncertainty.standard_errors[index];
    let (alpha, p) = (step1.distribution.alpha(), step1.distribution.p());
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
        p: of(2 * channels + 1).filter(|error| error.is_finite() && p.is_finite()),
        rho_s: None,
        f0: None,
        f1: None,
    }
}

#[allow(clippy::too_many_arguments)]
fn flags(
    channel: usize,
    parameters: &SgdParameters,
    derived: &Derived,
    standard_errors: &StandardErrors,
    reports: &[StepReport; 2],
    step2: &Step2,
    rows_h: &[Row],
    slices: &Slices,
    options: &FitOptions,
) -> Vec<Flag> {
    let within = slices.theta_h.iter().filter(|theta| theta.to_degrees() <= options.cutoff_theta_h_degrees).count();
    let peak = derived.fr.abs() * Sgd::new(*parameters).map_or(0.0, |sgd| sgd.distribution().d_at(0.0));
    let zero_peak = rows_h.iter().take(3).all(|row| row.measured[channel] == 0.0);
    let [low, high] = derived.fresnel_range;
    let specular = parameters.rho_s != 0.0;
    let candidates = [
        (Flag::ZeroPeak, zero_peak),
        (Flag::NoPeak, peak <= 1e-3 * parameters.rho_d),
        (Flag::NoSpecular, !specular),
        (Flag::Step1AtBound, !reports[0].active_bounds.is_empty()),
        (Flag::FresnelConstrained, specular && !reports[1].active_bounds.is_empty()),
        (Flag::FresnelOutsideUnit, specular && (low < -1e-6 || high > 1.0 + 1e-6)),
        (Flag::RhoSWeak, specular && standard_errors.rho_s.is_none_or(|error| error > WEAK * parameters.rho_s.abs())),
        (Flag::Step1IllConditioned, reports[0].condition_number.is_none_or(|number| number > ILL_CONDITIONED)),
        (Flag::NotConverged, reports.iter().any(|report| !report.termination.converged())),
        (Flag::FewRows, 2 * rows_h.len() < within),
        (Flag::PeakMissed, step2.peak_missed),
    ];
    candidates.into_iter().filter_map(|(flag, raised)| raised.then_some(flag)).collect()
}
