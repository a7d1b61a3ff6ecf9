//! Messages of a transfer: forecast, status, end. Sentences for people, JSON lines for programs.

use std::collections::BTreeMap;
use std::fmt::Write as _;

use serde::Serialize;

use super::json::DiagnosticReport;
use super::number::{duration, grouped};
use ncfix_base::geometry::AxisKey;

/// Kind of an object of a transfer.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum FeedEvent {
    /// Forecast before the start.
    Forecast,
    /// Current status.
    #[default]
    Status,
    /// End of the transfer.
    End,
    /// Message of the control.
    Said,
    /// The link cannot ask for the zero offsets: a person must compare them.
    Zero,
    /// Nothing was heard for longer than a line takes.
    Stalled,
    /// The control pauses, or resumes.
    Paused,
    /// Maximum number of blocks that the control may hold.
    Holds,
    /// A line is sent again.
    Repeated,
    /// Sensors became unreliable, or good again.
    Sensors,
    /// Temperatures require a large correction.
    Shift,
    /// A person has stopped the transfer.
    Halt,
}

/// End of a transfer.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum FeedOutcome {
    /// All lines were executed, or at least answered.
    Done,
    /// A person or the sensors have stopped it, and the sent lines have run out.
    Stopped,
    /// The axes were held.
    Held,
    /// Link or control failed.
    Lost,
    /// The control has refused a line.
    Refused,
    /// A line could not be made.
    Fault,
}

/// Evidence at the end of a transfer that the control has executed the lines.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum ExecutionEvidence {
    /// The control reports the position that the last lines command.
    Position,
    /// The control reports another position than the last lines command.
    Differs,
    /// The control reports that it has executed all lines. No position was compared.
    Reported,
    /// The control has accepted all lines. The link cannot ask whether it has executed them.
    Accepted,
    /// All lines were transmitted. The link cannot ask whether the control has executed them.
    Transmitted,
}

impl ExecutionEvidence {
    /// Returns the last line of the table, for people. `axes` are the letters of the compared axes.
    fn row(self, axes: Option<&str>) -> String {
        match self {
            ExecutionEvidence::Position => {
                let letters: Vec<String> = axes.unwrap_or_default().chars().map(String::from).collect();
                format!("confirmed    the control reports the end position of the program in {}", letters.join(", "))
            }
            ExecutionEvidence::Differs => "confirmed    no: the control reports another position".to_owned(),
            ExecutionEvidence::Reported => {
                "confirmed    the control reports that it has executed all lines; no position was compared".to_owned()
            }
            ExecutionEvidence::Accepted => {
                "confirmed    no: the control accepted all lines, but this link cannot ask whether it executed them"
                    .to_owned()
            }
            ExecutionEvidence::Transmitted => {
                "confirmed    no: all lines were transmitted, but this link cannot ask whether the control executed them"
                    .to_owned()
            }
        }
    }
}

/// Stretch of lines in which the control waits for the link.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Late {
    /// First and last source line.
    pub source_lines: [u32; 2],
    /// Time in which the axes stand still in it.
    pub starved_s: f64,
    /// Lines per second that the motion needs in it.
    pub needed_per_s: f64,
    /// Lines per second that the link delivers in it.
    pub given_per_s: f64,
}

/// First answer of a temperature sensor in a dry run.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct SensorAnswer {
    /// Name of the channel.
    pub name: String,
    /// Value, °C.
    pub value_c: Option<f64>,
    /// Fault, if there is no value.
    pub fault: Option<String>,
}

/// Forecast of a transfer.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Before {
    /// Version of this object.
    pub schema: u32,
    /// [`FeedEvent::Forecast`].
    pub event: FeedEvent,
    /// Hash of the program and of all files that it calls.
    pub program: String,
    /// Number of lines.
    pub lines: u64,
    /// Bytes including line ends.
    pub bytes: u64,
    /// Duration of the motion if no line is late.
    pub motion_s: f64,
    /// Duration over this link.
    pub total_s: f64,
    /// Time in which the axes stand still because lines are missing.
    pub starved_s: f64,
    /// Minimum number of lines that wait in the control.
    pub lowest: Option<usize>,
    /// True if the next line is sent only when the one before it is done: the axes stand still at the end of each line.
    pub line_by_line: bool,
    /// Path of the file on the control, if the link sends the program as one file.
    pub file: Option<String>,
    /// Delay of a temperature change due to the lines in the control, which no longer change.
    pub frozen_s: f64,
    /// Worst stretches.
    pub late: Vec<Late>,
    /// First answers of the temperature sensors; empty unless a dry run asked them.
    pub sensors: Vec<SensorAnswer>,
    /// Diagnostics.
    pub diagnostics: Vec<DiagnosticReport>,
}

impl Before {
    /// Returns the table for people. `is_demo` if it is not a forecast for a real machine.
    #[must_use]
    pub fn table(&self, is_demo: bool) -> String {
        let mut out = String::new();
        if is_demo {
            let _ = writeln!(out, "machine      the embedded demo machine: on yours, lines and times are others");
        }
        let _ = writeln!(
            out,
            "lines        {} ({} bytes), {} of motion",
            grouped(self.lines),
            grouped(self.bytes),
            duration(self.motion_s)
        );
        let lowest =
            self.lowest.map_or(String::new(), |lowest| format!("; fewest lines waiting in the control: {lowest}"));
        if let Some(file) = &self.file {
            let _ = writeln!(out, "link         sends the file {file}; a person starts it at the control");
        } else if !self.late.is_empty() {
            let _ = writeln!(
                out,
                "link         late: the axes stand still for {} of {}{lowest}",
                duration(self.starved_s),
                duration(self.total_s)
            );
        } else {
            let _ = writeln!(out, "link         keeps up{lowest}");
        }
        if self.line_by_line {
            let _ = writeln!(out, "             line by line: the axes stand still at the end of each");
        }
        for late in self.late.iter().take(5) {
            let [first, last] = late.source_lines;
            let _ = writeln!(
                out,
                "             lines {first}–{last} of the original: {} lines/s needed, {} available: {} late",
                rate(late.needed_per_s),
                rate(late.given_per_s),
                duration(late.starved_s)
            );
        }
        let _ = writeln!(
            out,
            "in control   up to {} of motion waits there; new temperatures do not change it",
            duration(self.frozen_s)
        );
        if !self.sensors.is_empty() {
            let said = |one: &SensorAnswer| match (one.value_c, &one.fault) {
                (Some(value_c), _) => format!("{} {value_c:.2} °C", one.name),
                (None, why) => format!("{}: {}", one.name, why.as_deref().unwrap_or("no value")),
            };
            let all: Vec<String> = self.sensors.iter().map(said).collect();
            let _ = writeln!(out, "sensors      {}", all.join(", "));
        }
        out
    }

    /// Returns a sentence about the sensors that gave no value; `None` if all did, or none was asked.
    #[must_use]
    pub fn bad_sensors(&self) -> Option<String> {
        let bad: Vec<&str> =
            self.sensors.iter().filter(|one| one.value_c.is_none()).map(|one| one.name.as_str()).collect();
        (!bad.is_empty()).then(|| {
            format!(
                "no good value of {}; the job would not begin: check with `ncfix sensors … --watch`",
                bad.join(", ")
            )
        })
    }
}

/// Formats lines per second with the significant digits.
#[must_use]
pub fn rate(per_s: f64) -> String {
    if per_s < 10.0 { format!("{per_s:.2}") } else { format!("{per_s:.0}") }
}

/// Status or end of a transfer.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Status {
    /// Version of this object.
    pub schema: u32,
    /// [`FeedEvent::Status`] or [`FeedEvent::End`].
    pub event: FeedEvent,
    /// Time since the start.
    pub time_s: f64,
    /// Total number of lines.
    pub lines: u64,
    /// Lines that were sent.
    pub sent: u64,
    /// Lines that the control has acknowledged.
    pub acknowledged: u64,
    /// Lines that have left over a link without answers.
    pub left: Option<u64>,
    /// Lines that the control has executed, if it reports them.
    pub executed: Option<u64>,
    /// Number of lines under way.
    pub window: usize,
    /// Number of their bytes.
    pub window_bytes: usize,
    /// Minimum number of lines under way since the window was full.
    pub lowest: Option<usize>,
    /// Utilization of the link, %; `null` if it has no speed of its own.
    pub link_percent: Option<f64>,
    /// Lines that were sent again.
    pub repeats: u64,
    /// Number of timeouts.
    pub stalls: u64,
    /// Correction due to temperature that was added to the axes in the last line: `X_um`, `C_urad`.
    pub applied: BTreeMap<AxisKey, f64>,
    /// Correction due to temperature that the model asks for.
    pub target: BTreeMap<AxisKey, f64>,
    /// Age of the oldest sensor reading.
    pub sensor_age_s: Option<f64>,
    /// Faults of the sensors.
    pub sensors: Option<String>,
    /// Estimated time until the end.
    pub eta_s: Option<f64>,
    /// Time from an answer to the bytes of the next line, µs: median, 99th percentile, maximum.
    pub delay_us: Option<[f64; 3]>,
    /// Last report of the control about its state and position, if the link asks for it.
    pub control: Option<String>,
    /// Outcome.
    pub ended: Option<FeedOutcome>,
    /// Evidence that the control has executed the lines, at the end of a job that is done or whose end position differs.
    pub confirmed: Option<ExecutionEvidence>,
    /// Letters of the axes whose reported position is that of the last line sent.
    pub in_position: Option<String>,
    /// Message for people.
    pub message: Option<String>,
    /// Source line of the last line.
    pub source_line: u32,
}

impl Status {
    /// Returns one line for a terminal.
    #[must_use]
    pub fn line(&self) -> String {
        let done = self.left.unwrap_or(self.acknowledged);
        let mut out = format!("line {} of {}", grouped(done), grouped(self.lines));
        let lowest = self.lowest.map_or(String::new(), |lowest| format!(" (lowest {lowest})"));
        let _ = write!(out, ", {} sent, window {}{lowest}", grouped(self.sent), self.window);
        if let Some(percent) = self.link_percent {
            let _ = write!(out, ", link {percent:.0} %");
        }
        for (key, target) in &self.target {
            let applied = self.applied.get(key).copied().unwrap_or(0.0);
            let (axis, unit) = (key.letter(), key.sign());
            let _ = write!(out, ", {axis} {applied:+.1}→{target:+.1} {unit}");
        }
        if let Some(age) = self.sensor_age_s {
            let _ = write!(out, ", sensors {age:.0} s old");
        }
        if let Some(sensors) = &self.sensors {
            let _ = write!(out, " ({sensors})");
        }
        if let Some(control) = &self.control {
            let _ = write!(out, ", control: {control}");
        }
        if let Some(eta) = self.eta_s {
            let _ = write!(out, ", {} left", duration(eta));
        }
        out
    }

    /// Returns the table for people at the end.
    #[must_use]
    pub fn table(&self) -> String {
        let mut out = String::new();
        let _ = writeln!(
            out,
            "lines        {} of {} {}, {} sent, in {}",
            grouped(self.left.unwrap_or(self.acknowledged)),
            grouped(self.lines),
            if self.left.is_some() { "transmitted" } else { "acknowledged" },
            grouped(self.sent),
            duration(self.time_s)
        );
        if let Some(executed) = self.executed {
            let _ = writeln!(out, "executed     {}", grouped(executed));
        }
        if let Some(control) = &self.control {
            let _ = writeln!(out, "control      {control}");
        }
        if let Some(lowest) = self.lowest {
            let _ = writeln!(out, "buffer       fewest lines waiting: {lowest}");
        }
        if let Some([median, most, longest]) = self.delay_us {
            let _ = writeln!(
                out,
                "delay        of ncfix from an answer to the next line: {median:.0} µs median, {most:.0} µs for 99 %, {longest:.0} µs at most"
            );
        }
        if self.repeats + self.stalls > 0 {
            let plural = |count: u64| if count == 1 { "" } else { "s" };
            let mut problems = Vec::new();
            if self.repeats > 0 {
                problems.push(format!("{} line{} sent again", self.repeats, plural(self.repeats)));
            }
            if self.stalls > 0 {
                problems.push(format!("no answer {} time{}", self.stalls, plural(self.stalls)));
            }
            let _ = writeln!(out, "problems     {}", problems.join(", "));
        }
        if let Some(confirmed) = self.confirmed {
            let _ = writeln!(out, "{}", confirmed.row(self.in_position.as_deref()));
        }
        out
    }
}

/// Event of a transfer.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Said {
    /// Version of this object.
    pub schema: u32,
    /// Kind: `said`, `holds`, `stalled`, `paused`, `repeated`, `sensors`, `shift`, `port`.
    pub event: FeedEvent,
    /// Time since the start.
    pub time_s: f64,
    /// Line concerned.
    pub line: Option<u64>,
    /// Its text.
    pub message: String,
}

/// Plan for restarting an interrupted job.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Plan {
    /// Version of this object.
    pub schema: u32,
    /// Number of the plan; it differs for another journal or another place.
    pub plan: String,
    /// Part program.
    pub program: String,
    /// End of the job; `null` if the sending program died.
    pub ended: Option<String>,
    /// Last line that the control has acknowledged.
    pub acknowledged: u64,
    /// Source line of `acknowledged`.
    pub acknowledged_line: Option<u32>,
    /// Last line that was certainly executed.
    pub executed: u64,
    /// Source line of `executed`.
    pub executed_line: Option<u32>,
    /// Maximum number of blocks that the control may have taken and not executed; `null` if it is not known.
    pub holds: Option<u64>,
    /// Source of that number.
    pub holds_source: Option<String>,
    /// Last line that may have been sent.
    pub sent: u64,
    /// Source line of `sent`.
    pub sent_line: Option<u32>,
    /// Source line at which the job begins again.
    pub source_line: u32,
    /// True if that is the beginning of the program.
    pub is_beginning: bool,
    /// Height of the tool above everything machined before it moves across; `null` if nothing is machined.
    pub above_mm: Option<f64>,
    /// Source line after which the state of the control cannot be rebuilt; it explains the place.
    pub unsure_line: Option<u32>,
    /// Tool that must be in the spindle.
    pub tool: Option<String>,
    /// Lines that are sent before the program.
    pub before: Vec<String>,
    /// First lines of the program that are sent.
    pub first: Vec<String>,
    /// Clear height of the restart path, as given.
    pub clearance: Option<String>,
    /// Port.
    pub port: String,
    /// True if the link cannot ask whether the machine stands still, so that a person must look.
    #[serde(skip)]
    pub needs_a_look: bool,
}

impl Plan {
    /// Returns the plan for people.
    #[must_use]
    pub fn table(&self, journal: &str) -> String {
        let mut out = String::new();
        let in_source =
            |line: Option<u32>| line.map_or(String::new(), |line| format!(" (line {line} of the original)"));
        let ended = self.ended.as_deref().unwrap_or("the sending program ended unexpectedly");
        let _ = writeln!(out, "job           {}, aborted: {ended}", self.program);
        if self.executed > 0 {
            let _ = writeln!(out, "executed      up to {}{} for certain", self.executed, in_source(self.executed_line));
        } else if let Some(line) = self.executed_line {
            let _ = writeln!(
                out,
                "executed      up to line {line} of the original for certain, in an earlier part of the job"
            );
        } else {
            let _ = writeln!(out, "executed      nothing for certain");
        }
        let _ = writeln!(out, "acknowledged  up to {}{}", self.acknowledged, in_source(self.acknowledged_line));
        if self.acknowledged > self.executed {
            let _ = match (self.holds, &self.holds_source) {
                (Some(most), source) => {
                    let source = source.as_deref().unwrap_or_default();
                    writeln!(out, "              up to {most} of these blocks may still wait in the control ({source})")
                }
                _ => writeln!(
                    out,
                    "              this does not show what was executed: the control did not state how much it holds"
                ),
            };
        }
        if self.sent > self.executed {
            let [from, to] = [self.executed + 1, self.sent];
            let until = self.sent_line.map_or(String::new(), |line| format!(" (original up to line {line})"));
            let lines = if from == to { format!("line {to}") } else { format!("lines {from} to {to}") };
            let _ = writeln!(out, "unknown       sent {lines}{until}: executed, partly executed, or not");
        }
        let place = if self.is_beginning { ", the beginning" } else { ", a rapid move" };
        let above = self
            .above_mm
            .map_or(String::new(), |mm| format!("; the tool crosses {mm:.1} mm above the highest feed move"));
        let _ = writeln!(out, "resumes       at line {} of the original{place}{above}", self.source_line);
        if let Some(line) = self.unsure_line {
            let _ = writeln!(
                out,
                "              (line {line} sets a state that cannot be restored, so no later place is possible)"
            );
        }
        if let Some(tool) = &self.tool {
            let _ = writeln!(out, "tool          {tool} must be in the spindle");
        }
        for (name, lines) in [("sent first", &self.before), ("then", &self.first)] {
            for (number, line) in lines.iter().enumerate() {
                let _ = writeln!(out, "{:<14}{line}", if number == 0 { name } else { "" });
            }
        }
        let rapid = self.before.iter().find(|line| line.contains("G0 Z"));
        if let Some(line) = rapid.map(|line| line.split(' ').filter(|word| word.starts_with('Z')).collect::<String>()) {
            let _ = writeln!(out, "attention     the first move goes to {line} at rapid: down, if the tool is higher");
        }
        let _ = writeln!(
            out,
            "\nReset the control, so that no code of the job is left in force. If the position may be lost, home the machine. Check the zero point,\nand check that the first moves are free. No line is sent unless the control reports that it is idle; a link without\nsuch a report also needs --i-checked-the-machine-stands-still. Then:\n  ncfix resume {journal} --confirm {}{}{}",
            self.plan,
            self.clearance.as_ref().map_or(String::new(), |given| format!(" --clearance {given}")),
            if self.needs_a_look { " --i-checked-the-machine-stands-still" } else { "" }
        );
        out
    }
}
