//! The fit of a material: both steps for three channels, and their report.

use crate::document::{ChannelFit, CurvePair, SliceCurves};
use crate::lm::problem::LmError;
use crate::options::{DistributionSharing, FitOptions, OptionsError};
use crate::steps::channel_report::FittedChannel;
use crate::steps::distribution_fit::{DistributionFit, DistributionTask};
use crate::steps::fresnel_fit::{FittedLobe, FresnelTask};
use crate::steps::slice_rows::{Row, rows_within};
use brdfit_brdf::{
    ChannelError, DistributionVisitor, MaterialParameters, Microfacet, MicrofacetParameters, ModelName,
    NormalDistribution,
};
use brdfit_measured::{CHANNEL_NAMES, Slices};
use rayon::prelude::*;

/// The fit of one material.
#[derive(Clone, Debug, PartialEq)]
pub struct MaterialFit {
    /// The parameters of R, G and B.
    pub parameters: MaterialParameters,
    /// R, G, B.
    pub channels: [ChannelFit; 3],
    /// The slices with the fitted curves.
    pub slices: SliceCurves,
}

/// Errors of a fit.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum FitError {
    /// The options cannot be followed.
    #[error(transparent)]
    Options(#[from] OptionsError),
    /// A slice has too few measured rows inside its cut-off.
    #[error("only {found} rows of the {slice} slice have a measurement up to {cutoff} degrees; the fit needs {needed}")]
    FewRows {
        /// The slice.
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
    Parameters(#[from] ChannelError),
    /// The solver refused: a measurement far outside of any BRDF's range.
    #[error("the solver failed in channel {channel}: {source}")]
    Solver {
        /// The channel.
        channel: &'static str,
        /// Its error.
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
pub fn fit_slices(slices: &Slices, model: ModelName, options: &FitOptions) -> Result<MaterialFit, FitError> {
    let rows = rows_of(slices, model, options)?;
    model.visit(TwoSteps { model, slices, options, rows: &rows })
}

/// The costs of given parameters in both steps, per channel: what [`fit_slices`] minimises, with `Fr = rho_s F(0)` and the peak
/// height D of theta_h bin 0 (a fit's own step 2 may take another, see [`crate::Anchor`]).
///
/// # Errors
/// As [`fit_slices`].
pub fn step_costs(
    slices: &Slices,
    options: &FitOptions,
    parameters: &MaterialParameters,
) -> Result<[[f64; 2]; 3], FitError> {
    let rows = rows_of(slices, parameters.model(), options)?;
    let steps = TwoSteps { model: parameters.model(), slices, options, rows: &rows };
    Ok(parameters.model().visit(Costs { steps, parameters }))
}

/// Both steps for the distribution of a model.
struct TwoSteps<'a> {
    model: ModelName,
    slices: &'a Slices,
    options: &'a FitOptions,
    rows: &'a [Vec<Row>; 2],
}

/// Result of both steps for a channel.
struct ChannelResult {
    values: Vec<f64>,
    fit: ChannelFit,
    fitted_h: Vec<f64>,
    fitted_d: Vec<f64>,
}

impl TwoSteps<'_> {
    fn step1(&self) -> DistributionTask<'_> {
        DistributionTask { rows: &self.rows[0], position: self.slices.position, options: self.options }
    }

    fn step2(&self) -> FresnelTask<'_> {
        FresnelTask { rows: &self.rows[1], theta_h: self.slices.theta_h[0], options: self.options }
    }

    /// Channel `channel`, with the distribution of all channels if they share one.
    fn channel<D: NormalDistribution<N>, const N: usize>(
        &self,
        channel: usize,
        joint: Option<&DistributionFit<D>>,
    ) -> Result<ChannelResult, LmError> {
        let own = if joint.is_none() { Some(self.step1().fit::<D, N>(&[channel])?) } else { None };
        let (step1, n) = match (joint, &own) {
            (Some(joint), _) => (joint, channel),
            (None, Some(own)) => (own, 0),
            (None, None) => unreachable!("one of the two was fitted"),
        };
        let lobe = FittedLobe { step1, channel, n, peak_row: &self.rows[0][0] };
        let step2 = self.step2().fit(&lobe)?;
        let rows = self.rows.each_ref().map(Vec::as_slice);
        let fitted = FittedChannel { lobe, step2: &step2, rows, slices: self.slices, options: self.options };
        let values = fitted.parameters().values();
        let names = self.model.model().parameters().iter().map(|parameter| parameter.name);
        Ok(ChannelResult {
            fit: fitted.describe(names.zip(values.iter().copied()).collect())?,
            values,
            fitted_h: self.slices.theta_h.iter().map(|&theta| step1.curve(n, theta)).collect(),
            fitted_d: self.slices.theta_d.iter().map(|&theta| step2.curve(&step1.distribution, theta)).collect(),
        })
    }
}

impl DistributionVisitor for TwoSteps<'_> {
    type Output = Result<MaterialFit, FitError>;

    fn visit<D: NormalDistribution<N>, const N: usize>(self) -> Self::Output {
        let solver_error = |c: usize| move |source| FitError::Solver { channel: CHANNEL_NAMES[c], source };
        let joint = match self.options.distribution {
            DistributionSharing::PerChannel => None,
            DistributionSharing::Joint => Some(self.step1().fit::<D, N>(&[0, 1, 2]).map_err(solver_error(0))?),
        };
        let results: Vec<ChannelResult> = (0..3)
            .into_par_iter()
            .map(|c| self.channel::<D, N>(c, joint.as_ref()).map_err(solver_error(c)))
            .collect::<Result<_, FitError>>()?;
        let [r, g, b]: [_; 3] = results.try_into().ok().expect("three channels");
        let slices = self.slices;
        Ok(MaterialFit {
            parameters: MaterialParameters::new(self.model, [r.values, g.values, b.values])?,
            channels: [r.fit, g.fit, b.fit],
            slices: SliceCurves {
                theta_h: slices.theta_h.clone(),
                theta_d: slices.theta_d.clone(),
                measured: CurvePair { theta_h: slices.measured_h.clone(), theta_d: slices.measured_d.clone() },
                fitted: CurvePair {
                    theta_h: [r.fitted_h, g.fitted_h, b.fitted_h],
                    theta_d: [r.fitted_d, g.fitted_d, b.fitted_d],
                },
            },
        })
    }
}

/// The costs of given parameters.
struct Costs<'a> {
    steps: TwoSteps<'a>,
    parameters: &'a MaterialParameters,
}

impl DistributionVisitor for Costs<'_> {
    type Output = [[f64; 2]; 3];

    fn visit<D: NormalDistribution<N>, const N: usize>(self) -> Self::Output {
        [0, 1, 2].map(|c: usize| {
            let parameters = MicrofacetParameters::from_values(self.parameters.channel(c));
            let model = Microfacet::<D, N>::new(parameters).expect("inside of the model's domain");
            [self.steps.step1().cost_of(c, &model), self.steps.step2().cost_of(c, &model)]
        })
    }
}

/// The rows of both slices that the options leave.
fn rows_of(slices: &Slices, model: ModelName, options: &FitOptions) -> Result<[Vec<Row>; 2], FitError> {
    options.check(model)?;
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
