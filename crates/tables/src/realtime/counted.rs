//! Statistics of answered set-points.

use std::time::{Duration, Instant};

use super::cycle::{Answer, Cycle, Signals};
use super::histogram::LatencyHistogram;
use ncfix_base::geometry::AxisVector;

/// Answered set-points by status bits, and their durations.
#[derive(Clone, Debug, Default)]
pub struct CycleCounts {
    /// Number of set-points.
    pub set_points: u64,
    /// Number of set-points with each status bit, in the order of [`Signals::NAMED`].
    pub by_signal: [u64; Signals::NAMED.len()],
    /// Durations.
    pub times: Box<LatencyHistogram>,
}

impl CycleCounts {
    /// Answers a set-point and counts it.
    pub fn step(&mut self, cycle: &mut Cycle, set_point: &AxisVector) -> Answer {
        let start = Instant::now();
        let answer = cycle.step(set_point);
        self.note(answer.signals, start.elapsed());
        answer
    }

    /// Counts an answer with the duration `time`.
    pub fn note(&mut self, signals: Signals, time: Duration) {
        self.times.note(time);
        self.set_points += 1;
        for (count, (signal, _)) in self.by_signal.iter_mut().zip(Signals::NAMED) {
            *count += u64::from(signals.has(signal));
        }
    }
}
