//! Duration statistics in bounded memory: a histogram whose bins are a twelfth of a power of two wide.

use std::time::Duration;

/// Columns of a power of two.
const PER_OCTAVE: f64 = 12.0;
/// From 10 ns to 43 s.
const COLUMNS: usize = 32 * 12;
const FIRST_S: f64 = 1e-8;

/// Durations.
#[derive(Clone, Debug)]
pub(super) struct Meter {
    columns: Vec<u64>,
    count: u64,
    longest: Duration,
}

impl Meter {
    pub(super) fn new() -> Meter {
        Meter { columns: vec![0; COLUMNS], count: 0, longest: Duration::ZERO }
    }

    /// Adds one.
    pub(super) fn add(&mut self, duration: Duration) {
        let place = (duration.as_secs_f64().max(FIRST_S) / FIRST_S).log2() * PER_OCTAVE;
        let last = COLUMNS - 1;
        if let Some(column) = self.columns.get_mut((place as usize).min(last)) {
            *column += 1;
        }
        self.count += 1;
        self.longest = self.longest.max(duration);
    }

    /// The median, the 99 % quantile and the maximum, µs; `None` without a duration.
    pub(super) fn microseconds(&self) -> Option<[f64; 3]> {
        let us = |seconds: f64| (seconds * 1e7).round() / 10.0;
        let longest = self.longest.as_secs_f64();
        let below = |share: f64| {
            let wanted = (share * self.count as f64).ceil() as u64;
            let mut sum = 0;
            let column = self.columns.iter().position(|count| {
                sum += count;
                sum >= wanted
            });
            let end = column.map_or(longest, |column| FIRST_S * ((column + 1) as f64 / PER_OCTAVE).exp2());
            us(end.min(longest))
        };
        (self.count > 0).then(|| [below(0.5), below(0.99), us(longest)])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shares_are_right_within_a_column() {
        let mut meter = Meter::new();
        assert_eq!(meter.microseconds(), None);
        (1..=1000).for_each(|us| meter.add(Duration::from_micros(us)));
        let [middle, most, longest] = meter.microseconds().unwrap();
        assert!((500.0..530.0).contains(&middle) && (990.0..1000.1).contains(&most), "{middle} {most}");
        assert!((longest - 1000.0).abs() < 1e-9);
    }
}
