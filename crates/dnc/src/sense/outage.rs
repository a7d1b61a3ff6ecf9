//! Outages of a channel that comes and goes: their number, and the times of the first and of the last one.

use std::time::Duration;

use super::monitor::ChannelState;

/// Outages of one channel. Times count from the start of the job.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct SensorOutages {
    /// Number of times that a good channel lost its value.
    pub count: u64,
    /// Start of the first outage.
    pub first: Duration,
    /// End of the last one, or the current time while it lasts.
    pub last: Duration,
    is_out: bool,
    was_good: bool,
}

impl SensorOutages {
    /// Notes the state of the channel. A channel that had no good value yet has no outage.
    pub(super) fn note(&mut self, state: ChannelState, now: Duration) {
        match state {
            ChannelState::Good => (self.was_good, self.is_out) = (true, false),
            ChannelState::Held(_) if self.was_good => {
                if !std::mem::replace(&mut self.is_out, true) {
                    if self.count == 0 {
                        self.first = now;
                    }
                    self.count += 1;
                }
                self.last = now;
            }
            ChannelState::Held(_) | ChannelState::Waiting => {}
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::monitor::ChannelFault;
    use super::*;

    #[test]
    fn an_outage_counts_once_however_long_it_lasts() {
        let mut outages = SensorOutages::default();
        let held = ChannelState::Held(ChannelFault::Silent);
        let states = [ChannelState::Waiting, held, ChannelState::Good, held, held, ChannelState::Good, held];
        for (second, state) in (0..).zip(states) {
            outages.note(state, Duration::from_secs(second));
        }
        assert_eq!((outages.count, outages.first.as_secs(), outages.last.as_secs()), (2, 3, 6));
    }
}
