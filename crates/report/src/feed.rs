//! What a transfer says: the forecast, where it stands, how it ended. Sentences for people, JSON lines for programs.

use std::collections::BTreeMap;
use std::fmt::Write as _;

use serde::Serialize;

use super::json::Finding;
use super::number::{duration, grouped};
use ncfix_base::geometry::AxisKey;

/// What an object of a transfer tells.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum FeedEvent {
    /// What will happen, before the start.
    Forecast,
    /// Where it stands.
    #[default]
    Status,
    /// How it ended.
    End,
    /// The control says something.
    Said,
    /// Nothing was heard for longer than a line takes.
    Stalled,
    /// The control pauses, or goes on.
    Paused,
    /// How many blocks it may hold.
    Holds,
    /// A line is sent again.
    Repeated,
    /// Sensors are in doubt, or good again.
    Sensors,
    /// Temperatures ask for much.
    Shift,
    /// Somebody has stopped it.
    Halt,
}

/// How a transfer ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum FeedOutcome {
    /// All lines were carried out, or at least answered.
    Done,
    /// A person or the sensors have stopped it, and what was sent has run out.
    Stopped,
    /// The axes were held.
    Held,
    /// The link or the control is gone.
    Lost,
    /// The control has refused a line.
    Refused,
    /// A line could not be made.
    Fault,
}

/// A stretch of lines in which the control waits for the link.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Late {
    /// First and last line of the source.
    pub source_lines: [u32; 2],
    /// How long the axes stand still in it.
    pub starved_s: f64,
    /// Lines a second that the motion needs there.
    pub needed_per_s: f64,
    /// Lines a second that come there.
    pub given_per_s: f64,
}

/// Before the start.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Before {
    /// Version of this object.
    pub schema: u32,
    /// [`FeedEvent::Forecast`].
    pub event: FeedEvent,
    /// Hash of the program and of all that it calls.
    pub program: String,
    /// Lines.
    pub lines: u64,
    /// Bytes with their ends.
    pub bytes: u64,
    /// How long the motion takes if nothing is late.
    pub motion_s: f64,
    /// How long it takes over this link.
    pub total_s: f64,
    /// How long the axes stand still for want of lines.
    pub starved_s: f64,
    /// The fewest lines that wait in the control.
    pub lowest: Option<usize>,
    /// Whether the next line goes out only when the one before it is done: the axes stand still at the end of each.
    pub line_by_line: bool,
    /// How long a change of temperature takes until it counts: the lines that are frozen.
    pub frozen_s: f64,
    /// The worst places.
    pub late: Vec<Late>,
    /// Findings.
    pub diagnostics: Vec<Finding>,
}

impl Before {
    /// The table for people.
    #[must_use]
    pub fn table(&self) -> String {
        let mut out = String::new();
        let _ = writeln!(
            out,
            "lines        {} ({} bytes), {} of motion",
            grouped(self.lines),
            grouped(self.bytes),
            duration(self.motion_s)
        );
        let lowest = self.lowest.map_or(String::new(), |lowest| format!("; lowest fill of the control {lowest} lines"));
        if !self.late.is_empty() {
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
                "             lines {first}–{last} of the source need {} lines/s, {} come: {} late",
                rate(late.needed_per_s),
                rate(late.given_per_s),
                duration(late.starved_s)
            );
        }
        let _ = writeln!(
            out,
            "frozen       {} of motion lies in the window and no longer changes",
            duration(self.frozen_s)
        );
        out
    }
}

/// Lines a second, with the digits that tell something.
#[must_use]
pub fn rate(per_s: f64) -> String {
    if per_s < 10.0 { format!("{per_s:.2}") } else { format!("{per_s:.0}") }
}

/// Where a transfer stands, or how it ended.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Status {
    /// Version of this object.
    pub schema: u32,
    /// [`FeedEvent::Status`] or [`FeedEvent::End`].
    pub event: FeedEvent,
    /// Time since the start.
    pub time_s: f64,
    /// Lines in all.
    pub lines: u64,
    /// Lines that were sent.
    pub sent: u64,
    /// Lines that the control has acknowledged.
    pub acknowledged: u64,
    /// Lines that have left over a link without answers.
    pub left: Option<u64>,
    /// Lines that it has carried out, where it says so.
    pub executed: Option<u64>,
    /// Lines under way.
    pub window: usize,
    /// Their bytes.
    pub window_bytes: usize,
    /// The fewest lines under way since the window was full.
    pub lowest: Option<usize>,
    /// Share of the link that is used, %; `null` where it has no speed of its own.
    pub link_percent: Option<f64>,
    /// Lines that were sent again.
    pub repeats: u64,
    /// Times without an answer.
    pub stalls: u64,
    /// What temperatures have added to the axes of the last line: `X_um`, `C_urad`.
    pub applied: BTreeMap<AxisKey, f64>,
    /// What they ask for.
    pub target: BTreeMap<AxisKey, f64>,
    /// Age of the oldest reading of a sensor.
    pub sensor_age_s: Option<f64>,
    /// What is wrong with the sensors.
    pub sensors: Option<String>,
    /// How long it takes until the end.
    pub eta_s: Option<f64>,
    /// From an answer to the bytes of the next line, µs: half of them, 99 of 100, the longest.
    pub delay_us: Option<[f64; 3]>,
    /// How it ended.
    pub ended: Option<FeedOutcome>,
    /// What people should read.
    pub message: Option<String>,
    /// Line of the source of the last line.
    pub source_line: u32,
}

impl Status {
    /// One line for a terminal.
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
        if let Some(eta) = self.eta_s {
            let _ = write!(out, ", {} left", duration(eta));
        }
        out
    }

    /// How it ended, for people.
    #[must_use]
    pub fn table(&self) -> String {
        let mut out = String::new();
        let _ = writeln!(
            out,
            "lines        {} of {} {}, {} sent, in {}",
            grouped(self.left.unwrap_or(self.acknowledged)),
            grouped(self.lines),
            if self.left.is_some() { "have left" } else { "acknowledged" },
            grouped(self.sent),
            duration(self.time_s)
        );
        if let Some(executed) = self.executed {
            let _ = writeln!(out, "carried out  {}", grouped(executed));
        }
        if let Some(lowest) = self.lowest {
            let _ = writeln!(out, "lowest fill  {lowest} lines");
        }
        if let Some([median, most, longest]) = self.delay_us {
            let _ = writeln!(
                out,
                "delay        {median:.0} µs in the middle, {most:.0} µs of 99 %, {longest:.0} µs at most"
            );
        }
        if self.repeats + self.stalls > 0 {
            let _ = writeln!(out, "trouble      {} lines sent again, {} times no answer", self.repeats, self.stalls);
        }
        out
    }
}

/// Something that happened.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Said {
    /// Version of this object.
    pub schema: u32,
    /// `said`, `holds`, `stalled`, `paused`, `repeated`, `sensors`, `shift`, `port`.
    pub event: FeedEvent,
    /// Time since the start.
    pub time_s: f64,
    /// The line that it is about.
    pub line: Option<u64>,
    /// In words.
    pub message: String,
}

/// How a job that was broken off is taken up again.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Plan {
    /// Version of this object.
    pub schema: u32,
    /// Its number: another journal or another place has another one.
    pub plan: String,
    /// The part program.
    pub program: String,
    /// How the job ended; `null` where the program that sent it died.
    pub ended: Option<String>,
    /// The last line that the control has acknowledged, and its line in the source.
    pub acknowledged: u64,
    /// The same in the source.
    pub acknowledged_line: Option<u32>,
    /// The last line that was carried out for sure.
    pub executed: u64,
    /// The same in the source.
    pub executed_line: Option<u32>,
    /// Blocks that the control may have taken and not carried out, at most; `null` where nobody knows.
    pub holds: Option<u64>,
    /// Where that comes from.
    pub holds_source: Option<String>,
    /// The last line that may have been sent.
    pub sent: u64,
    /// The same in the source.
    pub sent_line: Option<u32>,
    /// Line of the source at which it begins again.
    pub source_line: u32,
    /// Whether that is the beginning of the program.
    pub is_beginning: bool,
    /// How far the tool is above all that is machined before it moves across; `null` where nothing is machined.
    pub above_mm: Option<f64>,
    /// Why it is: behind this line of the source the state of the control cannot be rebuilt.
    pub unsure_line: Option<u32>,
    /// The tool that must be in the spindle.
    pub tool: Option<String>,
    /// What is sent before.
    pub before: Vec<String>,
    /// The first lines of the program that are sent.
    pub first: Vec<String>,
    /// The height over which the way leads, as it was given.
    pub clearance: Option<String>,
    /// The port.
    pub port: String,
}

impl Plan {
    /// The plan for people.
    #[must_use]
    pub fn table(&self, journal: &str) -> String {
        let mut out = String::new();
        let in_source = |line: Option<u32>| line.map_or(String::new(), |line| format!(" (line {line} of the source)"));
        let ended = self.ended.as_deref().unwrap_or("the sending program died");
        let _ = writeln!(out, "job           {}, broken off: {ended}", self.program);
        if self.executed > 0 {
            let _ = writeln!(out, "carried out   up to {}{} for sure", self.executed, in_source(self.executed_line));
        } else {
            let _ = writeln!(out, "carried out   nothing for sure");
        }
        let _ = writeln!(out, "acknowledged  up to {}{}", self.acknowledged, in_source(self.acknowledged_line));
        if self.acknowledged > self.executed {
            let _ = match (self.holds, &self.holds_source) {
                (Some(most), source) => {
                    let source = source.as_deref().unwrap_or_default();
                    writeln!(out, "              of these {most} blocks may not be carried out ({source})")
                }
                _ => writeln!(
                    out,
                    "              that says nothing of what was carried out: the control did not state how much it holds"
                ),
            };
        }
        if self.sent > self.executed {
            let [from, to] = [self.executed + 1, self.sent];
            let _ = writeln!(
                out,
                "unknown       {from} to {to}{}: carried out, in part, or not",
                in_source(self.sent_line)
            );
        }
        let place = if self.is_beginning { ", the beginning" } else { ", a rapid move" };
        let above = self.above_mm.map_or(String::new(), |mm| format!(", {mm:.1} mm above all that is machined"));
        let _ = writeln!(out, "begins again  at line {} of the source{place}{above}", self.source_line);
        if let Some(line) = self.unsure_line {
            let _ = writeln!(out, "              (behind line {line} the state of the control cannot be rebuilt)");
        }
        if let Some(tool) = &self.tool {
            let _ = writeln!(out, "tool          {tool} must be in the spindle");
        }
        for (name, lines) in [("before it", &self.before), ("then", &self.first)] {
            for (number, line) in lines.iter().enumerate() {
                let _ = writeln!(out, "{:<14}{line}", if number == 0 { name } else { "" });
            }
        }
        let _ = writeln!(
            out,
            "\nReset the control, so that its codes are those with which the job began; home the machine, look whether the zero point still holds, and see that\nthe first moves are free. No line goes out unless the control says that it is idle. Then:\n  ncfix resume {journal} --confirm {}{}",
            self.plan,
            self.clearance.as_ref().map_or(String::new(), |given| format!(" --clearance {given}"))
        );
        out
    }
}
