//! Options of a fit. All of them influence the result and are recorded in it.

use brdfit_brdf::{DistributionVisitor, ModelName, NormalDistribution};
use brdfit_measured::SamplePosition;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// The options of a fit; [`FitOptions::new`] is the best all-round choice of docs/theory.md, section 4. Where the samples lie in
/// their cells is a property of the slices, [`brdfit_measured::Slices::position`].
#[derive(Clone, Debug, PartialEq)]
pub struct FitOptions {
    /// One distribution per channel, or one for all three.
    pub distribution: DistributionSharing,
    /// Loss that both steps minimise.
    pub loss: Loss,
    /// Constraint on the Fresnel term.
    pub constraint: Constraint,
    /// Height of the specular peak in step 2.
    pub anchor: Anchor,
    /// Solver of step 2.
    pub step2_solver: Step2Solver,
    /// Rows of the theta_h slice beyond this angle are excluded from step 1; degrees.
    pub cutoff_theta_h_degrees: f64,
    /// Rows of the theta_d slice beyond this angle are excluded from step 2; degrees.
    pub cutoff_theta_d_degrees: f64,
    /// Starts of step 1, each the shape parameters of the model's distribution ("sgd": alpha, p); the best result is kept,
    /// of equal ones the first.
    pub starts: Vec<Vec<f64>>,
    /// Iteration limit of each solver run.
    pub max_iterations: u64,
}

impl Default for FitOptions {
    /// Those of the default model.
    fn default() -> Self {
        Self::new(ModelName::default())
    }
}

impl FitOptions {
    /// The best all-round choice for a model.
    pub fn new(model: ModelName) -> Self {
        Self {
            distribution: DistributionSharing::PerChannel,
            loss: Loss::Log1pCos,
            constraint: Constraint::Physical,
            anchor: Anchor::Peak,
            step2_solver: Step2Solver::Convex,
            cutoff_theta_h_degrees: 75.0,
            cutoff_theta_d_degrees: 75.0,
            starts: model.visit(Starts),
            max_iterations: 200,
        }
    }

    /// The published procedure as far as it is known (thesis V.4): plain least squares in both steps, no constraint on the Fresnel
    /// term, the analytic peak, theta_d up to 70 degrees, Levenberg-Marquardt throughout.
    pub fn published(model: ModelName) -> Self {
        Self {
            loss: Loss::L2,
            constraint: Constraint::Free,
            anchor: Anchor::Distribution,
            step2_solver: Step2Solver::LevenbergMarquardt,
            cutoff_theta_d_degrees: 70.0,
            ..Self::new(model)
        }
    }

    /// Refuses options that no fit of the model can follow, naming the option.
    ///
    /// # Errors
    /// One line for the first option outside of its range.
    pub fn check(&self, model: ModelName) -> Result<(), OptionsError> {
        let refuse = |what: String| Err(OptionsError(what));
        for (name, degrees) in
            [("cutoff_theta_h", self.cutoff_theta_h_degrees), ("cutoff_theta_d", self.cutoff_theta_d_degrees)]
        {
            if !(10.0..=89.9).contains(&degrees) {
                return refuse(format!("{name} is {degrees} degrees, it must lie between 10 and 89.9"));
            }
        }
        model.visit(CheckStarts(&self.starts))?;
        if self.max_iterations == 0 {
            return refuse("max_iterations is 0, it must be at least 1".to_owned());
        }
        Ok(())
    }
}

/// An option outside of its range.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{0}")]
pub struct OptionsError(pub String);

/// The starts of a model.
struct Starts;

impl DistributionVisitor for Starts {
    type Output = Vec<Vec<f64>>;

    fn visit<D: NormalDistribution<N>, const N: usize>(self) -> Self::Output {
        D::STARTS.iter().map(|start| start.to_vec()).collect()
    }
}

/// Whether starting points lie inside the box of the distribution's unknowns.
struct CheckStarts<'a>(&'a [Vec<f64>]);

impl DistributionVisitor for CheckStarts<'_> {
    type Output = Result<(), OptionsError>;

    fn visit<D: NormalDistribution<N>, const N: usize>(self) -> Self::Output {
        let names = D::SHAPE.map(|parameter| parameter.name).join(",");
        let what = if N == 1 { "number" } else { "list" };
        if self.0.is_empty() {
            return Err(OptionsError(format!("there is no start for step 1: give at least one {what} {names}")));
        }
        for start in self.0 {
            if start.len() != N {
                let count = start.len();
                return Err(OptionsError(format!(
                    "a starting point of the model {} is {names}, not {count} number{}",
                    D::MODEL,
                    if count == 1 { "" } else { "s" }
                )));
            }
            let places = || start.iter().zip(D::SHAPE);
            if places().any(|(value, parameter)| !(parameter.range[0]..=parameter.range[1]).contains(value)) {
                let values = places().map(|(value, parameter)| format!("{} {value}", parameter.name));
                let ranges = D::SHAPE.map(|parameter| {
                    let [low, high] = parameter.range.map(shortest);
                    format!("{} in [{low}, {high}]", parameter.name)
                });
                let (values, ranges) = (values.collect::<Vec<_>>().join(", "), ranges.join(", "));
                return Err(OptionsError(format!("the start {values} lies outside of {ranges}")));
            }
        }
        Ok(())
    }
}

/// A number as briefly as it can be read: 1e-6 and 0.5.
fn shortest(value: f64) -> String {
    let (plain, exponent) = (format!("{value}"), format!("{value:e}"));
    if exponent.len() < plain.len() { exponent } else { plain }
}

/// The options of a fit as documents record them, with the position of the samples.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "FitOptions")]
pub struct RecordedOptions {
    /// Position of a sample within its cell.
    pub sample_position: SamplePosition,
    /// One distribution per channel, or one for all three.
    pub distribution: DistributionSharing,
    /// Loss that both steps minimise.
    pub loss: Loss,
    /// Constraint on the Fresnel term.
    pub constraint: Constraint,
    /// Height of the specular peak in step 2.
    pub anchor: Anchor,
    /// Solver of step 2.
    pub step2_solver: Step2Solver,
    /// Rows of the theta_h slice beyond this angle are excluded from step 1; degrees.
    pub cutoff_theta_h_degrees: f64,
    /// Rows of the theta_d slice beyond this angle are excluded from step 2; degrees.
    pub cutoff_theta_d_degrees: f64,
    /// Starts of step 1, each the shape parameters of the model's distribution ("sgd": alpha, p); the best result is kept,
    /// of equal ones the first.
    pub starts: Vec<Vec<f64>>,
    /// Iteration limit of each solver run.
    pub max_iterations: u64,
}

impl RecordedOptions {
    /// The recorded options of a fit to slices with this position of the samples.
    pub fn new(options: &FitOptions, sample_position: SamplePosition) -> Self {
        let FitOptions {
            distribution,
            loss,
            constraint,
            anchor,
            step2_solver,
            cutoff_theta_h_degrees,
            cutoff_theta_d_degrees,
            starts,
            max_iterations,
        } = options.clone();
        Self {
            sample_position,
            distribution,
            loss,
            constraint,
            anchor,
            step2_solver,
            cutoff_theta_h_degrees,
            cutoff_theta_d_degrees,
            starts,
            max_iterations,
        }
    }
}

/// Whether the channels share alpha and p.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum DistributionSharing {
    /// Each channel has its own alpha and p.
    #[default]
    PerChannel,
    /// One alpha and p for R, G and B, three rho_d and three Fr (thesis V.5.5).
    Joint,
}

/// The residual that both steps minimise (docs/theory.md, section 4).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Loss {
    /// Step 1: `w^0.375 [ln(1 + m cos) - ln(1 + y cos)]`; step 2: the linearised cube root.
    #[default]
    Log1pCos,
    /// Step 1: `w^0.5 [sqrt(m cos) - sqrt(y cos)]`, independent of the scale of f; step 2: the linearised cube root.
    SqrtCos,
    /// Step 1: `w^0.5 (m - y)` (thesis eq. V.6); step 2: `m - y`, unweighted.
    L2,
}

/// What step 2 demands of `F(theta_d)`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Constraint {
    /// `0 <= F <= 1` at every third degree, `rho_s >= 0`.
    #[default]
    Physical,
    /// `F >= 0` at every third degree, `rho_s >= 0`.
    NonNegative,
    /// No constraint.
    Free,
}

/// The peak height `A` in step 2's `q = A G1^2 / (pi cos^2)`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Anchor {
    /// Implied by the measured peak cell: D(0) times the ratio of its excess over rho_d to the fitted lobe there, at least
    /// D(0)/2; then `rho_s F(0) = Fr`. D(0) stands for D at the first sample, which is 0 for samples at the edge.
    #[default]
    Peak,
    /// `D(0)` of the fitted distribution.
    Distribution,
}

/// Solver of the convex problem of step 2; both reach the same minimum.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Step2Solver {
    /// QR factorisation and one non-negative least squares: exact.
    #[default]
    Convex,
    /// Levenberg-Marquardt on the cone's generators, as the thesis does.
    LevenbergMarquardt,
}
