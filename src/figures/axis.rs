//! Axes: from values to positions in [0, 1], with their ticks.

/// A mark on an axis.
#[derive(Clone, Debug, PartialEq)]
pub struct Tick {
    /// Position, 0 at the start of the axis and 1 at its end.
    pub at: f64,
    /// Its label; empty at a minor tick.
    pub label: Option<Label>,
}

/// The text of a tick.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Label {
    /// As it stands.
    Plain(String),
    /// Ten to this power.
    PowerOfTen(i32),
}

/// A logarithmic axis whose ends are 1, 2 or 5 times a power of ten.
#[derive(Clone, Debug, PartialEq)]
pub struct LogAxis {
    low: f64,
    high: f64,
    ticks: Vec<Tick>,
}

impl LogAxis {
    /// The axis that holds `least` and `most`, both above zero.
    #[must_use]
    pub fn new(least: f64, most: f64) -> Self {
        let (low, high) = (round_down(least), round_up(most));
        let mut axis = Self { low: log10(low), high: log10(high), ticks: Vec::new() };
        let decades = axis.high - axis.low;
        let step = if decades <= 7.0 { 1 } else { 2 };
        let (first, last) = (floor_exponent(low), floor_exponent(high));
        for exponent in first..=last {
            for digit in 1..=9 {
                let value = f64::from(digit) * power_of_ten(exponent);
                // a slack for the rounding of the ends
                if value < low * (1.0 - 1e-9) || value > high * (1.0 + 1e-9) {
                    continue;
                }
                let label = if decades >= 2.5 {
                    (digit == 1 && exponent.rem_euclid(step) == 0).then_some(Label::PowerOfTen(exponent))
                } else {
                    let labelled = if decades < 0.8 { true } else { [1, 2, 5].contains(&digit) };
                    labelled.then(|| Label::Plain(decimal(digit, exponent)))
                };
                if label.is_some() || digit == 1 || decades <= 6.0 {
                    axis.ticks.push(Tick { at: axis.position(value).clamp(0.0, 1.0), label });
                }
            }
        }
        axis
    }

    /// Position of a value: below 0 or above 1 off the axis, minus infinity if the value has no logarithm.
    #[must_use]
    pub fn position(&self, value: f64) -> f64 {
        if value > 0.0 { (log10(value) - self.low) / (self.high - self.low) } else { f64::NEG_INFINITY }
    }

    /// Its ticks in rising order.
    #[must_use]
    pub fn ticks(&self) -> &[Tick] {
        &self.ticks
    }
}

/// An axis of angles from 0 to 90 degrees.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum AngleAxis {
    /// Even.
    Linear,
    /// By the square root, as the bins of theta_h: a narrow peak becomes visible.
    SquareRoot,
}

impl AngleAxis {
    /// Position of an angle in degrees.
    #[must_use]
    pub fn position(self, degrees: f64) -> f64 {
        let share = (degrees / 90.0).clamp(0.0, 1.0);
        match self {
            Self::Linear => share,
            Self::SquareRoot => share.sqrt(),
        }
    }

    /// Its ticks in rising order.
    #[must_use]
    pub fn ticks(self) -> Vec<Tick> {
        let degrees: &[u32] = match self {
            Self::Linear => &[0, 15, 30, 45, 60, 75, 90],
            Self::SquareRoot => &[0, 1, 5, 10, 20, 30, 45, 60, 75, 90],
        };
        degrees
            .iter()
            .map(|&degrees| Tick {
                at: self.position(f64::from(degrees)),
                label: Some(Label::Plain(degrees.to_string())),
            })
            .collect()
    }
}

fn log10(value: f64) -> f64 {
    libm::log10(value)
}

fn power_of_ten(exponent: i32) -> f64 {
    libm::exp10(f64::from(exponent))
}

/// The exponent of the leading digit.
fn floor_exponent(value: f64) -> i32 {
    (log10(value) + 1e-9).floor() as i32
}

/// The largest of 1, 2, 5 times a power of ten that is not above the value.
fn round_down(value: f64) -> f64 {
    let unit = power_of_ten(floor_exponent(value));
    [5.0, 2.0].into_iter().map(|digit| digit * unit).find(|&round| round <= value * (1.0 + 1e-9)).unwrap_or(unit)
}

/// The smallest of 1, 2, 5 times a power of ten that is not below the value.
fn round_up(value: f64) -> f64 {
    let unit = power_of_ten(floor_exponent(value));
    [1.0, 2.0, 5.0]
        .into_iter()
        .map(|digit| digit * unit)
        .find(|&round| round >= value * (1.0 - 1e-9))
        .unwrap_or(10.0 * unit)
}

/// A digit times a power of ten, written out.
fn decimal(digit: i32, exponent: i32) -> String {
    let value = f64::from(digit) * power_of_ten(exponent);
    format!("{value:.*}", usize::try_from(-exponent).unwrap_or(0))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn labels(axis: &LogAxis) -> Vec<Label> {
        axis.ticks().iter().filter_map(|tick| tick.label.clone()).collect()
    }

    #[test]
    fn ends_are_round_and_hold_the_values() {
        for (least, most) in [(0.3, 0.4), (1e-3, 7.0), (2.5e-7, 9.9e5), (1.0, 10.0), (0.1, 0.2)] {
            let axis = LogAxis::new(least, most);
            let (low, high) = (axis.position(least), axis.position(most));
            assert!(-1e-9 <= low && low < high && high <= 1.0 + 1e-9, "{least} {most}: {low} {high}");
            let ticks: Vec<f64> = axis.ticks().iter().map(|tick| tick.at).collect();
            assert!(ticks.is_sorted() && ticks[0] < 0.1 && ticks[ticks.len() - 1] > 0.9, "{ticks:?}");
            assert!(labels(&axis).len() >= 2, "{least} {most}");
        }
    }

    #[test]
    fn labels_follow_the_span() {
        let plain = |texts: &[&str]| texts.iter().map(|&text| Label::Plain(text.to_owned())).collect::<Vec<_>>();
        assert_eq!(labels(&LogAxis::new(0.21, 0.49)), plain(&["0.2", "0.3", "0.4", "0.5"]));
        assert_eq!(labels(&LogAxis::new(0.03, 1.2)), plain(&["0.02", "0.05", "0.1", "0.2", "0.5", "1", "2"]));
        assert_eq!(labels(&LogAxis::new(0.01, 99.0)), (-2..=2).map(Label::PowerOfTen).collect::<Vec<_>>());
        assert_eq!(labels(&LogAxis::new(1e-6, 1e4)), [-6, -4, -2, 0, 2, 4].map(Label::PowerOfTen));
    }

    #[test]
    fn what_is_outside_lies_outside() {
        let axis = LogAxis::new(1e-3, 1.0);
        assert!(axis.position(1e-4) < -0.3 && axis.position(2.0) > 1.05);
        assert_eq!((axis.position(0.0), axis.position(-1.0)), (f64::NEG_INFINITY, f64::NEG_INFINITY));
        assert!((axis.position(1.0) - 1.0).abs() < 1e-12);
    }

    #[test]
    fn the_square_root_opens_the_small_angles() {
        assert_eq!(AngleAxis::SquareRoot.position(22.5), 0.5);
        assert_eq!(AngleAxis::Linear.position(22.5), 0.25);
        assert!(AngleAxis::SquareRoot.ticks().windows(2).all(|pair| pair[1].at - pair[0].at > 0.08));
    }
}
