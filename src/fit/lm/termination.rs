//! Termination criteria and reasons.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Reason for the termination of the solver.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Termination {
    /// Every residual is zero, or the cost fell to [`Options::cost_floor`].
    ZeroResidual,
    /// The residual is orthogonal to the columns of all free parameters: no cosine exceeds [`Options::gtol`]. Also the
    /// end at a corner of the box where no parameter is free.
    Gtol,
    /// Neither the model nor the cost itself changes by more than [`Options::ftol`], relative to the cost.
    Ftol,
    /// The step, or the trust region, is shorter than [`Options::xtol`] relative to the free parameters.
    Xtol,
    /// The trust region collapsed: residuals around it are not finite.
    NonFinite,
    /// The iteration limit was reached.
    IterationLimit,
    /// argmin stopped the run for a reason of its own (target cost, time limit, interrupt).
    Stopped,
}

impl Termination {
    /// Whether the solver stopped because a convergence test was met.
    pub fn converged(self) -> bool {
        matches!(self, Self::ZeroResidual | Self::Gtol | Self::Ftol | Self::Xtol)
    }

    /// The name, as it is written in JSON.
    pub fn name(self) -> &'static str {
        match self {
            Self::ZeroResidual => "zero_residual",
            Self::Gtol => "gtol",
            Self::Ftol => "ftol",
            Self::Xtol => "xtol",
            Self::NonFinite => "non_finite",
            Self::IterationLimit => "iteration_limit",
            Self::Stopped => "stopped",
        }
    }
}

impl std::fmt::Display for Termination {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(self.name())
    }
}

/// Tolerances and limits of the solver.
///
/// The defaults are tight: a solution costs a few evaluations more than with the usual 1e-8, and its cost is that of the
/// minimum to about twelve digits even where the convergence is only linear.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Options {
    /// Relative change of the cost, predicted and actual, below which the solver stops.
    pub ftol: f64,
    /// Length of the scaled step, relative to that of the scaled free parameters, below which the solver stops.
    pub xtol: f64,
    /// Largest cosine between the residual and a free column of the Jacobian at which the solver stops.
    pub gtol: f64,
    /// Cost at or below which the residual counts as zero.
    pub cost_floor: f64,
    /// Most iterations; every trial point is one, accepted or not.
    pub iteration_limit: u64,
    /// Radius of the first trust region, as a multiple of the length of the scaled start.
    pub radius_factor: f64,
    /// Compute the Jacobian at every trial point, in one call with the residuals, instead of in a second call at
    /// accepted points. The better choice where both together cost less than about six times the residuals.
    pub jacobian_at_trials: bool,
}

impl Default for Options {
    fn default() -> Self {
        Self {
            ftol: 1e-12,
            xtol: 1e-12,
            gtol: 1e-12,
            cost_floor: 0.0,
            iteration_limit: 500,
            radius_factor: 1.0,
            jacobian_at_trials: true,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_those_of_the_json() {
        for t in [
            Termination::ZeroResidual,
            Termination::Gtol,
            Termination::Ftol,
            Termination::Xtol,
            Termination::NonFinite,
            Termination::IterationLimit,
            Termination::Stopped,
        ] {
            let json = serde_json::to_string(&t).unwrap();
            assert_eq!(json, format!("\"{t}\""));
            assert_eq!(serde_json::from_str::<Termination>(&json).unwrap(), t);
        }
    }

    #[test]
    fn options_fill_in_what_is_missing() {
        let options: Options = serde_json::from_str(r#"{"ftol": 1e-6}"#).unwrap();
        assert_eq!(options.ftol, 1e-6);
        assert_eq!(options.xtol, Options::default().xtol);
        assert!(serde_json::from_str::<Options>(r#"{"fotl": 1e-6}"#).is_err());
    }
}
