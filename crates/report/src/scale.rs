//! Logarithmic axis of a plot.

/// Range from a positive value to a larger one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Log {
    low: f64,
    high: f64,
}

impl Log {
    pub(super) fn new(low: f64, high: f64) -> Log {
        Log { low, high }
    }

    /// Extends it to whole decades.
    pub(super) fn to_decades(self) -> Log {
        let low = 10_f64.powf(self.low.log10().floor());
        let high = 10_f64.powf(self.high.log10().ceil());
        Log { low, high: high.max(low * 10.0) }
    }

    /// Returns the place of a value, 0 at the low end and 1 at the high one; 0 for values that are not positive.
    pub(super) fn share(&self, value: f64) -> f64 {
        if value > 0.0 { ((value / self.low).ln() / (self.high / self.low).ln()).max(0.0) } else { 0.0 }
    }

    /// Returns the value at a place.
    pub(super) fn value(&self, share: f64) -> f64 {
        self.low * (self.high / self.low).powf(share)
    }

    /// Returns the power of ten whose place is within two others, including the first.
    pub(super) fn decade_in(&self, from: f64, to: f64) -> Option<f64> {
        self.decades().find(|&decade| (from - 1e-9..to - 1e-9).contains(&self.share(decade)))
    }

    /// Returns the powers of ten on the axis.
    pub(super) fn decades(&self) -> impl Iterator<Item = f64> + use<> {
        let Log { low, high } = *self;
        // The range of exponents of a double is small.
        let [first, last] = [low.log10().ceil(), high.log10().floor()].map(|exponent| exponent as i32);
        (first..=last)
            .map(|exponent| 10_f64.powi(exponent))
            .filter(move |decade| (low * (1.0 - 1e-9)..=high * (1.0 + 1e-9)).contains(decade))
    }

    /// Returns 1, 2, 5 times the powers of ten on the axis.
    pub(super) fn marks(&self) -> impl Iterator<Item = f64> + use<> {
        let Log { low, high } = *self;
        let [first, last] = [low, high].map(|value| value.log10().floor() as i32);
        let all = (first..=last).flat_map(|exponent| [1.0, 2.0, 5.0].map(|digit| digit * 10_f64.powi(exponent)));
        all.filter(move |mark| (low * (1.0 - 1e-9)..=high * (1.0 + 1e-9)).contains(mark))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn marks_lie_on_the_axis() {
        let axis = Log::new(0.5, 700.0);
        assert_eq!(axis.marks().collect::<Vec<_>>(), [0.5, 1.0, 2.0, 5.0, 10.0, 20.0, 50.0, 100.0, 200.0, 500.0]);
        assert_eq!(axis.decades().collect::<Vec<_>>(), [1.0, 10.0, 100.0]);
        assert!((axis.value(axis.share(20.0)) - 20.0).abs() < 1e-12);
        assert_eq!((axis.share(0.0), axis.share(-1.0), axis.share(700.0)), (0.0, 0.0, 1.0));
        let whole = Log::new(0.3, 45.0).to_decades();
        assert_eq!(whole.decades().count(), 4);
        assert!((whole.share(100.0) - 1.0).abs() < 1e-12);
    }
}
