//! Linear axis of a picture: a range between round numbers, and tick marks at 1, 2 or 5 times a power of ten.

/// Largest magnitude; values beyond it are drawn at it, as their differences must stay finite.
const LARGEST: f64 = 1e300;
/// Maximum number of marks.
const MOST_MARKS: usize = 100;

/// Range of values with its marks.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scale {
    low: f64,
    high: f64,
    step: f64,
}

impl Scale {
    /// Creates a scale from the smallest to the largest value with about `marks` marks, ends at marks; 0 to 1 if no value is finite.
    #[must_use]
    pub fn around(values: impl IntoIterator<Item = f64>, marks: usize) -> Scale {
        let all = values.into_iter().filter(|value| value.is_finite()).map(|value| value.clamp(-LARGEST, LARGEST));
        let (mut low, mut high) = all.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| {
            (f64::min(low, value), f64::max(high, value))
        });
        if low > high {
            (low, high) = (0.0, 1.0);
        }
        // A single value gets a margin, even one so large that the next representable number is far away.
        let least = (low.abs().max(high.abs()) * 1e-12).max(1e-12);
        if high - low < least {
            let half = if low == 0.0 { 0.5 } else { low.abs() * 0.1 };
            (low, high) = (low - half, high + half);
        }
        let step = round_step((high - low) / marks.max(1) as f64);
        Scale { low: (low / step + 1e-9).floor() * step, high: (high / step - 1e-9).ceil() * step, step }
    }

    /// Creates a scale with 0 in its middle.
    #[must_use]
    pub fn balanced(values: impl IntoIterator<Item = f64>, marks: usize) -> Scale {
        let all = values.into_iter().filter(|value| value.is_finite());
        let most = all.fold(0.0_f64, |most, value| most.max(value.abs()));
        Scale::around([-most, most], marks)
    }

    /// Returns the ends.
    #[must_use]
    pub fn ends(&self) -> [f64; 2] {
        [self.low, self.high]
    }

    /// Returns the distance between marks.
    #[must_use]
    pub fn step(&self) -> f64 {
        self.step
    }

    /// Returns the place of a value: 0 at the low end, 1 at the high one.
    #[must_use]
    pub fn share(&self, value: f64) -> f64 {
        (value - self.low) / (self.high - self.low)
    }

    /// Returns the marks from the low end to the high one.
    pub fn marks(&self) -> impl Iterator<Item = f64> + use<> {
        let Scale { low, high, step } = *self;
        let first = (low / step - 1e-6).ceil();
        (0..MOST_MARKS).map(move |k| (first + k as f64) * step).take_while(move |mark| *mark <= high + 1e-6 * step)
    }

    /// Formats a mark with the number of decimals that its distance to the next needs.
    #[must_use]
    pub fn label(&self, mark: f64) -> String {
        // The range of exponents of a double is small.
        let exponent = (self.step.log10() + 1e-9).floor() as i32;
        // No minus sign before a zero.
        let mark = if mark.abs() < self.step * 1e-6 { 0.0 } else { mark };
        let text = match exponent {
            ..=-5 | 7.. => format!("{mark:.1e}"),
            -4..=-1 => format!("{mark:.*}", exponent.unsigned_abs() as usize),
            _ => format!("{mark:.0}"),
        };
        text.replace('-', "\u{2212}")
    }
}

/// Returns the smallest of 1, 2, 5 times a power of ten that is not below `least`.
#[must_use]
pub fn round_step(least: f64) -> f64 {
    if !(least > 0.0 && least.is_finite()) {
        return 1.0;
    }
    let power = 10_f64.powf(least.log10().floor());
    let digit = [1.0, 2.0, 5.0].into_iter().find(|digit| digit * power >= least * (1.0 - 1e-9));
    digit.unwrap_or(10.0) * power
}

#[cfg(test)]
mod tests {
    use super::*;

    fn marks(values: &[f64], count: usize) -> Vec<String> {
        let scale = Scale::around(values.iter().copied(), count);
        scale.marks().map(|mark| scale.label(mark)).collect()
    }

    #[test]
    fn marks_are_round() {
        assert_eq!(marks(&[0.0, 700.0], 7), ["0", "100", "200", "300", "400", "500", "600", "700"]);
        assert_eq!(marks(&[-0.13, 0.42], 6), ["−0.2", "−0.1", "0.0", "0.1", "0.2", "0.3", "0.4", "0.5"]);
        assert_eq!(marks(&[1.0, 9.0], 4), ["0", "2", "4", "6", "8", "10"]);
        assert_eq!(marks(&[0.0, 0.023], 5), ["0.000", "0.005", "0.010", "0.015", "0.020", "0.025"]);
        assert_eq!(marks(&[], 2), ["0.0", "0.5", "1.0"]);
        assert_eq!(marks(&[3.0], 3), ["2.6", "2.8", "3.0", "3.2", "3.4"]);
    }

    #[test]
    fn hostile_values_end() {
        for values in [[f64::NAN, f64::INFINITY], [-f64::MAX, 1e300], [1e15, 1e15 + 1.0], [5e-324, 0.0], [1e-9, 2e-9]] {
            let scale = Scale::around(values, 5);
            let [low, high] = scale.ends();
            assert!(low < high && scale.step() > 0.0, "{values:?}: {scale:?}");
            assert!((2..=MOST_MARKS).contains(&scale.marks().count()), "{values:?}: {scale:?}");
            for value in values.into_iter().filter(|value| value.is_finite()) {
                let share = scale.share(value.clamp(-LARGEST, LARGEST));
                assert!((-1e-6..=1.0 + 1e-6).contains(&share), "{values:?}: {scale:?}");
            }
        }
        assert_eq!(Scale::balanced([-3.0, 1.0], 6).ends(), [-3.0, 3.0]);
    }
}
