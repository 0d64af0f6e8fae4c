//! The box of admissible parameters.

use crate::lm::problem::LmError;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// The bound at which a parameter lies.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Bound {
    /// The lower end.
    Lower,
    /// The upper end.
    Upper,
}

/// A box lower <= x <= upper; an infinite bound is none, two equal ones fix the parameter.
#[derive(Debug, Clone, PartialEq)]
pub struct Bounds {
    lower: Vec<f64>,
    upper: Vec<f64>,
}

impl Bounds {
    /// The box between `lower` and `upper`, one entry of each per parameter.
    ///
    /// # Errors
    ///
    /// [`LmError::Length`] if the lengths differ; [`LmError::Bounds`] at the first parameter whose range holds no finite
    /// number: a bound is NaN, lower > upper, lower = +infinity or upper = -infinity.
    pub fn new(lower: Vec<f64>, upper: Vec<f64>) -> Result<Self, LmError> {
        if lower.len() != upper.len() {
            return Err(LmError::Length { what: "the upper bound", expected: lower.len(), found: upper.len() });
        }
        for (index, (&l, &u)) in lower.iter().zip(&upper).enumerate() {
            if !(l <= u && l < f64::INFINITY && u > f64::NEG_INFINITY) {
                return Err(LmError::Bounds { index, lower: l, upper: u });
            }
        }
        Ok(Self { lower, upper })
    }

    /// No bounds on any of `parameters` parameters.
    pub fn none(parameters: usize) -> Self {
        Self { lower: vec![f64::NEG_INFINITY; parameters], upper: vec![f64::INFINITY; parameters] }
    }

    /// Number of parameters.
    pub fn parameters(&self) -> usize {
        self.lower.len()
    }

    /// The lower bounds.
    pub fn lower(&self) -> &[f64] {
        &self.lower
    }

    /// The upper bounds.
    pub fn upper(&self) -> &[f64] {
        &self.upper
    }

    /// Moves each entry of `x` to the nearest point of its range. An entry that ends at a bound has its very bits
    /// (-0 at a bound of +0 becomes +0); NaN stays NaN.
    pub fn project(&self, x: &mut [f64]) {
        for (x, (&l, &u)) in x.iter_mut().zip(self.lower.iter().zip(&self.upper)) {
            if *x <= l {
                *x = l;
            } else if *x >= u {
                *x = u;
            }
        }
    }

    /// The bound that parameter `index` sits at when its value is `x`; the lower one for a fixed parameter.
    pub fn active(&self, index: usize, x: f64) -> Option<Bound> {
        if x == self.lower[index] {
            Some(Bound::Lower)
        } else if x == self.upper[index] {
            Some(Bound::Upper)
        } else {
            None
        }
    }

    /// The bound that holds parameter `index` at `x`, given the derivative of the cost with respect to it: one that the
    /// cost would decrease beyond, or any if the parameter is fixed.
    pub(super) fn holding(&self, index: usize, x: f64, gradient: f64) -> Option<Bound> {
        let fixed = self.lower[index] == self.upper[index];
        self.active(index, x).filter(|bound| {
            fixed
                || match bound {
                    Bound::Lower => gradient > 0.0,
                    Bound::Upper => gradient < 0.0,
                }
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn projection_gives_the_bits_of_the_bound() {
        let bounds = Bounds::new(vec![0.0, -1.0, -0.0], vec![1.0, 0.1, 5.0]).unwrap();
        let mut x = [-0.0, 0.3, 0.0];
        bounds.project(&mut x);
        assert_eq!(x[0].to_bits(), 0.0f64.to_bits());
        assert_eq!(x[1].to_bits(), 0.1f64.to_bits());
        assert_eq!(x[2].to_bits(), (-0.0f64).to_bits());
    }

    #[test]
    fn a_range_without_a_finite_number_is_refused() {
        for (l, u) in [
            (1.0, 0.0),
            (f64::NAN, 0.0),
            (0.0, f64::NAN),
            (f64::INFINITY, f64::INFINITY),
            (f64::NEG_INFINITY, f64::NEG_INFINITY),
        ] {
            let error = Bounds::new(vec![0.0, l], vec![1.0, u]).unwrap_err();
            assert!(matches!(error, LmError::Bounds { index: 1, .. }), "{l} {u}");
        }
        assert!(matches!(Bounds::new(vec![0.0], vec![]), Err(LmError::Length { .. })));
        assert!(Bounds::new(vec![2.0], vec![2.0]).is_ok());
    }

    #[test]
    fn a_bound_holds_only_against_an_outward_descent() {
        let bounds = Bounds::new(vec![0.0, 3.0], vec![1.0, 3.0]).unwrap();
        assert_eq!(bounds.holding(0, 0.0, 1.0), Some(Bound::Lower));
        assert_eq!(bounds.holding(0, 0.0, -1.0), None);
        assert_eq!(bounds.holding(0, 1.0, -1.0), Some(Bound::Upper));
        assert_eq!(bounds.holding(0, 1.0, 1.0), None);
        assert_eq!(bounds.holding(0, 0.5, 1.0), None);
        assert_eq!(bounds.holding(1, 3.0, -1.0), Some(Bound::Lower));
        assert_eq!(bounds.holding(1, 3.0, 0.0), Some(Bound::Lower));
    }
}
