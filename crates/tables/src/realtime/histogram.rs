//! Cycle times: counts in bins 3 % wide, without heap allocation.
//!
//! A separate implementation: `hdrhistogram` has bins of 6 % or 0.8 % on the heap. The bins of the printed table are 3 % wide, and recording a time
//! within the cycle is one shift and one addition.

use std::time::Duration;

/// Bins per doubling of the time.
const PER_DOUBLING: usize = 32;
/// Doublings of [`PER_DOUBLING`] ns: up to 18 min.
const DOUBLINGS: usize = 36;

/// Counts of times. Recording a time does not allocate.
#[derive(Clone, Debug)]
pub struct LatencyHistogram {
    counts: [u64; PER_DOUBLING * DOUBLINGS],
    total: u64,
    max_ns: u64,
}

impl Default for LatencyHistogram {
    fn default() -> Self {
        LatencyHistogram { counts: [0; PER_DOUBLING * DOUBLINGS], total: 0, max_ns: 0 }
    }
}

impl LatencyHistogram {
    /// Records a time.
    pub fn note(&mut self, time: Duration) {
        let ns = u64::try_from(time.as_nanos()).unwrap_or(u64::MAX);
        self.max_ns = self.max_ns.max(ns);
        self.total += 1;
        if let Some(count) = self.counts.get_mut(class_of(ns).min(PER_DOUBLING * DOUBLINGS - 1)) {
            *count += 1;
        }
    }

    /// Number of recorded times.
    #[must_use]
    pub fn total(&self) -> u64 {
        self.total
    }

    /// The longest time, ns.
    #[must_use]
    pub fn max_ns(&self) -> u64 {
        self.max_ns
    }

    /// A quantile of the times, ns: the upper end of its bin, at most the longest time. 0 without any.
    #[must_use]
    pub fn quantile_ns(&self, share: f64) -> u64 {
        let wanted = (share * self.total as f64).ceil().max(1.0) as u64;
        let mut passed = 0;
        for (class, count) in self.counts.iter().enumerate() {
            passed += count;
            if passed >= wanted {
                return start_of(class + 1).saturating_sub(1).min(self.max_ns);
            }
        }
        self.max_ns
    }

    /// The non-empty bins: lower limit, upper limit (exclusive), ns, and count.
    pub fn classes(&self) -> impl Iterator<Item = (u64, u64, u64)> {
        let counted = self.counts.iter().enumerate().filter(|(_, count)| **count > 0);
        counted.map(|(class, &count)| (start_of(class), start_of(class + 1), count))
    }
}

/// The first [`PER_DOUBLING`] bins are single nanoseconds.
fn class_of(ns: u64) -> usize {
    let base = PER_DOUBLING.trailing_zeros();
    let doubling = (63 - (ns | 1).leading_zeros()).saturating_sub(base - 1);
    if doubling == 0 {
        return ns as usize;
    }
    let shift = doubling - 1;
    // Between PER_DOUBLING and twice that.
    let within = (ns >> shift) as usize;
    shift as usize * PER_DOUBLING + within
}

/// Lower limit of a bin, ns.
fn start_of(class: usize) -> u64 {
    if class < 2 * PER_DOUBLING {
        return class as u64;
    }
    let shift = class / PER_DOUBLING - 1;
    ((class % PER_DOUBLING + PER_DOUBLING) as u64) << shift
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_time_lies_in_its_class() {
        for ns in (0..5000).chain([9999, 123_456, 1_000_000_007, 700_000_000_000]) {
            let class = class_of(ns);
            assert!((start_of(class)..start_of(class + 1)).contains(&ns), "{ns} in {class}");
            assert!(start_of(class + 1) - start_of(class) <= 1 + ns / 32, "{ns}");
        }
    }

    #[test]
    fn quantiles_count() {
        let mut histogram = LatencyHistogram::default();
        assert_eq!(histogram.quantile_ns(0.5), 0);
        (1..=1000).for_each(|ns| histogram.note(Duration::from_nanos(ns)));
        for (share, exact) in [(0.01, 10), (0.5, 500), (0.999, 999), (1.0, 1000)] {
            let found = histogram.quantile_ns(share);
            assert!((exact..=exact + 1 + exact / 32).contains(&found), "{share}: {found}");
        }
        assert_eq!((histogram.total(), histogram.max_ns()), (1000, 1000));
        histogram.note(Duration::from_secs(1_000_000));
        assert_eq!(histogram.classes().map(|class| class.2).sum::<u64>(), 1001);
    }
}
