//! Tolerances of a comparison.

use serde::{Deserialize, Serialize};

/// The result of a check.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Verdict {
    /// Within the tolerances, or not judged.
    Agree,
    /// Beyond the first tolerance.
    Warn,
    /// Beyond the second tolerance.
    Fail,
}

/// Two limits for a difference. Infinity switches one off.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Tolerance {
    /// Beyond this a difference is worth a look.
    pub warn: f64,
    /// Beyond this the comparison fails.
    pub fail: f64,
}

impl Tolerance {
    /// The verdict on a difference; one that is not a number fails.
    pub fn judge(&self, difference: f64) -> Verdict {
        if difference <= self.warn.min(self.fail) {
            Verdict::Agree
        } else if difference <= self.fail {
            Verdict::Warn
        } else {
            Verdict::Fail
        }
    }
}

/// All limits of a comparison, all relative. The defaults follow docs/theory.md, section 4.
///
/// A fit ends where its cost is smallest, so the cost is what two solvers must agree on. Where the valley is flat the curve
/// at its end may still move: by Pythagoras, two fits whose costs differ by the relative amount t differ by up to sqrt(t)
/// of the misfit, in the metric of the residual. Hence the limits of the curves, the square roots of those of the costs, the
/// floor below which values count as equally dark, and the rule that curves and errors are judged only where the costs agree:
/// elsewhere the two programs did not find the same minimum, and it is the cost that says which of them is to blame.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Tolerances {
    /// Largest relative difference of a measured value.
    pub measured: f64,
    /// Cost of a step above the reference's.
    pub cost: Tolerance,
    /// Root mean square difference of a fitted curve.
    pub curve: Tolerance,
    /// Difference of E, L and C.
    pub errors: Tolerance,
    /// Whether a cost that is lower than the reference's is a difference, too.
    pub two_sided: bool,
    /// Costs up to this are all the same: the model passes through the data (a root mean square residual of about 1e-8).
    pub cost_floor: f64,
    /// Values below this (1/sr) count as this large in the relative difference of two curves.
    pub curve_floor: f64,
}

impl Default for Tolerances {
    fn default() -> Self {
        Self {
            measured: 1e-9,
            cost: Tolerance { warn: 1e-6, fail: 1e-4 },
            curve: Tolerance { warn: 1e-3, fail: 1e-2 },
            errors: Tolerance { warn: 1e-3, fail: 1e-2 },
            two_sided: false,
            cost_floor: 1e-14,
            curve_floor: 1e-3,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn limits_belong_to_the_better_verdict_and_nan_fails() {
        let tolerance = Tolerance { warn: 1e-6, fail: 1e-4 };
        let cases = [(-1.0, Verdict::Agree), (1e-6, Verdict::Agree), (2e-6, Verdict::Warn), (1e-4, Verdict::Warn)];
        for (difference, verdict) in cases {
            assert_eq!(tolerance.judge(difference), verdict, "{difference}");
        }
        for difference in [1.1e-4, f64::INFINITY, f64::NAN] {
            assert_eq!(tolerance.judge(difference), Verdict::Fail);
        }
    }

    #[test]
    fn infinity_switches_a_limit_off() {
        let never = Tolerance { warn: f64::INFINITY, fail: f64::INFINITY };
        assert_eq!(never.judge(1e300), Verdict::Agree);
        let only_fail = Tolerance { warn: f64::INFINITY, fail: 0.1 };
        assert_eq!(only_fail.judge(0.2), Verdict::Fail);
        assert_eq!(only_fail.judge(0.05), Verdict::Agree);
    }
}
