//! Faults of sensors that a display has shown: each is shown once, however often it comes and goes.

use std::collections::BTreeSet;

/// Limit of the different sensor faults that are shown.
const MOST_FAULTS: usize = 100;

/// The faults that were shown.
#[derive(Debug, Default)]
pub(crate) struct ShownFaults {
    seen: BTreeSet<String>,
    /// True if the last one was shown, and the sensors are not good again.
    is_open: bool,
}

impl ShownFaults {
    /// Takes a reason for which the correction is frozen, and returns the sentence to show if its kind is new.
    pub(crate) fn frozen(&mut self, why: &str) -> Option<String> {
        // The name of the sensor and the kind of its fault, without the duration and the values.
        let (sensor, rest) = why.split_once(" has no good value").unwrap_or((why, ""));
        let kind = rest.split_once(": ").map_or(rest, |(_, kind)| kind);
        let fault = format!("{sensor}: {}", kind.replace(|character: char| character.is_ascii_digit(), ""));
        let is_new = self.seen.len() < MOST_FAULTS && self.seen.insert(fault);
        self.is_open |= is_new;
        is_new.then(|| format!("sensor readings are doubtful, the correction is frozen: {why}"))
    }

    /// Returns the sentence to show if the sensors are good again after a fault that was shown.
    pub(crate) fn thawed(&mut self) -> Option<String> {
        std::mem::take(&mut self.is_open)
            .then(|| "the sensors are good again; if this fault returns, it is counted and reported at the end".into())
    }
}
