//! Configuration file of live sensors, `S.toml`: channels, sources of their values, and plausibility limits.
//!
//! ```toml
//! poll_s = 10
//!
//! [source.cabinet]
//! kind = "file"
//! path = "cabinet.csv"
//!
//! [channel.T_head]
//! source = "cabinet"
//! range_C = [10, 60]
//! ```
//!
//! Plausibility limits (range, rate, age …) may be given at the top for all channels, and in a channel for this channel.

use std::collections::BTreeMap;
use std::sync::Arc;
use std::time::Duration;

use ncfix_base::diagnostic::{Code, Diagnostic, Place};
use ncfix_base::source::Source;
use ncfix_machine::machine::condition::file::READABLE_C;
use ncfix_machine::machine::file::{MachineFile, Section, nearest};

use super::source::{SensorSource, SensorSources, SourcePlan, Wanted};

/// Maximum number of channels; more than any machine has.
const MOST_CHANNELS: usize = 256;
/// Longest accepted time: one day.
const LONGEST_S: f64 = 86_400.0;
/// Values that sensors on a 1-wire bus report after power-on and when they do not answer, °C.
const NO_VALUE_C: [f64; 2] = [85.0, -127.0];

/// Action if a channel has had no good value for too long.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub enum Action {
    /// Continue with the held values.
    #[default]
    Continue,
    /// Send no further line.
    Stop,
    /// Hold the axes.
    Hold,
}

/// Unit of the numbers of a channel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ChannelUnit {
    /// Name in the file.
    pub name: &'static str,
    /// Degrees Celsius per unit.
    per_unit: f64,
    /// Temperature at zero of the unit, °C.
    at_zero: f64,
    /// True if it is a unit of temperature; other units need a scale.
    is_temperature: bool,
}

/// All units.
const UNITS: &[ChannelUnit] = &[
    ChannelUnit { name: "C", per_unit: 1.0, at_zero: 0.0, is_temperature: true },
    ChannelUnit { name: "mC", per_unit: 1e-3, at_zero: 0.0, is_temperature: true },
    ChannelUnit { name: "K", per_unit: 1.0, at_zero: -273.15, is_temperature: true },
    ChannelUnit { name: "F", per_unit: 5.0 / 9.0, at_zero: -160.0 / 9.0, is_temperature: true },
    ChannelUnit { name: "mV", per_unit: 1.0, at_zero: 0.0, is_temperature: false },
    ChannelUnit { name: "V", per_unit: 1.0, at_zero: 0.0, is_temperature: false },
    ChannelUnit { name: "mA", per_unit: 1.0, at_zero: 0.0, is_temperature: false },
    ChannelUnit { name: "ohm", per_unit: 1.0, at_zero: 0.0, is_temperature: false },
    ChannelUnit { name: "raw", per_unit: 1.0, at_zero: 0.0, is_temperature: false },
];

/// Sensor channel: conversion of its numbers to temperatures, and plausibility limits.
#[derive(Clone, Debug, PartialEq)]
pub struct SensorChannel {
    /// Name; that of the sensor in the machine file.
    pub name: String,
    /// Name of the [`ValueOrigin`] of its values.
    pub source: String,
    /// Unit of its numbers.
    pub unit: ChannelUnit,
    /// Factor on a number.
    pub scale: f64,
    /// Offset that is added after scaling and before the unit conversion.
    pub offset: f64,
    /// Numbers by which the sensor reports that it has no value. If absent, those of 1-wire sensors.
    pub invalid: Option<Vec<f64>>,
    /// Lowest and highest plausible temperature, °C.
    pub range_c: [f64; 2],
    /// Maximum rate of change, K/min.
    pub max_rate_k_per_min: f64,
    /// Permitted sudden change due to noise and resolution, K.
    pub step_k: f64,
    /// Maximum age of a value.
    pub max_age: Duration,
    /// Number of values in the median filter.
    pub median: usize,
    /// Number of values that must agree before a level that does not follow from the last one is accepted.
    pub confirm: usize,
    /// Number of values before the first level is accepted. The values of a record were checked when it was made.
    pub first: usize,
    /// Time after which an unchanged value counts as stuck; 0 disables the check.
    pub stuck_after: Duration,
    /// Action if it has no good value.
    pub action: Action,
    /// Time without a good value after which the action is taken.
    pub act_after: Duration,
}

impl SensorChannel {
    /// Converts a number to a temperature, °C.
    #[must_use]
    pub fn to_c(&self, raw: f64) -> f64 {
        (raw * self.scale + self.offset) * self.unit.per_unit + self.unit.at_zero
    }

    /// True if the number means that the sensor has no value.
    #[must_use]
    pub fn is_invalid(&self, raw: f64, value_c: f64) -> bool {
        match &self.invalid {
            Some(invalid) => invalid.contains(&raw),
            None => NO_VALUE_C.iter().any(|no_value_c| (value_c - no_value_c).abs() < 1e-9),
        }
    }
}

/// Source of values.
#[derive(Clone, Debug)]
pub struct ValueOrigin {
    /// Name.
    pub name: String,
    /// Kind.
    pub kind: Arc<dyn SensorSource>,
    /// Place in the file.
    pub place: Place,
    /// Interval at which it is polled.
    pub poll: Duration,
    /// Indices of its channels in [`Config::channels`].
    pub channels: Vec<usize>,
    /// Settings for opening it.
    pub plan: Arc<dyn SourcePlan>,
}

/// Content of the file.
#[derive(Clone, Debug)]
pub struct Config {
    /// All sensors.
    pub channels: Vec<SensorChannel>,
    /// Sources of their values.
    pub sources: Vec<ValueOrigin>,
    /// Polling interval of sources without their own.
    pub poll: Duration,
}

impl Config {
    /// Reads a file.
    ///
    /// # Errors
    /// All faults of the file: `E0401`–`E0404`.
    pub fn read(source: &Source) -> Result<Config, Vec<Diagnostic>> {
        Config::read_with(source, &SensorSources::default())
    }

    /// Reads a file that may have these kinds of sources.
    ///
    /// # Errors
    /// As [`Self::read`].
    pub fn read_with(source: &Source, kinds: &SensorSources) -> Result<Config, Vec<Diagnostic>> {
        let document = MachineFile::parse(source)?;
        let mut root = document.root();
        let mut findings = Vec::new();
        let poll = seconds(&mut root, "poll_s", 0.05).unwrap_or(Duration::from_secs(10));
        let mut rules = rules(poll);
        read_rules(&mut root, &mut rules);
        let sources = named(&mut root, "source", "[source.cabinet] with its kind", &mut findings);
        let channels = named(&mut root, "channel", "[channel.T_head] with its source", &mut findings);
        root.finish(&mut findings);
        let config = Reader { poll, rules, kinds, findings: &mut findings }.read(sources, channels);
        findings.sort_by_key(|finding| (finding.place, finding.code));
        if findings.iter().any(Diagnostic::is_error) { Err(findings) } else { Ok(config) }
    }
}

/// Reads the named sections below a key that must exist.
fn named<'a>(
    root: &mut Section<'a>,
    key: &str,
    example: &str,
    findings: &mut Vec<Diagnostic>,
) -> Vec<(String, Section<'a>)> {
    let Some(mut section) = root.required(key, example, Section::section) else { return Vec::new() };
    let keys: Vec<&str> = section.keys().collect();
    if keys.len() > MOST_CHANNELS {
        let message = format!("{} has {} entries", section.title(), keys.len());
        section.report(Code::BAD_VALUE, section.place(), message, format!("at most {MOST_CHANNELS} are read"));
    }
    let found = keys
        .into_iter()
        .take(MOST_CHANNELS)
        .filter_map(|key| section.section(key).map(|own| (key.to_owned(), own)))
        .collect();
    section.finish(findings);
    found
}

/// Makes a configuration from sections.
struct Reader<'f> {
    poll: Duration,
    rules: SensorChannel,
    kinds: &'f SensorSources,
    findings: &'f mut Vec<Diagnostic>,
}

impl Reader<'_> {
    fn read(self, sources: Vec<(String, Section<'_>)>, channels: Vec<(String, Section<'_>)>) -> Config {
        let mut config = Config { channels: Vec::new(), sources: Vec::new(), poll: self.poll };
        let mut wanted: BTreeMap<String, Vec<Wanted<'_>>> = BTreeMap::new();
        let names: Vec<String> = sources.iter().map(|(name, _)| name.clone()).collect();
        for (name, mut section) in channels {
            let index = config.channels.len();
            let channel = self.channel(&name, &mut section, &names);
            wanted.entry(channel.source.clone()).or_default().push(Wanted { index, name, section });
            config.channels.push(channel);
        }
        let mut inputs = 0;
        for (name, mut section) in sources {
            let place = section.place();
            let mut own = wanted.remove(&name).unwrap_or_default();
            let poll = seconds(&mut section, "poll_s", 0.05).unwrap_or(self.poll);
            let kind = read_kind(&mut section, self.kinds);
            if own.is_empty() {
                let help = format!("write source = \"{name}\" in a channel, or remove the source");
                section.report(Code::BAD_VALUE, place, format!("no channel uses {}", section.title()), help);
            }
            let is_input = kind.as_ref().is_some_and(|kind| kind.is_standard_input());
            inputs += usize::from(is_input);
            if is_input && inputs > 1 {
                let help = "there is only one standard input; give its channels the same source";
                section.report(Code::BAD_VALUE, place, "two sources read standard input", help);
            }
            let plan = kind.as_ref().and_then(|kind| kind.read(&mut section, &mut own));
            if kind.is_none() {
                // The meaning of the other keys is unknown.
                let keys: Vec<&str> = section.keys().collect();
                keys.into_iter().for_each(|key| section.accept(key));
                own.iter_mut().for_each(|wanted| accept_all(&mut wanted.section));
            }
            section.finish(self.findings);
            let channels: Vec<usize> = own.iter().map(|wanted| wanted.index).collect();
            own.into_iter().for_each(|wanted| wanted.section.finish(self.findings));
            if let (Some(kind), Some(plan)) = (kind, plan) {
                for &index in channels.iter().filter(|_| kind.is_record()) {
                    config.channels[index].first = 1;
                }
                config.sources.push(ValueOrigin { name, kind, place, poll, channels, plan });
            }
        }
        for mut wanted in wanted.into_values().flatten() {
            accept_all(&mut wanted.section);
            wanted.section.finish(self.findings);
        }
        config
    }

    fn channel(&self, name: &str, section: &mut Section<'_>, sources: &[String]) -> SensorChannel {
        let mut channel = SensorChannel { name: name.to_owned(), ..self.rules.clone() };
        channel.source = section.required("source", "\"cabinet\"", Section::text).unwrap_or_default().to_owned();
        if !channel.source.is_empty() && !sources.contains(&channel.source) {
            let known = || sources.iter().map(String::as_str);
            let help = nearest(&channel.source, known()).map_or_else(
                || format!("add [source.{}], or use one of {}", channel.source, known().collect::<Vec<_>>().join(", ")),
                |near| format!("did you mean \"{near}\"?"),
            );
            let message = format!("there is no source '{}'", channel.source);
            section.report(Code::BAD_VALUE, section.place_of("source"), message, help);
        }
        if let Some(text) = section.text("unit") {
            match UNITS.iter().find(|unit| unit.name == text) {
                Some(unit) => channel.unit = *unit,
                None => {
                    let names: Vec<&str> = UNITS.iter().map(|unit| unit.name).collect();
                    let help = format!("one of {}", names.join(", "));
                    section.report(
                        Code::BAD_VALUE,
                        section.place_of("unit"),
                        format!("there is no unit '{text}'"),
                        help,
                    );
                }
            }
        }
        let is_scale = |value: f64| value != 0.0 && value.abs() < 1e9;
        channel.scale = section.number_where("scale", "a number that is not 0", is_scale).unwrap_or(1.0);
        channel.offset = section.number("offset").unwrap_or(0.0);
        if !channel.unit.is_temperature && !section.has("scale") {
            let message = format!("{} in {} is not a temperature", section.title(), channel.unit.name);
            let help = "write scale and offset: value · scale + offset is then in °C";
            section.report(Code::MISSING_KEY, section.place(), message, help);
        }
        channel.invalid = section.numbers("invalid");
        read_rules(section, &mut channel);
        channel
    }
}

/// Reads the kind of a source.
fn read_kind(section: &mut Section<'_>, kinds: &SensorSources) -> Option<Arc<dyn SensorSource>> {
    let written = section.required("kind", "\"file\"", Section::text)?;
    let found = kinds.shared(written);
    if found.is_none() {
        let names = || kinds.names();
        let help = nearest(written, names()).map_or_else(
            || format!("one of {}", names().collect::<Vec<_>>().join(", ")),
            |near| format!("did you mean \"{near}\"?"),
        );
        section.report(Code::BAD_VALUE, section.place_of("kind"), format!("unknown kind \"{written}\""), help);
    }
    found
}

/// Accepts all keys: the kind is unknown, so their meaning is unknown, too.
pub(super) fn accept_all(section: &mut Section<'_>) {
    let keys: Vec<&str> = section.keys().collect();
    keys.into_iter().for_each(|key| section.accept(key));
}

/// Default plausibility limits.
fn rules(poll: Duration) -> SensorChannel {
    SensorChannel {
        name: String::new(),
        source: String::new(),
        unit: UNITS[0],
        scale: 1.0,
        offset: 0.0,
        invalid: None,
        // From a frosty hall to a hot bearing.
        range_c: [-10.0, 80.0],
        // Spindle bearings change by some kelvin per minute, structures by a tenth of that.
        max_rate_k_per_min: 5.0,
        step_k: 0.5,
        // Three readings may be missing; temperatures are needed about once a minute (Spaan 1995, ch. 7).
        max_age: (3 * poll).max(Duration::from_secs(180)),
        median: 3,
        confirm: 3,
        first: 3,
        stuck_after: Duration::ZERO,
        action: Action::Continue,
        act_after: Duration::from_secs(300),
    }
}

/// Reads plausibility limits and overrides the existing ones.
fn read_rules(section: &mut Section<'_>, rules: &mut SensorChannel) {
    if let Some(range) = section.numbers("range_C") {
        let [lowest, highest] = READABLE_C;
        match *range.as_slice() {
            [low, high] if lowest <= low && low < high && high <= highest => rules.range_c = [low, high],
            _ => {
                let message = "range_C must be the lowest and the highest temperature";
                let help = format!("two numbers that increase, within {lowest} and {highest} °C, for example [10, 60]");
                section.report(Code::BAD_VALUE, section.place_of("range_C"), message, help);
            }
        }
    }
    let is_rate = |value: f64| value > 0.0 && value <= 1e4;
    if let Some(rate) = section.number_where("max_rate_K_per_min", "a number above 0", is_rate) {
        rules.max_rate_k_per_min = rate;
    }
    let is_step = |value: f64| (0.0..=100.0).contains(&value);
    if let Some(step) = section.number_where("step_K", "a number from 0 to 100", is_step) {
        rules.step_k = step;
    }
    rules.max_age = seconds(section, "max_age_s", 0.05).unwrap_or(rules.max_age);
    rules.stuck_after = seconds(section, "stuck_after_s", 0.0).unwrap_or(rules.stuck_after);
    rules.act_after = seconds(section, "act_after_s", 0.0).unwrap_or(rules.act_after);
    let count = |section: &mut Section<'_>, key: &str| {
        let is_count = |value: f64| value.fract() == 0.0 && (1.0..=31.0).contains(&value);
        section.number_where(key, "a whole number from 1 to 31", is_count).map(|value| value as usize)
    };
    rules.median = count(section, "median").unwrap_or(rules.median);
    if let Some(confirm) = count(section, "confirm") {
        (rules.confirm, rules.first) = (confirm, confirm);
    }
    match section.text("action") {
        None => {}
        Some("continue") => rules.action = Action::Continue,
        Some("stop") => rules.action = Action::Stop,
        Some("hold") => rules.action = Action::Hold,
        Some(other) => {
            let message = format!("there is no action '{other}'");
            let help = "one of \"continue\", \"stop\", \"hold\"";
            section.report(Code::BAD_VALUE, section.place_of("action"), message, help);
        }
    }
}

/// Reads a time, s.
pub(super) fn seconds(section: &mut Section<'_>, key: &str, least: f64) -> Option<Duration> {
    let expected = format!("a time in s from {least} to {LONGEST_S}");
    section.number_where(key, &expected, |value| (least..=LONGEST_S).contains(&value)).map(Duration::from_secs_f64)
}
