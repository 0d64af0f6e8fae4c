//! The fit of a material: both steps for three channels, and what is reported about them.

use crate::document::{CHANNELS, ChannelFit, CurvePair, SliceCurves};
use crate::lm::problem::LmError;
use crate::options::{DistributionSharing, FitOptions, OptionsError};
use crate::report::FittedChannel;
use crate::steps::distribution_fit::Step1;
use crate::steps::fresnel_fit::Step2;
use crate::steps::slice_rows::{Row, rows_within};
use brdfit_brdf::{ParameterError, Sgd, SgdParameters, SmithG1};
use brdfit_measured::Slices;
use rayon::prelude::*;

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
            let step2 =
                Step2::fit(&rows_d, slices.theta_h[0], &rows_h, c, step1, n, options).map_err(solver_error(c))?;
            let smith = SmithG1::new(&step1.distribution);
            let fitted_h = slices.theta_h.iter().map(|&theta| step1.curve(n, &smith, theta)).collect();
            let fitted_d = slices.theta_d.iter().map(|&theta| step2.curve(&smith, theta)).collect();
            let fitted =
                FittedChannel { channel: c, n, step1, step2: &step2, rows: [&rows_h, &rows_d], slices, options };
            let fit = fitted.describe().map_err(solver_error(c))?;
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
/// height D of theta_h bin 0 (a fit's own step 2 may take another, see [`crate::Anchor`]).
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
        costs[c] =
            [Step1::cost_of(&rows_h, c, &sgd, options), Step2::cost_of(&rows_d, slices.theta_h[0], c, &sgd, options)];
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
