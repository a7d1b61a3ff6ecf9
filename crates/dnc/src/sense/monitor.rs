//! Plausibility check of a channel: a state machine with values and times as input, and the last good value as output.
//!
//! A value is accepted if it is a number, within the range, and close enough to the values before it: the temperature of an iron mass changes at a limited
//! rate. Any other value is held back until several agree with each other *and* the rate permits the change since the last good value. So an intermittent
//! fault has no effect, and a real change that was missed is accepted in the end.

use std::collections::VecDeque;
use std::fmt;
use std::time::Duration;

use super::config::SensorChannel;

/// Number of earlier values for comparison. They are spaced by a thirtieth of their time span.
const ANCHORS: usize = 30;

/// Reason why a channel has no good value now.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ChannelFault {
    /// No value has come for too long, or the value that came is too old.
    Silent,
    /// The value is outside the range of the channel.
    OutOfRange,
    /// The value differs from the last one by more than the rate allows.
    Jump,
    /// The value has not changed at all for too long.
    Stuck,
    /// It is not a number, or a number by which the sensor reports that it has no value.
    Invalid,
    /// The source cannot be reached, or has ended.
    Disconnected,
    /// It was retained by a broker, and its age is unknown.
    Retained,
    /// Its time stamp is in the future.
    Clock,
}

impl ChannelFault {
    /// Returns its name as in JSON.
    #[must_use]
    pub fn word(self) -> &'static str {
        match self {
            ChannelFault::Silent => "silent",
            ChannelFault::OutOfRange => "out_of_range",
            ChannelFault::Jump => "jump",
            ChannelFault::Stuck => "stuck",
            ChannelFault::Invalid => "invalid",
            ChannelFault::Disconnected => "disconnected",
            ChannelFault::Retained => "retained",
            ChannelFault::Clock => "clock",
        }
    }
}

impl fmt::Display for ChannelFault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            ChannelFault::Silent => "silent",
            ChannelFault::OutOfRange => "out of range",
            ChannelFault::Jump => "jump",
            ChannelFault::Stuck => "stuck",
            ChannelFault::Invalid => "no value",
            ChannelFault::Disconnected => "disconnected",
            ChannelFault::Retained => "retained",
            ChannelFault::Clock => "clock",
        })
    }
}

/// Report of a source on a channel.
#[derive(Clone, Debug, PartialEq)]
pub enum SourceReport {
    /// Number as delivered by the sensor.
    Value(f64),
    /// No value, with the reason.
    Nothing(ChannelFault, String),
}

/// Reliability of a channel.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ChannelState {
    /// There was no good value yet.
    #[default]
    Waiting,
    /// The value is good and recent.
    Good,
    /// The value is the last good one; the fault is why there is no newer one.
    Held(ChannelFault),
}

impl ChannelState {
    /// Returns its name as in JSON.
    #[must_use]
    pub fn word(self) -> &'static str {
        match self {
            ChannelState::Waiting => "waiting",
            ChannelState::Good => "good",
            ChannelState::Held(_) => "held",
        }
    }
}

/// Current state of a channel.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ChannelReading {
    /// Name of the sensor.
    pub name: String,
    /// The last good value, filtered, °C; `None` before the first one.
    pub value_c: Option<f64>,
    /// Age of the last good value.
    pub age: Option<Duration>,
    /// Reliability of the value.
    pub state: ChannelState,
    /// Last raw number, good or not.
    pub raw: Option<f64>,
    /// Description of the fault, as a sentence; empty if there is none.
    pub note: String,
}

/// First answer of a channel, before enough values agree.
#[derive(Clone, Debug, PartialEq)]
pub enum FirstAnswer {
    /// Its source has not reported anything yet.
    Waiting,
    /// Value, °C, that contradicts no limit of the channel.
    Value(f64),
    /// A fault, as a sentence.
    Fault(String),
}

/// Plausibility check of one channel. Times are seconds since the start of the job; earlier times are negative.
#[derive(Clone, Debug)]
pub struct Monitor {
    channel: SensorChannel,
    /// Last good values for the median, °C.
    recent: VecDeque<f64>,
    /// Thinned good values of the recent past: time, s, and value, °C.
    anchors: VecDeque<(f64, f64)>,
    /// Values that do not follow from the good ones.
    candidates: VecDeque<(f64, f64)>,
    /// Time and value of the last good reading.
    good: Option<(f64, f64)>,
    value_c: Option<f64>,
    /// Time when the newest number was read, good or not.
    newest_s: f64,
    /// Start time and value of the current run of equal readings.
    same: Option<(f64, f64)>,
    fault: Option<ChannelFault>,
    note: String,
    /// Time since when there is no good value.
    bad_since_s: Option<f64>,
    raw: Option<f64>,
}

impl Monitor {
    /// Creates a monitor without any value.
    #[must_use]
    pub fn new(channel: &SensorChannel) -> Monitor {
        Monitor {
            channel: channel.clone(),
            recent: VecDeque::new(),
            anchors: VecDeque::new(),
            candidates: VecDeque::new(),
            good: None,
            value_c: None,
            newest_s: f64::NEG_INFINITY,
            same: None,
            fault: None,
            note: String::new(),
            bad_since_s: None,
            raw: None,
        }
    }

    /// Returns its channel.
    #[must_use]
    pub fn channel(&self) -> &SensorChannel {
        &self.channel
    }

    /// Takes a report that was read `age` before `now`.
    pub fn hear(&mut self, told: &SourceReport, age: Duration, now: Duration) {
        let now_s = now.as_secs_f64();
        let result = match told {
            SourceReport::Value(raw) => self.judge(*raw, age, now_s - age.as_secs_f64()),
            SourceReport::Nothing(fault, why) => Err((Some(*fault), why.clone())),
        };
        match result {
            Ok(()) => {
                self.note.clear();
                self.fault = None;
                self.bad_since_s = None;
            }
            Err((fault, note)) => {
                self.note = note;
                self.fault = fault.or(self.fault);
                self.bad_since_s.get_or_insert(now_s);
            }
        }
    }

    /// Handles the passing of time.
    pub fn tick(&mut self, now: Duration) {
        let now_s = now.as_secs_f64();
        let Some((good_s, _)) = self.good else {
            self.bad_since_s.get_or_insert(now_s);
            return;
        };
        let most_s = self.channel.max_age.as_secs_f64();
        if self.fault.is_none() && now_s - good_s > most_s {
            self.fault = Some(ChannelFault::Silent);
            self.note = format!("nothing for more than {most_s} s");
            // Time when it became too old, not when that was noticed: the result must not depend on the polling.
            self.bad_since_s.get_or_insert(good_s + most_s);
        }
    }

    /// Returns the time without a good value.
    #[must_use]
    pub fn bad_for(&self, now: Duration) -> Option<Duration> {
        let since_s = self.bad_since_s?;
        Duration::try_from_secs_f64(now.as_secs_f64() - since_s).ok()
    }

    /// Returns what the source has reported first: a value counts before `confirm` values agree.
    #[must_use]
    pub fn first_answer(&self) -> FirstAnswer {
        match (self.fault, self.raw) {
            (Some(_), _) => FirstAnswer::Fault(self.note.clone()),
            (None, Some(raw)) => FirstAnswer::Value(self.value_c.unwrap_or_else(|| self.channel.to_c(raw))),
            (None, None) => FirstAnswer::Waiting,
        }
    }

    /// Returns the reliability.
    #[must_use]
    pub fn state(&self) -> ChannelState {
        match (self.good, self.fault) {
            (None, _) => ChannelState::Waiting,
            (Some(_), None) => ChannelState::Good,
            (Some(_), Some(fault)) => ChannelState::Held(fault),
        }
    }

    /// Writes the state into a reading. Returns true if the value has changed.
    pub fn show(&self, now: Duration, reading: &mut ChannelReading) -> bool {
        let has_changed = reading.value_c != self.value_c;
        let age_s = self.good.map(|(at_s, _)| (now.as_secs_f64() - at_s).max(0.0));
        reading.value_c = self.value_c;
        reading.age = age_s.and_then(|age_s| Duration::try_from_secs_f64(age_s).ok());
        reading.state = self.state();
        reading.raw = self.raw;
        if reading.note != self.note {
            reading.note.clone_from(&self.note);
        }
        has_changed
    }

    /// Accepts a number, or returns the reason. A reason without a fault means that the number is ignored and nothing is wrong.
    fn judge(&mut self, raw: f64, age: Duration, at_s: f64) -> Result<(), (Option<ChannelFault>, String)> {
        let channel = &self.channel;
        let no = |fault, note: String| Err((Some(fault), note));
        if !raw.is_finite() {
            return no(ChannelFault::Invalid, "the sensor does not give a number".into());
        }
        self.raw = Some(raw);
        let value_c = channel.to_c(raw);
        if channel.is_invalid(raw, value_c) {
            return no(ChannelFault::Invalid, format!("{raw} is the sensor's code for no value"));
        }
        if age > channel.max_age {
            return no(ChannelFault::Silent, format!("the reading is {:.0} s old", age.as_secs_f64()));
        }
        let [low, high] = channel.range_c;
        if !(low..=high).contains(&value_c) {
            return no(ChannelFault::OutOfRange, format!("{value_c:.1} °C is not within {low} to {high} °C"));
        }
        if at_s <= self.newest_s {
            // A repeated or overtaken reading: nothing new is known, and the old value grows older.
            return if self.fault.is_some() || self.good.is_none() {
                Err((None, std::mem::take(&mut self.note)))
            } else {
                Ok(())
            };
        }
        self.newest_s = at_s;
        if self.follows(at_s, value_c) {
            self.candidates.clear();
            self.accept(at_s, value_c);
            return self.check_motion(at_s, raw);
        }
        self.confirm(at_s, value_c)?;
        self.same = Some((at_s, raw));
        Ok(())
    }

    /// True if a value may follow the good ones immediately.
    fn follows(&self, at_s: f64, value_c: f64) -> bool {
        // Maximum time between two readings that counts: after a long silence a single value is no proof.
        let most_s = self.steady_s();
        self.good.iter().chain(&self.anchors).all(|&earlier| self.is_possible(earlier, (at_s, value_c), most_s))
            && self.good.is_some()
    }

    /// True if the rate permits the change between two values. At most `most_s` of the time between them counts.
    fn is_possible(&self, (from_s, from_c): (f64, f64), (to_s, to_c): (f64, f64), most_s: f64) -> bool {
        let minutes = (to_s - from_s).clamp(0.0, most_s) / 60.0;
        (to_c - from_c).abs() <= self.channel.step_k + self.channel.max_rate_k_per_min * minutes
    }

    /// Returns a third of the maximum age of a value, s.
    fn steady_s(&self) -> f64 {
        self.channel.max_age.as_secs_f64() / 3.0
    }

    /// Holds a value that does not follow from the good ones until others agree.
    fn confirm(&mut self, at_s: f64, value_c: f64) -> Result<(), (Option<ChannelFault>, String)> {
        let is_first = self.good.is_none();
        let wanted = if is_first { self.channel.first } else { self.channel.confirm }.max(1);
        let most_s = self.steady_s();
        if !self.candidates.iter().all(|&earlier| self.is_possible(earlier, (at_s, value_c), most_s)) {
            self.candidates.clear();
        }
        self.candidates.push_back((at_s, value_c));
        if self.candidates.len() > wanted {
            self.candidates.pop_front();
        }
        let is_possible = self.good.is_none_or(|good| self.is_possible(good, (at_s, value_c), f64::INFINITY));
        let count = self.candidates.len();
        if count < wanted || !is_possible {
            return Err(match self.good {
                None => (None, format!("{count} of {wanted} first readings agree")),
                Some((_, good_c)) => {
                    let note =
                        format!("{value_c:.1} °C after {good_c:.1} °C is faster than a machine temperature can change");
                    (Some(ChannelFault::Jump), note)
                }
            });
        }
        self.recent.clear();
        self.anchors.clear();
        for (at_s, value_c) in std::mem::take(&mut self.candidates) {
            self.accept(at_s, value_c);
        }
        Ok(())
    }

    /// Accepts a good value.
    fn accept(&mut self, at_s: f64, value_c: f64) {
        self.good = Some((at_s, value_c));
        self.recent.push_back(value_c);
        while self.recent.len() > self.channel.median.max(1) {
            self.recent.pop_front();
        }
        self.value_c = median(self.recent.make_contiguous());
        let most_s = self.steady_s();
        self.anchors.retain(|&(anchor_s, _)| anchor_s >= at_s - most_s);
        if self.anchors.back().is_none_or(|&(last_s, _)| at_s - last_s >= most_s / ANCHORS as f64) {
            self.anchors.push_back((at_s, value_c));
        }
    }

    /// Checks that a good value has not been constant for too long.
    fn check_motion(&mut self, at_s: f64, raw: f64) -> Result<(), (Option<ChannelFault>, String)> {
        let limit_s = self.channel.stuck_after.as_secs_f64();
        match self.same {
            Some((since_s, same)) if same == raw => {
                let for_s = at_s - since_s;
                if limit_s > 0.0 && for_s >= limit_s {
                    return Err((Some(ChannelFault::Stuck), format!("exactly {raw} for {for_s:.0} s")));
                }
            }
            _ => self.same = Some((at_s, raw)),
        }
        Ok(())
    }
}

/// Returns the median; for an even number of values the mean of the two in the middle.
fn median(values: &[f64]) -> Option<f64> {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let upper = *sorted.get(sorted.len() / 2)?;
    let lower = *sorted.get(sorted.len().saturating_sub(1) / 2)?;
    Some(if lower == upper { upper } else { 0.5 * (lower + upper) })
}
