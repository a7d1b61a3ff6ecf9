//! Output of `ncfix diff`: the summary, a row for every changed move, and the JSON object.

use std::collections::BTreeMap;
use std::fmt::Write as _;

use serde::Serialize;

use super::correction::error_rows;
use super::coverage::CoverageReport;
use super::json::{DiagnosticReport, SpreadReport, ZeroReport};
use super::number::{counted, grouped, micrometers, significant};
use super::prediction::PredictionReport;
use super::verdict::{Verdict, left_in_words};
use ncfix_base::units::UnitKey;

/// Output of `ncfix diff`.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Review {
    /// Version of this object.
    pub schema: u32,
    /// True if nothing differs by more than the tolerance.
    pub same: bool,
    /// `executed`, or `text` if the words were compared as written.
    pub compared: &'static str,
    /// Names of the original and of the corrected program.
    pub files: [String; 2],
    /// Their sizes in bytes.
    pub bytes: [u64; 2],
    /// Moves of the original and pieces of the corrected program.
    pub moves: [u64; 2],
    /// Number of changed moves.
    pub changed: u64,
    /// Number of moves that were split into several pieces.
    pub split: u64,
    /// Number of unchanged moves, by reason.
    pub left: BTreeMap<&'static str, u64>,
    /// Number of pieces with another feed.
    pub other_feeds: u64,
    /// Smallest and largest feed of these pieces as a share of the original feed.
    pub feed_share: Option<[f64; 2]>,
    /// Pieces that end beyond the travel of an axis.
    pub beyond_travel: BTreeMap<String, Beyond>,
    /// Correction added by axis: X … in µm, A … in µrad.
    pub axes: BTreeMap<String, AxisSummary>,
    /// Largest change from one piece to the next, µm, and its place.
    pub largest_step: Option<LargestStep>,
    /// Length of the longest line of the corrected program, in bytes, and its number.
    pub longest_line: [u64; 2],
    /// Errors of the original program on the error model.
    pub before: Option<SpreadReport>,
    /// Errors of the original program, beyond the constant displacement that a touched zero offset takes up.
    pub before_form: Option<SpreadReport>,
    /// Zero offsets in which axes move.
    pub zeros: Vec<ZeroReport>,
    /// Errors of the corrected program on the error model.
    pub after: Option<SpreadReport>,
    /// Tip displacement by which the increments of the corrected program round its positions, µm; 0 if unknown.
    #[serde(skip)]
    pub rounding_um: f64,
    /// Limits, and whether they are met.
    pub limits: Vec<Limit>,
    /// Coverage by the measured ranges of the machine; `null` if the programs were not compared.
    pub coverage: Option<CoverageReport>,
    /// Intervals of the true errors; `null` if the text was compared or the machine file has no errors.
    pub prediction: Option<PredictionReport>,
    /// Verdict on running it, with reasons.
    pub verdict: Verdict,
    /// Provenance: versions and hashes.
    pub provenance: BTreeMap<&'static str, String>,
    /// Requested rows.
    pub rows: Vec<ChangedMove>,
    /// Number of changed moves that are not among the rows.
    pub more_rows: u64,
    /// Diagnostics.
    pub diagnostics: Vec<DiagnosticReport>,
}

/// Correction added to an axis.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[expect(missing_docs, reason = "the names say it")]
pub struct AxisSummary {
    pub unit: UnitKey,
    pub max: f64,
    pub max_line: u32,
    /// File of that line, if it is a subprogram.
    pub max_file: Option<String>,
    pub mean: f64,
    pub rms: f64,
    pub p99: f64,
}

/// Pieces beyond the travel of an axis.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Beyond {
    /// Number of pieces.
    pub pieces: u64,
    /// Line of the corrected program of the first one.
    pub line: u32,
}

/// Largest change from one piece to the next.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[expect(missing_docs, reason = "the names say it")]
pub struct LargestStep {
    pub um: f64,
    pub line: u32,
    /// File of that line, if it is a subprogram.
    pub file: Option<String>,
}

/// Limit.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[expect(missing_docs, reason = "the names say it")]
pub struct Limit {
    pub name: String,
    pub value_um: f64,
    pub limit_um: f64,
    pub is_kept: bool,
}

/// Changed move.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct ChangedMove {
    /// Line of the original.
    pub line: u32,
    /// File of the line, if it is a subprogram.
    pub file: Option<String>,
    /// Block number, such as `N120`; empty for a block without a number.
    pub number: String,
    /// First and last line of the corrected program.
    pub corrected: [u32; 2],
    /// Number of pieces.
    pub pieces: u64,
    /// Its changed axes.
    pub words: Vec<Changed>,
    /// Number of moves before this one that are not changed or not shown.
    pub folded: u64,
}

/// Changed word.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Changed {
    /// Axis.
    pub axis: String,
    /// Value in the original, or the value it would have there as a number; empty if it is not known.
    pub before: String,
    /// Value in the corrected program.
    pub after: String,
    /// Correction added, in `unit`.
    pub added: f64,
    /// Its unit.
    pub unit: UnitKey,
}

/// Width of a changed word, with the space after it.
const WORD: usize = 35;
/// Width of a number.
const NUMBER: usize = 9;
/// Width of the part before the words.
const HEAD: usize = 10;

/// Appearance of a page.
#[derive(Clone, Copy, Debug)]
pub struct TerminalStyle {
    /// Width of the terminal in columns.
    pub width: usize,
    /// True if changed digits are colored.
    pub has_color: bool,
}

impl Review {
    /// Adds diagnostics that it does not have yet, and renews the verdict.
    pub fn take_in(&mut self, diagnostics: Vec<DiagnosticReport>) {
        for one in diagnostics {
            if !self.diagnostics.iter().any(|known| known.code == one.code && known.message == one.message) {
                self.diagnostics.push(one);
            }
        }
        self.verdict = Verdict::of(self);
    }

    /// Returns the summary.
    #[must_use]
    pub fn summary(&self) -> String {
        // Diagnostics are printed separately above, and errors below.
        let mut out = self.verdict.rows();
        let mut row = |name: &str, text: &str| {
            let _ = writeln!(out, "{name:<13}{text}");
        };
        let share = 100.0 * self.changed as f64 / (self.moves[0].max(1)) as f64;
        let [moves, pieces] = self.moves.map(grouped);
        row("moves", &format!("{moves} in the original, {pieces} in the corrected program"));
        let (changed, split) = (grouped(self.changed), grouped(self.split));
        row("changed", &format!("{changed} ({share:.1} %), {split} of them in several pieces"));
        if !self.left.is_empty() {
            let left: Vec<String> =
                self.left.iter().map(|(why, count)| format!("{} {}", grouped(*count), left_in_words(why))).collect();
            row("left alone", &left.join(", "));
        }
        if self.other_feeds > 0 {
            let by = self.feed_share.map_or_else(String::new, |[least, most]| {
                format!(", {:+.1} % to {:+.1} %", 100.0 * (least - 1.0), 100.0 * (most - 1.0))
            });
            row("feed", &format!("{} with another feed{by}", counted(self.other_feeds, "piece")));
        }
        let [before, after] = self.bytes;
        let growth = 100.0 * (after as f64 - before as f64) / before.max(1) as f64;
        row("size", &format!("{} → {} bytes ({growth:+.0} %)", grouped(before), grouped(after)));
        let [length, line] = self.longest_line;
        row("longest line", &format!("{length} bytes, line {line} of the corrected program"));
        if let Some(step) = &self.largest_step {
            let at = place(step.line, Some(step.file.as_deref().unwrap_or("the original")));
            row("largest step", &format!("{} from one piece to the next, at {at}", micrometers(step.um)));
        }
        if !self.axes.is_empty() {
            out.push_str("\n  axis        max    at line       mean        RMS       99 %\n");
        }
        for (axis, one) in &self.axes {
            let [max, mean] = [one.max, one.mean].map(signed);
            let [rms, p99] = [one.rms, one.p99].map(significant);
            let (unit, line) = (one.unit.sign(), one.max_line);
            let file = one.max_file.as_ref().map_or(String::new(), |file| format!("  line {line} is in {file}"));
            let _ = writeln!(out, "  {axis:<4} {max:>10} {line:>10} {mean:>10} {rms:>10} {p99:>10}  {unit}{file}");
        }
        if let (Some(before), Some(after)) = (self.before, self.after) {
            out.push('\n');
            out.push_str(&error_rows(before, after, None));
            out.push_str(&self.prediction.as_ref().map_or_else(String::new, PredictionReport::rows));
        }
        out
    }
}

/// Formats a place: `line 17`, `line 17 of HOLE.SPF`.
#[must_use]
pub fn place(line: u32, file: Option<&str>) -> String {
    file.map_or_else(|| format!("line {line}"), |file| format!("line {line} of {file}"))
}

/// Formats a number with its sign.
fn signed(value: f64) -> String {
    format!("{}{}", if value > 0.0 { "+" } else { "" }, significant(value))
}

impl ChangedMove {
    /// Returns the row for a terminal, with a line feed after every line.
    #[must_use]
    pub fn line(&self, style: &TerminalStyle) -> String {
        let mut out = String::new();
        if self.folded > 0 {
            let _ = writeln!(out, "{:HEAD$}… {} not changed", "", grouped(self.folded));
        }
        let name = if self.number.is_empty() { format!("L{}", self.line) } else { self.number.clone() };
        let split = if self.pieces > 1 { format!("1:{}", self.pieces) } else { String::new() };
        let head = match &self.file {
            Some(file) => format!("{file} {name} {split}"),
            None if split.is_empty() => name,
            None => format!("{name} {split}"),
        };
        let _ = write!(out, "{head:<HEAD$}");
        if head.chars().count() >= HEAD {
            let _ = write!(out, "\n{:HEAD$}", "");
        }
        let mut at = HEAD;
        for word in &self.words {
            let (cell, width) = word.cell(style);
            if at > HEAD && at + width > style.width {
                out.truncate(out.trim_end().len());
                let _ = write!(out, "\n{:HEAD$}", "");
                at = HEAD;
            }
            out.push_str(&cell);
            let space = WORD.saturating_sub(width).max(1);
            out.extend(std::iter::repeat_n(' ', space));
            at += width + space;
        }
        let end = out.trim_end().len();
        out.truncate(end);
        out.push('\n');
        out
    }
}

impl Changed {
    /// Returns `X     10.000 → 10.0123    (+12.3 µm)`, and its width.
    fn cell(&self, style: &TerminalStyle) -> (String, usize) {
        let blanks = " ".repeat(NUMBER.saturating_sub(self.after.chars().count()));
        let added = significant(self.added);
        let added = if added.contains('.') { added.trim_end_matches('0').trim_end_matches('.') } else { &added };
        let sign = if self.added > 0.0 { "+" } else { "" };
        let text = |after: &str| {
            let (axis, before, unit) = (&self.axis, &self.before, self.unit.sign());
            format!("{axis:<2}{before:>NUMBER$} → {after}{blanks} ({sign}{added} {unit})")
        };
        (text(&self.colored(style)), text(&self.after).chars().count())
    }

    /// Returns the new number with its changed digits in color.
    fn colored(&self, style: &TerminalStyle) -> String {
        const ON: &str = "\u{1b}[33m";
        const OFF: &str = "\u{1b}[0m";
        let same = self.before.bytes().zip(self.after.bytes()).take_while(|(before, after)| before == after).count();
        match self.after.split_at_checked(same) {
            Some((kept, other)) if style.has_color && !other.is_empty() => format!("{kept}{ON}{other}{OFF}"),
            _ => self.after.clone(),
        }
    }
}

/// Output of `ncfix diff --text`.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct TextReview {
    /// Version of this object.
    pub schema: u32,
    /// True if the programs are equivalent.
    pub same: bool,
    /// Always `text`.
    pub compared: &'static str,
    /// Names of both programs.
    pub files: [String; 2],
    /// Number of equivalent lines.
    pub same_lines: u64,
    /// Number of lines with other numbers.
    pub changed: u64,
    /// Number of lines that only the first program has.
    pub gone: u64,
    /// Number of lines that only the second program has.
    pub new: u64,
    /// Changes of the numbers by address, in the unit of the programs.
    pub words: BTreeMap<String, WordFigures>,
    /// Requested rows.
    pub rows: Vec<TextLine>,
    /// Number of different lines that are not among the rows.
    pub more_rows: u64,
}

/// Changes of the numbers of an address.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[expect(missing_docs, reason = "the names say it")]
pub struct WordFigures {
    pub count: u64,
    pub max: f64,
    pub max_line: u32,
}

/// Line that differs: its line numbers in both programs, and its words, or its text if the other program lacks it.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[expect(missing_docs, reason = "the names say it")]
pub struct TextLine {
    pub lines: [Option<u32>; 2],
    pub words: Vec<TextWord>,
    pub text: String,
}

/// Word with another number.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[expect(missing_docs, reason = "the names say it")]
pub struct TextWord {
    pub address: String,
    pub before: String,
    pub after: String,
    pub added: f64,
}

impl TextReview {
    /// Returns the summary.
    #[must_use]
    pub fn summary(&self) -> String {
        let mut out = String::new();
        let [same, changed, gone, new] = [self.same_lines, self.changed, self.gone, self.new].map(grouped);
        let _ = writeln!(out, "lines        {same} the same, {changed} with other numbers, {gone} removed, {new} new");
        for (address, one) in &self.words {
            let _ = writeln!(
                out,
                "  {address:<4} {:>9} times, by up to {:+.6} at line {} of the original",
                grouped(one.count),
                one.max,
                one.max_line
            );
        }
        out
    }
}

impl TextLine {
    /// Returns the row for a terminal, with a line feed after every line.
    #[must_use]
    pub fn line(&self, style: &TerminalStyle) -> String {
        let name = match self.lines {
            [Some(one), _] => format!("L{one}"),
            [None, other] => format!("new L{}", other.unwrap_or(0)),
        };
        let mut out = format!("{name:<HEAD$}");
        if self.words.is_empty() {
            let sign = if self.lines[0].is_some() { '-' } else { '+' };
            let _ = write!(out, "{sign} {}", self.text);
        }
        let mut at = HEAD;
        for word in &self.words {
            let cell =
                format!("{:<2}{:>NUMBER$} → {:<NUMBER$} ({:+.4})", word.address, word.before, word.after, word.added);
            let width = cell.chars().count() + 2;
            if at > HEAD && at + width > style.width {
                let _ = write!(out, "\n{:HEAD$}", "");
                at = HEAD;
            }
            let _ = write!(out, "{cell}  ");
            at += width;
        }
        out.truncate(out.trim_end().len());
        out.push('\n');
        out
    }
}
