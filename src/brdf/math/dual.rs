//! Forward-mode dual numbers: a value together with its derivative with respect to one variable.
//!
//! The special functions are written once, on [`Dual`], and so return a derivative that is that of the very algorithm
//! that computes the value.

use std::ops::{Add, Div, Mul, Neg, Sub};

/// A value and its derivative with respect to one variable.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Dual {
    /// The value.
    pub(crate) value: f64,
    /// Its derivative.
    pub(crate) slope: f64,
}

impl Dual {
    /// The variable itself: slope one.
    pub(crate) fn variable(value: f64) -> Self {
        Self { value, slope: 1.0 }
    }

    /// A number that does not depend on the variable.
    pub(crate) fn constant(value: f64) -> Self {
        Self { value, slope: 0.0 }
    }

    /// `e^self`.
    pub(crate) fn exp(self) -> Self {
        let value = libm::exp(self.value);
        Self { value, slope: value * self.slope }
    }

    /// Natural logarithm.
    pub(crate) fn ln(self) -> Self {
        Self { value: libm::log(self.value), slope: self.slope / self.value }
    }
}

impl Add for Dual {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        Self { value: self.value + other.value, slope: self.slope + other.slope }
    }
}

impl Sub for Dual {
    type Output = Self;
    fn sub(self, other: Self) -> Self {
        Self { value: self.value - other.value, slope: self.slope - other.slope }
    }
}

impl Mul for Dual {
    type Output = Self;
    fn mul(self, other: Self) -> Self {
        Self { value: self.value * other.value, slope: self.slope * other.value + self.value * other.slope }
    }
}

impl Div for Dual {
    type Output = Self;
    fn div(self, other: Self) -> Self {
        let value = self.value / other.value;
        Self { value, slope: (self.slope - value * other.slope) / other.value }
    }
}

impl Neg for Dual {
    type Output = Self;
    fn neg(self) -> Self {
        Self { value: -self.value, slope: -self.slope }
    }
}

impl Add<f64> for Dual {
    type Output = Self;
    fn add(self, other: f64) -> Self {
        Self { value: self.value + other, slope: self.slope }
    }
}

impl Mul<f64> for Dual {
    type Output = Self;
    fn mul(self, other: f64) -> Self {
        Self { value: self.value * other, slope: self.slope * other }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn slopes_follow_the_rules_of_differentiation() {
        // f(x) = exp(x) / (x ln x - 3 x), f'(x) by the quotient rule written out.
        let x = 1.7_f64;
        let v = Dual::variable(x);
        let f = v.exp() / (v * v.ln() - v * 3.0);
        let (g, dg) = (x * x.ln() - 3.0 * x, x.ln() + 1.0 - 3.0);
        let expected = x.exp() * (g - dg) / (g * g);
        assert!((f.slope - expected).abs() < 1e-14 * expected.abs());
        assert_eq!((-v + Dual::constant(2.0) + 1.0).value, 3.0 - x);
    }
}
