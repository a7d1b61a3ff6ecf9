//! What is counted while set-points are answered.

use std::time::{Duration, Instant};

use super::cycle::{Answer, Cycle, Signals};
use super::histogram::LatencyHistogram;
use ncfix_base::geometry::AxisVector;

/// Set-points that were answered, by signals, and how long each took.
#[derive(Clone, Debug, Default)]
pub struct CycleCounts {
    /// Set-points.
    pub set_points: u64,
    /// Of them with each signal, in the order of [`Signals::NAMED`].
    pub by_signal: [u64; Signals::NAMED.len()],
    /// How long they took.
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

    /// Counts an answer that took `time`.
    pub fn note(&mut self, signals: Signals, time: Duration) {
        self.times.note(time);
        self.set_points += 1;
        for (count, (signal, _)) in self.by_signal.iter_mut().zip(Signals::NAMED) {
            *count += u64::from(signals.has(signal));
        }
    }
}
