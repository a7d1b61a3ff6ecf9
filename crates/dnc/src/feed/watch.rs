//! How long a transfer may stand still: nothing waits for ever, whatever the control says meanwhile.

use std::collections::VecDeque;
use std::time::Duration;

use super::dialogue::Event;

/// With the override of the feed at a tenth everything takes so much longer.
const SLOWEST: u32 = 10;
/// The last lines, whose moves may still be waited for: more than most controls hold.
const RECENT: usize = 128;

/// How long a transfer may stand still.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Patience {
    /// Without a line that is answered or carried out, beyond ten times what the lines take.
    pub stall: Duration,
    /// While somebody holds it at the control, or before it takes the first line.
    pub hold: Duration,
}

impl Default for Patience {
    fn default() -> Patience {
        Patience { stall: Duration::from_secs(300), hold: Duration::from_secs(3600) }
    }
}

/// Watches over a transfer.
#[derive(Debug, Default)]
pub(super) struct Watch {
    patience: Patience,
    /// When a line was answered, carried out or had left last.
    moved: Duration,
    /// How long it was held since then, all holds together, and since when it is held now.
    was_held: Duration,
    held: Option<Duration>,
    /// How long the last lines take.
    recent: VecDeque<Duration>,
}

impl Watch {
    pub(super) fn new(patience: Patience) -> Watch {
        Watch { patience, ..Watch::default() }
    }

    /// A line was sent that takes so long.
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
            // That it was let go on is no progress: a control that says so again and again moves nothing.
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

    /// Whether somebody holds it.
    pub(super) fn is_held(&self) -> bool {
        self.held.is_some()
    }

    /// Why a transfer that waits for the control must not go on; `is_open` where this takes lines, `is_ending` where no further one comes.
    pub(super) fn look(&self, now: Duration, is_open: bool, is_ending: bool) -> Option<String> {
        let busy =
            if is_ending { self.recent.iter().sum() } else { self.recent.iter().max().copied().unwrap_or_default() };
        let held = self.was_held + self.held.map_or(Duration::ZERO, |since| now.saturating_sub(since));
        let stood = now.saturating_sub(self.moved).saturating_sub(held);
        let (limit, what) = if is_open || is_ending {
            (self.patience.stall + busy * SLOWEST, "no line was answered or carried out")
        } else {
            (self.patience.hold, "the control has not become ready for lines")
        };
        let ended = |what: &str, time: Duration| Some(format!("{what} for {} s: nothing more is sent", time.as_secs()));
        if held > self.patience.hold {
            ended("somebody has held the control, or it stands with its buffer full,", held)
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

    fn watch() -> Watch {
        Watch::new(Patience { stall: 60 * SECOND, hold: 600 * SECOND })
    }

    #[test]
    fn a_line_may_take_ten_times_as_long_and_no_longer() {
        let mut watch = watch();
        watch.sent(5 * SECOND, true, SECOND);
        assert_eq!(watch.look(111 * SECOND, true, false), None);
        assert!(watch.look(112 * SECOND, true, false).is_some_and(|why| why.contains("111 s")));
        watch.note(&Event::Acknowledged(1), 100 * SECOND);
        assert_eq!(watch.look(112 * SECOND, true, false), None);
        // The longest line takes 20 s; behind the last one all that it has may still be moving.
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
        assert!(watch.look(611 * SECOND, true, false).is_some_and(|why| why.contains("held")));
        // It was let go on in time; what it stood before the hold counts with what it stands behind it: 10 s and 50 s.
        watch.note(&Event::Paused(false), 610 * SECOND);
        assert_eq!(watch.look(660 * SECOND, true, false), None);
        assert!(watch.look(661 * SECOND, true, false).is_some_and(|why| why.contains("no line")));
        // Holds add up as long as no line is answered between them: 10 s of every 20, 601 s of 1201.
        let mut watch = Watch::new(Patience { stall: 6000 * SECOND, hold: 600 * SECOND });
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
        // Before the first line somebody may have to press a key.
        assert_eq!(Watch::new(Patience::default()).look(3600 * SECOND, false, false), None);
        assert!(Watch::new(Patience::default()).look(3601 * SECOND, false, false).is_some());
    }
}
