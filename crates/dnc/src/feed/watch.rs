//! Limits the time that a transfer may make no progress: nothing waits forever, even if the control sends data meanwhile.

use std::collections::VecDeque;
use std::time::Duration;

use super::dialogue::Event;

/// Factor on all durations at a feed override of 10 %.
const SLOWEST: u32 = 10;
/// Number of last lines whose moves may not have ended yet: more than most controls hold.
const RECENT: usize = 128;

/// Maximum times without progress.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Patience {
    /// Maximum time without an answered or executed line, in addition to ten times the duration of the lines.
    pub stall: Duration,
    /// Maximum time while a person holds the control, or before it takes the first line.
    pub hold: Duration,
}

impl Default for Patience {
    fn default() -> Patience {
        Patience { stall: Duration::from_secs(300), hold: Duration::from_secs(3600) }
    }
}

/// Monitors the progress of a transfer.
#[derive(Debug, Default)]
pub(super) struct TransferWatch {
    patience: Patience,
    /// Time when a line was last answered, executed or left.
    moved: Duration,
    /// Total time of all holds since then, and start of the current hold.
    was_held: Duration,
    held: Option<Duration>,
    /// Durations of the last lines.
    recent: VecDeque<Duration>,
}

impl TransferWatch {
    pub(super) fn new(patience: Patience) -> TransferWatch {
        TransferWatch { patience, ..TransferWatch::default() }
    }

    /// Notes a line that was sent, with its duration.
    pub(super) fn sent(&mut self, busy: Duration, is_first: bool, now: Duration) {
        if is_first {
            self.progress(now);
        }
        self.recent.push_back(busy);
        if self.recent.len() > RECENT {
            self.recent.pop_front();
        }
    }

    pub(super) fn note(&mut self, event: &Event, now: Duration) {
        match event {
            Event::Acknowledged(_) | Event::Executed(_) | Event::Left(_) => self.progress(now),
            Event::Paused(true) => _ = self.held.get_or_insert(now),
            // A resume is not progress: a control that repeats it moves nothing.
            Event::Paused(false) => {
                if let Some(since) = self.held.take() {
                    self.was_held += now.saturating_sub(since);
                }
            }
            _ => {}
        }
    }

    fn progress(&mut self, now: Duration) {
        (self.moved, self.was_held) = (now, Duration::ZERO);
        self.held = self.held.map(|_| now);
    }

    /// True if a person holds it.
    pub(super) fn is_held(&self) -> bool {
        self.held.is_some()
    }

    /// Returns why a transfer that waits for the control must end. `is_open` if the control takes lines, `is_ending` if no further line follows.
    pub(super) fn look(&self, now: Duration, is_open: bool, is_ending: bool) -> Option<String> {
        let busy =
            if is_ending { self.recent.iter().sum() } else { self.recent.iter().max().copied().unwrap_or_default() };
        let held = self.was_held + self.held.map_or(Duration::ZERO, |since| now.saturating_sub(since));
        let stood = now.saturating_sub(self.moved).saturating_sub(held);
        let (limit, what) = if is_open || is_ending {
            (self.patience.stall + busy * SLOWEST, "no line was answered or executed")
        } else {
            (self.patience.hold, "the control has not become ready for lines")
        };
        let ended = |what: &str, time: Duration| Some(format!("{what} for {} s: nothing more is sent", time.as_secs()));
        if held > self.patience.hold {
            ended("the control is in hold, or its buffer stays full,", held)
        } else if stood > limit {
            ended(what, stood)
        } else {
            None
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SECOND: Duration = Duration::from_secs(1);

    fn watch() -> TransferWatch {
        TransferWatch::new(Patience { stall: 60 * SECOND, hold: 600 * SECOND })
    }

    #[test]
    fn a_line_may_take_ten_times_as_long_and_no_longer() {
        let mut watch = watch();
        watch.sent(5 * SECOND, true, SECOND);
        assert_eq!(watch.look(111 * SECOND, true, false), None);
        assert!(watch.look(112 * SECOND, true, false).is_some_and(|why| why.contains("111 s")));
        watch.note(&Event::Acknowledged(1), 100 * SECOND);
        assert_eq!(watch.look(112 * SECOND, true, false), None);
        // The longest line takes 20 s; after the last line all lines in the control may still be moving.
        watch.sent(20 * SECOND, false, 100 * SECOND);
        assert_eq!(watch.look(360 * SECOND, true, false), None);
        assert!(watch.look(361 * SECOND, true, false).is_some());
        assert_eq!(watch.look(410 * SECOND, false, true), None);
        assert!(watch.look(411 * SECOND, false, true).is_some());
    }

    #[test]
    fn a_hold_has_a_limit_of_its_own() {
        let mut watch = watch();
        watch.note(&Event::Paused(true), 10 * SECOND);
        watch.note(&Event::Paused(true), 20 * SECOND);
        assert_eq!(watch.look(610 * SECOND, true, false), None);
        assert!(watch.look(611 * SECOND, true, false).is_some_and(|why| why.contains("in hold")));
        // It was resumed in time. The time before the hold and the time after it count together: 10 s and 50 s.
        watch.note(&Event::Paused(false), 610 * SECOND);
        assert_eq!(watch.look(660 * SECOND, true, false), None);
        assert!(watch.look(661 * SECOND, true, false).is_some_and(|why| why.contains("no line")));
        // Holds add up while no line is answered between them: 10 s of every 20, 601 s of 1201.
        let mut watch = TransferWatch::new(Patience { stall: 6000 * SECOND, hold: 600 * SECOND });
        for second in (0..1200).step_by(20) {
            watch.note(&Event::Paused(true), second * SECOND);
            assert_eq!(watch.look((second + 9) * SECOND, true, false), None);
            watch.note(&Event::Paused(false), (second + 10) * SECOND);
        }
        watch.note(&Event::Paused(true), 1200 * SECOND);
        assert!(watch.look(1201 * SECOND, true, false).is_some_and(|why| why.contains("601 s")));
        watch.note(&Event::Acknowledged(1), 1201 * SECOND);
        assert_eq!(watch.look(1801 * SECOND, true, false), None);
        assert!(watch.look(1802 * SECOND, true, false).is_some());
        // Before the first line a person may have to press a key.
        assert_eq!(TransferWatch::new(Patience::default()).look(3600 * SECOND, false, false), None);
        assert!(TransferWatch::new(Patience::default()).look(3601 * SECOND, false, false).is_some());
    }
}
