//! What is believed of a channel: a pure machine with values and times in, and the last good value out.
//!
//! A value counts where it is a number, within the range, and near enough to those before it: the temperature of a mass of iron changes with a limited
//! rate. One that is not is held back until some of them agree with each other *and* the rate allows the way from the last good value in the time
//! since then; so a fault that comes and goes leaves no trace, and a real change that was missed comes through in the end.

use std::collections::VecDeque;
use std::fmt;
use std::time::Duration;

use super::config::SensorChannel;

/// Earlier values that a new one is held against lie so far back in steps of a thirtieth of their time.
const ANCHORS: usize = 30;

/// Why a channel has no good value now.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fault {
    /// Nothing has come for too long, or what has come is too old.
    Silent,
    /// It is outside the range of the channel.
    OutOfRange,
    /// It is farther from the last one than the rate allows.
    Jump,
    /// It has not moved at all for too long.
    Stuck,
    /// It is no number, or one by which the sensor says that it has none.
    Invalid,
    /// The source cannot be reached, or has ended.
    Disconnected,
    /// It was kept by a broker, and nothing says how old it is.
    Retained,
    /// It says that it was read in the future.
    Clock,
}

impl Fault {
    /// Its name, as in JSON.
    #[must_use]
    pub fn word(self) -> &'static str {
        match self {
            Fault::Silent => "silent",
            Fault::OutOfRange => "out_of_range",
            Fault::Jump => "jump",
            Fault::Stuck => "stuck",
            Fault::Invalid => "invalid",
            Fault::Disconnected => "disconnected",
            Fault::Retained => "retained",
            Fault::Clock => "clock",
        }
    }
}

impl fmt::Display for Fault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Fault::Silent => "silent",
            Fault::OutOfRange => "out of range",
            Fault::Jump => "jump",
            Fault::Stuck => "stuck",
            Fault::Invalid => "no value",
            Fault::Disconnected => "disconnected",
            Fault::Retained => "retained",
            Fault::Clock => "clock",
        })
    }
}

/// What a source says of a channel.
#[derive(Clone, Debug, PartialEq)]
pub enum Told {
    /// A value as the sensor gives it.
    Value(f64),
    /// There is none, and why.
    Nothing(Fault, String),
}

/// How far a channel can be relied on.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ChannelState {
    /// There was no good value yet.
    #[default]
    Waiting,
    /// The value is good and young.
    Good,
    /// The value is the last good one; this is why there is no newer one.
    Held(Fault),
}

impl ChannelState {
    /// Its name, as in JSON.
    #[must_use]
    pub fn word(self) -> &'static str {
        match self {
            ChannelState::Waiting => "waiting",
            ChannelState::Good => "good",
            ChannelState::Held(_) => "held",
        }
    }
}

/// A channel as it is now.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Reading {
    /// Name of the sensor.
    pub name: String,
    /// The last good value, filtered, °C; `None` before the first one.
    pub value_c: Option<f64>,
    /// How long ago the last good value was read.
    pub age: Option<Duration>,
    /// How far it can be relied on.
    pub state: ChannelState,
    /// The last number that came, as it came, good or not.
    pub raw: Option<f64>,
    /// What is wrong, as a sentence; empty where nothing is.
    pub note: String,
}

/// The judge of one channel. Times are seconds since the start of the job, before it below zero.
#[derive(Clone, Debug)]
pub struct Monitor {
    channel: SensorChannel,
    /// The last good values, °C, as many as the median takes.
    recent: VecDeque<f64>,
    /// Good values of the last time, thinned out.
    anchors: VecDeque<(f64, f64)>,
    /// Values that do not follow from the good ones.
    candidates: VecDeque<(f64, f64)>,
    /// When the last good value was read, and what it was.
    good: Option<(f64, f64)>,
    value_c: Option<f64>,
    /// When the newest number was read, good or not.
    newest_s: f64,
    /// Since when the sensor has said the same.
    same: Option<(f64, f64)>,
    fault: Option<Fault>,
    note: String,
    /// Since when there is no good value.
    bad_since_s: Option<f64>,
    raw: Option<f64>,
}

impl Monitor {
    /// Nothing is known yet.
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

    /// Its channel.
    #[must_use]
    pub fn channel(&self) -> &SensorChannel {
        &self.channel
    }

    /// Hears what was read some time before now.
    pub fn hear(&mut self, told: &Told, age: Duration, now: Duration) {
        let now_s = now.as_secs_f64();
        let result = match told {
            Told::Value(raw) => self.judge(*raw, age, now_s - age.as_secs_f64()),
            Told::Nothing(fault, why) => Err((Some(*fault), why.clone())),
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

    /// Time has passed.
    pub fn tick(&mut self, now: Duration) {
        let now_s = now.as_secs_f64();
        let Some((good_s, _)) = self.good else {
            self.bad_since_s.get_or_insert(now_s);
            return;
        };
        let most_s = self.channel.max_age.as_secs_f64();
        if self.fault.is_none() && now_s - good_s > most_s {
            self.fault = Some(Fault::Silent);
            self.note = format!("nothing for more than {most_s} s");
            // When it became too old, not when that was seen: the same job says the same.
            self.bad_since_s.get_or_insert(good_s + most_s);
        }
    }

    /// How long there has been no good value.
    #[must_use]
    pub fn bad_for(&self, now: Duration) -> Option<Duration> {
        let since_s = self.bad_since_s?;
        Duration::try_from_secs_f64(now.as_secs_f64() - since_s).ok()
    }

    /// How far it can be relied on.
    #[must_use]
    pub fn state(&self) -> ChannelState {
        match (self.good, self.fault) {
            (None, _) => ChannelState::Waiting,
            (Some(_), None) => ChannelState::Good,
            (Some(_), Some(fault)) => ChannelState::Held(fault),
        }
    }

    /// Writes what it knows into a reading; returns whether the value has changed.
    pub fn show(&self, now: Duration, reading: &mut Reading) -> bool {
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

    /// Takes a number, or says why not; without a fault it neither counts nor is anything wrong with it.
    fn judge(&mut self, raw: f64, age: Duration, at_s: f64) -> Result<(), (Option<Fault>, String)> {
        let channel = &self.channel;
        let no = |fault, note: String| Err((Some(fault), note));
        if !raw.is_finite() {
            return no(Fault::Invalid, "the sensor gives no number".into());
        }
        self.raw = Some(raw);
        let value_c = channel.to_c(raw);
        if channel.is_invalid(raw, value_c) {
            return no(Fault::Invalid, format!("{raw} is what the sensor gives when it has no value"));
        }
        if age > channel.max_age {
            return no(Fault::Silent, format!("what comes is {:.0} s old", age.as_secs_f64()));
        }
        let [low, high] = channel.range_c;
        if !(low..=high).contains(&value_c) {
            return no(Fault::OutOfRange, format!("{value_c:.1} °C is not within {low} to {high} °C"));
        }
        if at_s <= self.newest_s {
            // The same reading again, or one that was overtaken: nothing new is known, and the old value grows older.
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

    /// Whether a value is one that may follow the good ones at once.
    fn follows(&self, at_s: f64, value_c: f64) -> bool {
        // The time between two readings counts for no more than this: after a long silence a single value is no proof.
        let most_s = self.steady_s();
        self.good.iter().chain(&self.anchors).all(|&earlier| self.is_possible(earlier, (at_s, value_c), most_s))
            && self.good.is_some()
    }

    /// Whether the rate allows the way between two values, where no more than some time counts.
    fn is_possible(&self, (from_s, from_c): (f64, f64), (to_s, to_c): (f64, f64), most_s: f64) -> bool {
        let minutes = (to_s - from_s).clamp(0.0, most_s) / 60.0;
        (to_c - from_c).abs() <= self.channel.step_k + self.channel.max_rate_k_per_min * minutes
    }

    /// A third of the age that a value may have.
    fn steady_s(&self) -> f64 {
        self.channel.max_age.as_secs_f64() / 3.0
    }

    /// Holds a value that does not follow from the good ones until others agree.
    fn confirm(&mut self, at_s: f64, value_c: f64) -> Result<(), (Option<Fault>, String)> {
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
                    let note = format!("{value_c:.1} °C after {good_c:.1} °C is faster than a machine changes");
                    (Some(Fault::Jump), note)
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

    /// Takes a good value.
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

    /// Whether a good value has been the very same for too long.
    fn check_motion(&mut self, at_s: f64, raw: f64) -> Result<(), (Option<Fault>, String)> {
        let limit_s = self.channel.stuck_after.as_secs_f64();
        match self.same {
            Some((since_s, same)) if same == raw => {
                let for_s = at_s - since_s;
                if limit_s > 0.0 && for_s >= limit_s {
                    return Err((Some(Fault::Stuck), format!("exactly {raw} for {for_s:.0} s")));
                }
            }
            _ => self.same = Some((at_s, raw)),
        }
        Ok(())
    }
}

/// The middle of some values, the mean of the two in the middle of an even number.
fn median(values: &[f64]) -> Option<f64> {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let upper = *sorted.get(sorted.len() / 2)?;
    let lower = *sorted.get(sorted.len().saturating_sub(1) / 2)?;
    Some(if lower == upper { upper } else { 0.5 * (lower + upper) })
}
