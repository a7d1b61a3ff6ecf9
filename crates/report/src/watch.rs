//! Live sensors as a table, as a line, and as JSON.

use std::fmt::Write as _;

use serde::Serialize;

/// Output of `ncfix sensors --watch` at one instant.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct WatchReport {
    /// Version of this object.
    pub schema: u32,
    /// Time since the start, s.
    pub t_s: f64,
    /// Verdict on all sensors, or the action that is due.
    pub verdict: WatchVerdict,
    /// Reason if it is not good.
    pub why: Option<String>,
    /// Channels, in the order of the file.
    pub channels: Vec<WatchChannel>,
}

/// Channel.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct WatchChannel {
    /// Name.
    pub name: String,
    /// Last good value, °C.
    #[serde(rename = "value_C")]
    pub value_c: Option<f64>,
    /// Age of the last good value, s.
    pub age_s: Option<f64>,
    /// State of the value.
    pub state: WatchedState,
    /// Reason why it is held.
    pub fault: Option<&'static str>,
    /// Last raw number.
    pub raw: Option<f64>,
    /// Description of the fault, as a sentence.
    pub note: Option<String>,
    /// Source of the values.
    pub source: String,
}

/// Verdict on live sensors.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum WatchVerdict {
    /// All sensors are good.
    Good,
    /// Some sensors had no good value yet.
    Waiting,
    /// Some sensors are held: the correction does not approach that of the model.
    Freeze,
    /// A sensor has been without a good value for too long, and the work continues.
    Continue,
    /// A sensor has been without a good value for too long, and the work stops.
    Stop,
    /// A sensor has been without a good value for too long, and the axes are held.
    Hold,
}

/// State of the value of a live sensor.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum WatchedState {
    /// No value yet.
    Waiting,
    /// The value is good.
    Good,
    /// The value is the last good one.
    Held,
}

impl WatchVerdict {
    /// Returns its name as in JSON.
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
    /// Returns its name as in JSON.
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
    /// Returns a line.
    #[must_use]
    pub fn line(&self) -> String {
        let mut text = format!("{:.1} s  {}", self.t_s, self.verdict.word());
        for channel in &self.channels {
            let _ = write!(text, "  {} {} °C", channel.name, channel.value());
            match (&channel.note, channel.state) {
                (_, WatchedState::Good) => {}
                (Some(note), WatchedState::Waiting) => drop(write!(text, " (waiting: {note})")),
                _ => drop(write!(text, " ({})", channel.state())),
            }
        }
        text.push('\n');
        text
    }

    /// Returns a table.
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
