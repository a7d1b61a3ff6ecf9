//! Bounded queue for the readings of a source; no one waits for it.

use std::collections::VecDeque;
use std::sync::{Arc, Condvar, Mutex, PoisonError, TryLockError};
use std::time::{Duration, Instant, SystemTime};

use super::monitor::{ChannelFault, SourceReport};

/// Maximum number of waiting readings; if there are more, the oldest are lost.
const MOST_WAITING: usize = 4096;
/// Permitted difference between the clocks of two computers.
const CLOCKS_DIFFER: Duration = Duration::from_secs(60);

/// Reading on its way.
#[derive(Clone, Debug)]
pub(super) struct SourceSample {
    pub(super) channel: usize,
    pub(super) told: SourceReport,
    /// Time of arrival.
    came: Instant,
    /// Age at arrival.
    age: Duration,
}

impl SourceSample {
    /// Returns the time since it was read.
    pub(super) fn age(&self) -> Duration {
        self.came.elapsed() + self.age
    }
}

#[derive(Debug, Default)]
struct Shared {
    waiting: Mutex<VecDeque<SourceSample>>,
    is_over: Mutex<bool>,
    ends: Condvar,
}

/// Sending end, held by a source.
#[derive(Debug)]
pub struct ReadingOutlet {
    shared: Arc<Shared>,
    channels: Vec<usize>,
}

/// Receiving end, held by the panel. When it is dropped, the source must end.
#[derive(Debug)]
pub(super) struct Inlet(Arc<Shared>);

/// Creates a queue and returns both ends.
pub(super) fn box_of(channels: &[usize]) -> (ReadingOutlet, Inlet) {
    let shared = Arc::new(Shared::default());
    (ReadingOutlet { shared: Arc::clone(&shared), channels: channels.to_vec() }, Inlet(shared))
}

/// Returns a report after checking its time stamp, and its age.
#[must_use]
pub(super) fn aged(told: SourceReport, stamp: Option<SystemTime>, now: SystemTime) -> (SourceReport, Duration) {
    let Some(stamp) = stamp else { return (told, Duration::ZERO) };
    match (now.duration_since(stamp), &told) {
        (Ok(age), _) => (told, age),
        (Err(ahead), SourceReport::Value(_)) if ahead.duration() > CLOCKS_DIFFER => {
            // Such a value would never grow old.
            let why = format!("its time is {:.0} s in the future; compare the clocks", ahead.duration().as_secs_f64());
            (SourceReport::Nothing(ChannelFault::Clock, why), Duration::ZERO)
        }
        (Err(_), _) => (told, Duration::ZERO),
    }
}

impl ReadingOutlet {
    /// Passes a reading on. `stamp` is the time when it was read; `None` means now.
    pub fn tell(&self, channel: usize, told: SourceReport, stamp: Option<SystemTime>) {
        let (told, age) = aged(told, stamp, SystemTime::now());
        let mut waiting = self.shared.waiting.lock().unwrap_or_else(PoisonError::into_inner);
        if waiting.len() >= MOST_WAITING {
            waiting.pop_front();
        }
        waiting.push_back(SourceSample { channel, told, came: Instant::now(), age });
    }

    /// Reports that none of the channels has a value, with the reason.
    pub fn fail(&self, fault: ChannelFault, why: &str) {
        for &channel in &self.channels {
            self.tell(channel, SourceReport::Nothing(fault, why.to_owned()), None);
        }
    }

    /// Waits; returns `false` if the source must end.
    #[must_use]
    pub fn wait(&self, time: Duration) -> bool {
        let is_over = self.shared.is_over.lock().unwrap_or_else(PoisonError::into_inner);
        let waited = self.shared.ends.wait_timeout_while(is_over, time, |is_over| !*is_over);
        !*waited.unwrap_or_else(PoisonError::into_inner).0
    }

    /// True if the source must end.
    #[must_use]
    pub fn is_over(&self) -> bool {
        *self.shared.is_over.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Inlet {
    /// Takes the waiting readings; none if the source is writing at this instant.
    pub(super) fn take(&self, into: &mut Vec<SourceSample>) {
        match self.0.waiting.try_lock() {
            Ok(mut waiting) => into.extend(waiting.drain(..)),
            Err(TryLockError::Poisoned(poisoned)) => into.extend(poisoned.into_inner().drain(..)),
            Err(TryLockError::WouldBlock) => {}
        }
    }
}

impl Drop for Inlet {
    fn drop(&mut self) {
        *self.0.is_over.lock().unwrap_or_else(PoisonError::into_inner) = true;
        self.0.ends.notify_all();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_box_is_bounded_and_keeps_the_newest() {
        let (outlet, inlet) = box_of(&[0]);
        for value in 0..MOST_WAITING + 10 {
            outlet.tell(0, SourceReport::Value(value as f64), None);
        }
        let mut samples = Vec::new();
        inlet.take(&mut samples);
        assert_eq!(samples.len(), MOST_WAITING);
        assert_eq!(samples.last().unwrap().told, SourceReport::Value((MOST_WAITING + 9) as f64));
        assert!(outlet.wait(Duration::ZERO));
        drop(inlet);
        assert!(!outlet.wait(Duration::from_secs(60)) && outlet.is_over());
    }

    #[test]
    fn a_reading_of_the_future_is_none() {
        let now = SystemTime::UNIX_EPOCH + Duration::from_secs(2_000_000_000);
        let value = || SourceReport::Value(21.0);
        assert_eq!(aged(value(), None, now), (value(), Duration::ZERO));
        let second = Duration::from_secs(1);
        assert_eq!(aged(value(), Some(now - 90 * second), now), (value(), 90 * second));
        assert_eq!(aged(value(), Some(now + 30 * second), now), (value(), Duration::ZERO));
        assert!(matches!(
            aged(value(), Some(now + 3600 * second), now).0,
            SourceReport::Nothing(ChannelFault::Clock, _)
        ));
    }
}
