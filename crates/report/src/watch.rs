//! Live sensors as a table, as a line, and as JSON.

use std::fmt::Write as _;

use serde::Serialize;

/// What `ncfix sensors --watch` saw at one instant.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct WatchReport {
    /// The shape of this object.
    pub schema: u32,
    /// Time since the start, s.
    pub t_s: f64,
    /// Whether they are good, or what is to be done.
    pub verdict: WatchVerdict,
    /// Why it is not good.
    pub why: Option<String>,
    /// The channels, in the order of the file.
    pub channels: Vec<WatchChannel>,
}

/// A channel.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct WatchChannel {
    /// Its name.
    pub name: String,
    /// The last good value, °C.
    #[serde(rename = "value_C")]
    pub value_c: Option<f64>,
    /// How old that is, s.
    pub age_s: Option<f64>,
    /// Whether its value is good.
    pub state: WatchedState,
    /// Why it is held.
    pub fault: Option<&'static str>,
    /// The last number that came, as it came.
    pub raw: Option<f64>,
    /// What is wrong, as a sentence.
    pub note: Option<String>,
    /// Where it comes from.
    pub source: String,
}

/// What live sensors are good for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum WatchVerdict {
    /// All are good.
    Good,
    /// Some had no good value yet.
    Waiting,
    /// Some are held: nothing is dosed.
    Freeze,
    /// One is without a good value for too long, and the work goes on.
    Continue,
    /// For the same reason the work stops.
    Stop,
    /// For the same reason the axes are held.
    Hold,
}

/// What the value of a live sensor is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum WatchedState {
    /// There is none yet.
    Waiting,
    /// It is good.
    Good,
    /// It is the last good one.
    Held,
}

impl WatchVerdict {
    /// As JSON has it.
    fn word(self) -> &'static str {
        match self {
            WatchVerdict::Good => "good",
            WatchVerdict::Waiting => "waiting",
            WatchVerdict::Freeze => "freeze",
            WatchVerdict::Continue => "continue",
            WatchVerdict::Stop => "stop",
            WatchVerdict::Hold => "hold",
        }
    }
}

impl WatchedState {
    /// As JSON has it.
    fn word(self) -> &'static str {
        match self {
            WatchedState::Waiting => "waiting",
            WatchedState::Good => "good",
            WatchedState::Held => "held",
        }
    }
}

impl WatchChannel {
    fn value(&self) -> String {
        self.value_c.map_or_else(|| "–".to_owned(), |value_c| format!("{value_c:.2}"))
    }

    fn state(&self) -> String {
        let state = self.state.word();
        self.fault.map_or_else(|| state.to_owned(), |fault| format!("{state}: {fault}"))
    }
}

impl WatchReport {
    /// A line.
    #[must_use]
    pub fn line(&self) -> String {
        let mut text = format!("{:.1} s  {}", self.t_s, self.verdict.word());
        for channel in &self.channels {
            let _ = write!(text, "  {} {} °C", channel.name, channel.value());
            if channel.state != WatchedState::Good {
                let _ = write!(text, " ({})", channel.state());
            }
        }
        text.push('\n');
        text
    }

    /// A table.
    #[must_use]
    pub fn page(&self) -> String {
        let width = |of: fn(&WatchChannel) -> usize, least: usize| self.channels.iter().map(of).fold(least, usize::max);
        let name = width(|channel| channel.name.chars().count(), 6);
        let source = width(|channel| channel.source.chars().count(), 6);
        let mut text =
            format!("{:name$}  {:>8}  {:>7}  {:18}  {:source$}  \n", "sensor", "°C", "age", "state", "source");
        for channel in &self.channels {
            let age = channel.age_s.map_or_else(|| "–".to_owned(), |age_s| format!("{age_s:.0} s"));
            let _ = writeln!(
                text,
                "{:name$}  {:>8}  {age:>7}  {:18}  {:source$}  {}",
                channel.name,
                channel.value(),
                channel.state(),
                channel.source,
                channel.note.as_deref().unwrap_or_default(),
            );
        }
        let why = self.why.as_ref().map_or_else(String::new, |why| format!(": {why}"));
        let _ = writeln!(text, "{}{why}", self.verdict.word());
        text
    }
}
