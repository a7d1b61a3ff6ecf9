//! Result of `ncfix max-step`: the answer, the table, the plot in the terminal and the JSON object.

use std::collections::BTreeMap;
use std::fmt::Write as _;

use serde::Serialize;

use super::json::DiagnosticReport;
use super::number::{counted, duration, grouped, micrometers};
use super::scale::Log;
use super::terminal::Colors;
use ncfix_base::geometry::AxisKey;

/// Width of the plot in columns.
const WIDTH: usize = 60;
/// Height of the plot in rows.
const HEIGHT: usize = 12;
/// Lower end of the residual axis as a share of the limit: smaller residuals are not of interest.
const SHARE_OF_LIMIT: f64 = 1e-3;
const GREEN: &str = "\u{1b}[32m";
const RED: &str = "\u{1b}[31m";
const DIM: &str = "\u{1b}[2m";
const PLAIN: &str = "\u{1b}[0m";

/// Answer of a step search.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum StepAnswer {
    /// Any step meets the limit.
    Any,
    /// Steps up to a length meet the limit.
    UpTo,
    /// No step meets the limit.
    None,
}

/// Output of `ncfix max-step`.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct StepReport {
    /// Answer; `null` if there is no result.
    pub answer: Option<StepAnswer>,
    /// Largest step that meets the residual limit.
    pub largest_step_mm: Option<f64>,
    /// Requested residual limit.
    pub residual_limit_um: f64,
    /// Largest residual at the answer.
    pub residual_um: f64,
    /// Place of the largest residual.
    pub worst: Option<Worst>,
    /// Series of steps.
    pub steps: Vec<StepRow>,
    /// Number of lines that were examined.
    pub lines: u64,
    /// Straight feed moves of the program, of which the most curved ones were examined.
    pub moves: Option<u64>,
    /// Arcs of the program, which are divided by the tolerance and were not examined.
    pub arcs: Option<u64>,
    /// Tool length; `null` if each move has that of the program.
    pub tool_length_mm: Option<f64>,
    /// Number of piece ends without a correction.
    pub failures: u64,
    /// Wall time of the run.
    pub seconds: f64,
    /// Name of the machine.
    pub machine: String,
    /// Diagnostics.
    pub diagnostics: Vec<DiagnosticReport>,
}

/// Place of the largest residual. Keys carry the unit: `X_mm`, `C_deg`.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Worst {
    /// Position.
    pub at: BTreeMap<AxisKey, f64>,
    /// Start of the line.
    pub from: BTreeMap<AxisKey, f64>,
    /// End of the line.
    pub to: BTreeMap<AxisKey, f64>,
    /// File of the move.
    pub file: Option<String>,
    /// Line of the move.
    pub line: Option<u32>,
}

/// Step of the series.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct StepRow {
    /// Step along the axis that moves farthest.
    pub step_mm: f64,
    /// Residual of this step.
    pub residual_um: f64,
    /// Largest residual of this step and all smaller ones.
    pub largest_um: f64,
}

impl StepReport {
    /// Returns the page for people; it contains colors, which the caller strips if they are not shown.
    #[must_use]
    pub fn page(&self, colors: Colors) -> String {
        let mut out = String::new();
        // Writing into a String cannot fail.
        let _ = writeln!(out, "{:>12}{:>14}", "step", "residual");
        for row in &self.steps {
            let mark = if row.largest_um > self.residual_limit_um { "  >" } else { "" };
            let _ = writeln!(out, "{:>9} mm{:>14}{mark}", three_digits(row.step_mm), micrometers(row.largest_um));
        }
        out.push('\n');
        if let Some(plot) = self.plot(colors) {
            out.push_str(&plot);
            out.push('\n');
        }
        out.push_str(&self.summary());
        out
    }

    /// Returns the rows below the plot.
    fn summary(&self) -> String {
        let mut out = String::new();
        let mut row = |name: &str, text: &str| {
            let _ = writeln!(out, "{name:<13}{text}");
        };
        row("largest step", &self.answer_text());
        for (name, text) in self.entries() {
            row(name, &text);
        }
        row("computed", &format!("in {}", duration(self.seconds)));
        row("machine", &self.machine);
        out
    }

    /// Returns further results, in addition to the answer.
    pub(super) fn entries(&self) -> Vec<(&'static str, String)> {
        let mut entries = Vec::new();
        let mut row = |name: &'static str, text: &str| entries.push((name, text.to_owned()));
        if let Some(worst) = self.worst.as_ref().filter(|_| self.residual_um > 0.0) {
            row("residual", &format!("{} at {}", micrometers(self.residual_um), place(&worst.at)));
            let line = match (&worst.file, worst.line) {
                (Some(file), Some(line)) => format!("{file}:{line}, "),
                _ => String::new(),
            };
            row("on the line", &format!("{line}{} to {}", place(&worst.from), place(&worst.to)));
        }
        let tool = self.tool_length_mm.map_or("as in the program".into(), |length| format!("{} mm", decimal(length)));
        row("tool length", &tool);
        let looked_at = match self.moves {
            None => format!("{} through the travel", grouped(self.lines)),
            Some(moves) => {
                let arcs = match self.arcs {
                    None | Some(0) => String::new(),
                    Some(arcs) => format!("; {}, cut by the tolerance, omitted", counted(arcs, "arc")),
                };
                format!(
                    "{} of {} straight moves with feed, those with the largest curvature{arcs}",
                    grouped(self.lines),
                    grouped(moves)
                )
            }
        };
        row("lines", &looked_at);
        if self.failures > 0 {
            row("left out", &format!("{} without a correction", counted(self.failures, "piece")));
        }
        entries
    }

    pub(super) fn answer_text(&self) -> String {
        let limit = micrometers(self.residual_limit_um);
        match (self.answer, self.largest_step_mm) {
            (Some(StepAnswer::UpTo), Some(step)) => format!("{} mm for {limit}", rounded_down(step)),
            (Some(StepAnswer::Any), _) if self.lines == 0 => "any: there is no straight move with feed to cut".into(),
            (Some(StepAnswer::Any), _) if self.residual_um == 0.0 => {
                "any: no line bends (errors that are constant, or depend only on the direction of motion, bend no line)"
                    .into()
            }
            (Some(StepAnswer::Any), _) => format!("any: every line is within {limit} even as one piece"),
            _ => {
                let smallest = self.steps.first().map_or(0.0, |row| row.step_mm);
                format!("none: the residual at {} mm is already more than {limit}", three_digits(smallest))
            }
        }
    }

    /// Returns the scales of steps and residuals; `None` if there is nothing to draw.
    pub(super) fn scales(&self) -> Option<(Log, Log)> {
        let (first, last) = (self.steps.first()?, self.steps.last()?);
        if last.largest_um <= 0.0 || first.step_mm >= last.step_mm {
            return None;
        }
        let least = self.steps.iter().map(|row| row.largest_um).find(|&um| um > 0.0)?;
        let low = least.max(self.residual_limit_um * SHARE_OF_LIMIT).min(self.residual_limit_um);
        let high = last.largest_um.max(self.residual_limit_um);
        Some((Log::new(first.step_mm, last.step_mm), Log::new(low, high).to_decades()))
    }

    /// Returns the plot of the residual over the step, both logarithmic, with the limit as a line.
    fn plot(&self, colors: Colors) -> Option<String> {
        const BLOCKS: [char; 9] = [' ', '▁', '▂', '▃', '▄', '▅', '▆', '▇', '█'];
        let (steps, residuals) = self.scales()?;
        let values: Vec<f64> =
            (0..WIDTH).map(|column| self.between(steps.value((column as f64 + 0.5) / WIDTH as f64))).collect();
        let limit_row = (residuals.share(self.residual_limit_um) * HEIGHT as f64).floor().min(HEIGHT as f64 - 1.0);
        let mut out = String::new();
        let _ = writeln!(out, "{:>9} residual", "µm");
        for row in (0..HEIGHT).rev() {
            let bottom = row as f64;
            let label = residuals.decade_in(bottom / HEIGHT as f64, (bottom + 1.0) / HEIGHT as f64);
            let _ = write!(out, "{:>9} ", label.map_or(String::new(), decimal));
            out.push(if label.is_some() { '┤' } else { '│' });
            let cells = values.iter().map(|&value| {
                let filled = ((residuals.share(value) * HEIGHT as f64 - bottom) * 8.0).clamp(0.0, 8.0);
                // Between 0 and 8.
                match BLOCKS.get(filled.round() as usize) {
                    None | Some(' ') if bottom == limit_row => ('╌', DIM),
                    None | Some(' ') => (' ', ""),
                    Some(&block) if value <= self.residual_limit_um => (block, GREEN),
                    Some(&block) => (block, RED),
                }
            });
            push_painted(&mut out, cells, colors);
            out.push_str(if bottom == limit_row { " limit\n" } else { "\n" });
        }
        let _ = writeln!(out, "{:>10}└{}", "", "─".repeat(WIDTH));
        let mut marks = vec![' '; WIDTH + 12];
        for step in steps.marks() {
            // Within the width.
            let column = (steps.share(step) * WIDTH as f64) as usize;
            for (offset, character) in decimal(step).chars().enumerate() {
                if let Some(place) = marks.get_mut(column + offset) {
                    *place = character;
                }
            }
        }
        let marks: String = marks.into_iter().collect();
        let _ = writeln!(out, "{:>11}{} mm step", "", marks.trim_end());
        Some(out)
    }

    /// Returns the largest residual at a step between those of the series.
    fn between(&self, step_mm: f64) -> f64 {
        let after = self.steps.partition_point(|row| row.step_mm < step_mm);
        let before = after.checked_sub(1).and_then(|before| self.steps.get(before));
        match (before, self.steps.get(after)) {
            (Some(low), Some(high)) if low.largest_um > 0.0 => {
                let share = (step_mm / low.step_mm).ln() / (high.step_mm / low.step_mm).ln();
                low.largest_um * (high.largest_um / low.largest_um).powf(share)
            }
            (Some(row), _) | (None, Some(row)) => row.largest_um,
            (None, None) => 0.0,
        }
    }
}

/// Appends characters with their colors; consecutive ones of one color share a sequence, and trailing spaces are omitted.
fn push_painted(out: &mut String, cells: impl Iterator<Item = (char, &'static str)>, colors: Colors) {
    let mut cells: Vec<(char, &str)> = cells.collect();
    while cells.pop_if(|(character, _)| *character == ' ').is_some() {}
    for run in cells.chunk_by(|a, b| a.1 == b.1) {
        let text = run.iter().map(|(character, _)| *character);
        match run.first() {
            Some((_, color)) if colors == Colors::Ansi && !color.is_empty() => {
                out.push_str(color);
                out.extend(text);
                out.push_str(PLAIN);
            }
            _ => out.extend(text),
        }
    }
}

/// `X10.5 Z-3 C90°`.
fn place(position: &BTreeMap<AxisKey, f64>) -> String {
    let mut parts: Vec<(bool, String)> = position
        .iter()
        .map(|(key, &value)| {
            let number = decimal((value * 1e3).round() / 1e3);
            (key.is_rotary(), format!("{}{number}{}", key.letter(), key.suffix()))
        })
        .collect();
    parts.sort_by_key(|(is_rotary, _)| *is_rotary);
    parts.into_iter().map(|(_, text)| text).collect::<Vec<_>>().join(" ")
}

/// Formats a number without trailing zeros.
pub(super) fn decimal(value: f64) -> String {
    let text = format!("{value:.6}");
    let text = text.trim_end_matches('0').trim_end_matches('.');
    if text == "-0" { "0".into() } else { text.to_owned() }
}

/// Formats three significant digits.
pub(super) fn three_digits(value: f64) -> String {
    let decimals = if value < 9.995 { 2 } else { usize::from(value < 99.95) };
    format!("{value:.decimals$}")
}

/// Formats three significant digits, rounded down.
pub(super) fn rounded_down(value: f64) -> String {
    let unit = if value < 10.0 {
        0.01
    } else if value < 100.0 {
        0.1
    } else {
        1.0
    };
    decimal((value / unit).floor() * unit)
}

#[cfg(test)]
mod tests {
    use super::*;
    use ncfix_base::geometry::Axis;

    fn parabola() -> StepReport {
        // s² / 80 µm: 20 mm for 5 µm.
        let row = |step_mm: f64| {
            let residual_um = step_mm * step_mm / 80.0;
            StepRow { step_mm, residual_um, largest_um: residual_um }
        };
        StepReport {
            answer: Some(StepAnswer::UpTo),
            largest_step_mm: Some(20.0),
            residual_limit_um: 5.0,
            residual_um: 4.99,
            worst: Some(Worst {
                at: [(AxisKey::of_position(Axis::X), 10.0), (AxisKey::of_position(Axis::B), -3.5)].into(),
                from: [(AxisKey::of_position(Axis::X), 0.0)].into(),
                to: [(AxisKey::of_position(Axis::X), 400.0)].into(),
                file: Some("a.mpf".into()),
                line: Some(7),
            }),
            steps: [1.0, 2.0, 5.0, 10.0, 20.0, 40.0, 100.0, 400.0].map(row).to_vec(),
            lines: 2,
            moves: Some(1234),
            arcs: Some(5),
            tool_length_mm: Some(138.9),
            seconds: 0.5,
            machine: "demo".into(),
            ..StepReport::default()
        }
    }

    #[test]
    fn the_page_has_table_plot_and_answer() {
        insta::assert_snapshot!(parabola().page(Colors::Plain), @r"
                step      residual
             1.00 mm      0.013 µm
             2.00 mm      0.050 µm
             5.00 mm      0.312 µm
             10.0 mm       1.25 µm
             20.0 mm       5.00 µm
             40.0 mm       20.0 µm  >
              100 mm        125 µm  >
              400 mm       2000 µm  >

               µm residual
                  │
             1000 ┤                                                         ▁▃▄
                  │                                                   ▁▂▄▅▇████
              100 ┤                                             ▁▂▃▅▆██████████
                  │                                        ▂▃▅▆▇███████████████
               10 ┤                                  ▁▃▄▆▇█████████████████████
                  │╌╌╌╌╌╌╌╌╌╌╌╌╌╌╌╌╌╌╌╌╌╌╌╌╌╌╌╌▁▂▄▅▇███████████████████████████ limit
                1 ┤                      ▁▂▄▅▆█████████████████████████████████
                  │                 ▂▃▅▆▇██████████████████████████████████████
              0.1 ┤           ▂▃▄▆▇████████████████████████████████████████████
                  │     ▁▃▄▅▇██████████████████████████████████████████████████
             0.01 ┤▂▄▅▆████████████████████████████████████████████████████████
                  └────────────────────────────────────────────────────────────
                   1     2         5      10     20       50     100    200 mm step

        largest step 20 mm for 5.00 µm
        residual     4.99 µm at X10 B-3.5°
        on the line  a.mpf:7, X0 to X400
        tool length  138.9 mm
        lines        2 of 1,234 straight moves with feed, those with the largest curvature; 5 arcs, cut by the tolerance, omitted
        computed     in 0.50 s
        machine      demo
        ");
    }

    #[test]
    fn colors_are_added_only_where_they_are_wanted() {
        let report = parabola();
        assert!(!report.page(Colors::Plain).contains('\u{1b}'));
        assert!(report.page(Colors::Ansi).contains(GREEN) && report.page(Colors::Ansi).contains(RED));
    }

    #[test]
    fn the_answer_is_never_rounded_up() {
        assert_eq!(rounded_down(19.999), "19.9");
        assert_eq!(rounded_down(9.876), "9.87");
        assert_eq!(rounded_down(123.9), "123");
    }

    #[test]
    fn nothing_is_drawn_of_a_residual_of_zero() {
        let mut report = parabola();
        report.steps.iter_mut().for_each(|row| row.largest_um = 0.0);
        assert_eq!(report.plot(Colors::Plain), None);
        assert_eq!(StepReport::default().plot(Colors::Plain), None);
    }
}
