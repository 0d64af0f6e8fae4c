//! What a fit can be asked to do. Everything here influences the result and is written into it.

use brdfit_measured::SamplePosition;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// The options of a fit; [`Default`] is the best all-round choice of docs/theory.md, section 4.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct FitOptions {
    /// Where in its cell a sample lies.
    pub sample_position: SamplePosition,
    /// One distribution per channel, or one for all three.
    pub distribution: DistributionSharing,
    /// What both steps minimise.
    pub loss: Loss,
    /// What the Fresnel term has to satisfy.
    pub constraint: Constraint,
    /// What step 2 takes for the height of the specular peak.
    pub anchor: Anchor,
    /// How step 2 is solved.
    pub step2_solver: Step2Solver,
    /// Rows of the theta_h slice beyond this angle take no part in step 1; degrees.
    pub cutoff_theta_h_degrees: f64,
    /// Rows of the theta_d slice beyond this angle take no part in step 2; degrees.
    pub cutoff_theta_d_degrees: f64,
    /// Starts of step 1 as (alpha, p); the best result wins, ties go to the first.
    pub starts: Vec<[f64; 2]>,
    /// Limit of iterations of each run of the solver.
    pub max_iterations: u64,
}

impl Default for FitOptions {
    fn default() -> Self {
        Self {
            sample_position: SamplePosition::Edge,
            distribution: DistributionSharing::PerChannel,
            loss: Loss::Log1pCos,
            constraint: Constraint::Physical,
            anchor: Anchor::Peak,
            step2_solver: Step2Solver::Convex,
            cutoff_theta_h_degrees: 75.0,
            cutoff_theta_d_degrees: 75.0,
            starts: vec![[1e-4, 0.4], [3e-3, 0.4], [0.1, 0.4], [0.9, 0.1], [1e-5, 0.4]],
            max_iterations: 200,
        }
    }
}

impl FitOptions {
    /// The published procedure as far as it is known (thesis V.4): plain least squares in both steps, no constraint on the Fresnel
    /// term, the analytic peak, theta_d up to 70 degrees, Levenberg-Marquardt throughout.
    pub fn paper() -> Self {
        Self {
            loss: Loss::L2,
            constraint: Constraint::Free,
            anchor: Anchor::Distribution,
            step2_solver: Step2Solver::LevenbergMarquardt,
            cutoff_theta_d_degrees: 70.0,
            ..Self::default()
        }
    }

    /// Refuses options that no fit can follow, naming the option.
    ///
    /// # Errors
    /// One line for the first option outside of its range.
    pub fn check(&self) -> Result<(), OptionsError> {
        let refuse = |what: String| Err(OptionsError(what));
        for (name, degrees) in
            [("cutoff_theta_h", self.cutoff_theta_h_degrees), ("cutoff_theta_d", self.cutoff_theta_d_degrees)]
        {
            if !(10.0..=89.9).contains(&degrees) {
                return refuse(format!("{name} is {degrees} degrees, it must lie between 10 and 89.9"));
            }
        }
        if self.starts.is_empty() {
            return refuse("there is no start for step 1: give at least one pair alpha,p".to_owned());
        }
        for [alpha, p] in &self.starts {
            if !(ALPHA_RANGE[0]..=ALPHA_RANGE[1]).contains(alpha) || !(P_RANGE[0]..=P_RANGE[1]).contains(p) {
                return refuse(format!(
                    "the start alpha {alpha}, p {p} lies outside of alpha in [1e-6, 1], p in [0, 2]"
                ));
            }
        }
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

/// Bounds of alpha in step 1.
pub const ALPHA_RANGE: [f64; 2] = [1e-6, 1.0];
/// Bounds of p in step 1.
pub const P_RANGE: [f64; 2] = [0.0, 2.0];

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
    /// Nothing.
    Free,
}

/// The peak height `A` in step 2's `q = A G1^2 / (pi cos^2)`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Anchor {
    /// What the measured peak cell implies: D(0) times the ratio of its excess over rho_d to the fitted lobe there, at least
    /// D(0)/2; then `rho_s F(0) = Fr`. D(0) stands for D at the first sample, which is 0 for samples at the edge.
    #[default]
    Peak,
    /// `D(0)` of the fitted distribution.
    Distribution,
}

/// How the convex problem of step 2 is solved; both end at the same place.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Step2Solver {
    /// QR factorisation and one non-negative least squares: exact.
    #[default]
    Convex,
    /// Levenberg-Marquardt on the cone's generators, as the thesis does.
    LevenbergMarquardt,
}
