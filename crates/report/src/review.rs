//! What `ncfix diff` says: the summary, a row for every move that is changed, and the object for programs.

use std::collections::BTreeMap;
use std::fmt::Write as _;

use serde::Serialize;

use super::correction::error_rows;
use super::json::{Finding, Spread};
use super::number::{grouped, micrometers, significant};
use super::verdict::Verdict;
use ncfix_base::units::UnitKey;

/// The result of `ncfix diff`.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Review {
    /// Version of this object.
    pub schema: u32,
    /// Whether nothing is changed by more than the tolerance.
    pub same: bool,
    /// `executed`, or `text` where the words were compared as they are written.
    pub compared: &'static str,
    /// Names of the original and of the corrected program.
    pub files: [String; 2],
    /// Their sizes in bytes.
    pub bytes: [u64; 2],
    /// Moves of the original and pieces of the corrected program.
    pub moves: [u64; 2],
    /// Moves that are changed.
    pub changed: u64,
    /// Moves of several pieces.
    pub split: u64,
    /// Moves that are left as they are, by reason.
    pub left: BTreeMap<&'static str, u64>,
    /// Pieces with another feed, and the smallest and the largest of them as a share of what it was.
    pub other_feeds: u64,
    /// See `other_feeds`.
    pub feed_share: Option<[f64; 2]>,
    /// Pieces that end beyond the travel of an axis.
    pub beyond_travel: BTreeMap<String, Beyond>,
    /// What was added, by axis: X … in µm, A … in µrad.
    pub axes: BTreeMap<String, Figures>,
    /// The largest change from one piece to the next, µm, and where.
    pub largest_step: Option<Step>,
    /// The longest line of the corrected program, in bytes, and its number.
    pub longest_line: [u64; 2],
    /// Errors of the original and of the corrected program on the error model.
    pub before: Option<Spread>,
    /// See `before`.
    pub after: Option<Spread>,
    /// Limits, and whether they are kept.
    pub limits: Vec<Limit>,
    /// Whether it should run, and why.
    pub verdict: Verdict,
    /// Where all this comes from: versions and hashes.
    pub provenance: BTreeMap<&'static str, String>,
    /// The rows that were asked for.
    pub rows: Vec<Row>,
    /// Moves that are changed and are not among the rows.
    pub more_rows: u64,
    /// Findings.
    pub diagnostics: Vec<Finding>,
}

/// What was added to an axis.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[expect(missing_docs, reason = "the names say it")]
pub struct Figures {
    pub unit: UnitKey,
    pub max: f64,
    pub max_line: u32,
    /// The file of that line, where it is a subprogram.
    pub max_file: Option<String>,
    pub mean: f64,
    pub rms: f64,
    pub p99: f64,
}

/// Pieces beyond the travel of an axis.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Beyond {
    /// How many.
    pub pieces: u64,
    /// The line of the corrected program of the first of them.
    pub line: u32,
}

/// The largest change from one piece to the next.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[expect(missing_docs, reason = "the names say it")]
pub struct Step {
    pub um: f64,
    pub line: u32,
    /// The file of that line, where it is a subprogram.
    pub file: Option<String>,
}

/// A limit.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[expect(missing_docs, reason = "the names say it")]
pub struct Limit {
    pub name: String,
    pub value_um: f64,
    pub limit_um: f64,
    pub is_kept: bool,
}

/// A move that is changed.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Row {
    /// Line of the original, and its file where that is a subprogram.
    pub line: u32,
    /// See `line`.
    pub file: Option<String>,
    /// `N120`; empty for a block without a number.
    pub number: String,
    /// First and last line of the corrected program.
    pub corrected: [u32; 2],
    /// Pieces.
    pub pieces: u64,
    /// Its axes that are changed.
    pub words: Vec<Changed>,
    /// Moves that are not changed, or not shown, before this one.
    pub folded: u64,
}

/// A word that is changed.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Changed {
    /// The axis.
    pub axis: String,
    /// As it is in the original, or would be there if it were a number; empty where it is not known.
    pub before: String,
    /// As it is in the corrected program.
    pub after: String,
    /// What was added, in `unit`.
    pub added: f64,
    /// Its unit.
    pub unit: UnitKey,
}

/// Width of a word that is changed, with the space behind it.
const WORD: usize = 35;
/// Width of a number.
const NUMBER: usize = 9;
/// Width of what stands before the words.
const HEAD: usize = 10;

/// How a page is drawn.
#[derive(Clone, Copy, Debug)]
pub struct Look {
    /// Columns of the terminal.
    pub width: usize,
    /// Whether digits that are changed have a color.
    pub has_color: bool,
}

impl Review {
    /// The summary.
    #[must_use]
    pub fn summary(&self) -> String {
        // Findings stand above by themselves, and errors below.
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
            let left: Vec<String> = self.left.iter().map(|(why, count)| format!("{} {why}", grouped(*count))).collect();
            row("left alone", &left.join(", "));
        }
        if self.other_feeds > 0 {
            let by = self.feed_share.map_or_else(String::new, |[least, most]| {
                format!(", {:+.1} % to {:+.1} %", 100.0 * (least - 1.0), 100.0 * (most - 1.0))
            });
            row("feed", &format!("{} pieces with another feed{by}", grouped(self.other_feeds)));
        }
        let [before, after] = self.bytes;
        let growth = 100.0 * (after as f64 - before as f64) / before.max(1) as f64;
        row("size", &format!("{} → {} bytes ({growth:+.0} %)", grouped(before), grouped(after)));
        let [length, line] = self.longest_line;
        row("longest line", &format!("{length} bytes, line {line} of the corrected program"));
        if let Some(step) = &self.largest_step {
            let at = place(step.line, step.file.as_deref());
            row("largest step", &format!("{} from one piece to the next, at {at}", micrometers(step.um)));
        }
        if !self.axes.is_empty() {
            out.push_str("\n  axis        max    at line       mean        RMS       99 %\n");
        }
        for (axis, one) in &self.axes {
            let [max, mean] = [one.max, one.mean].map(signed);
            let [rms, p99] = [one.rms, one.p99].map(significant);
            let (unit, line) = (one.unit.sign(), one.max_line);
            let file = one.max_file.as_ref().map_or(String::new(), |file| format!("  line {line} is of {file}"));
            let _ = writeln!(out, "  {axis:<4} {max:>10} {line:>10} {mean:>10} {rms:>10} {p99:>10}  {unit}{file}");
        }
        if let (Some(before), Some(after)) = (self.before, self.after) {
            out.push('\n');
            out.push_str(&error_rows(before, after, None));
        }
        out
    }
}

/// `line 17`, `line 17 of HOLE.SPF`.
#[must_use]
pub fn place(line: u32, file: Option<&str>) -> String {
    file.map_or_else(|| format!("line {line}"), |file| format!("line {line} of {file}"))
}

/// A number with its sign.
fn signed(value: f64) -> String {
    format!("{}{}", if value > 0.0 { "+" } else { "" }, significant(value))
}

impl Row {
    /// The row for a terminal, with a line feed behind every line.
    #[must_use]
    pub fn line(&self, look: &Look) -> String {
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
            let (cell, width) = word.cell(look);
            if at > HEAD && at + width > look.width {
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
    /// `X     10.000 → 10.0123    (+12.3 µm)`, and its width.
    fn cell(&self, look: &Look) -> (String, usize) {
        let blanks = " ".repeat(NUMBER.saturating_sub(self.after.chars().count()));
        let added = significant(self.added);
        let added = if added.contains('.') { added.trim_end_matches('0').trim_end_matches('.') } else { &added };
        let sign = if self.added > 0.0 { "+" } else { "" };
        let text = |after: &str| {
            let (axis, before, unit) = (&self.axis, &self.before, self.unit.sign());
            format!("{axis:<2}{before:>NUMBER$} → {after}{blanks} ({sign}{added} {unit})")
        };
        (text(&self.colored(look)), text(&self.after).chars().count())
    }

    /// The new number, its digits that are others in color.
    fn colored(&self, look: &Look) -> String {
        const ON: &str = "\u{1b}[33m";
        const OFF: &str = "\u{1b}[0m";
        let same = self.before.bytes().zip(self.after.bytes()).take_while(|(before, after)| before == after).count();
        match self.after.split_at_checked(same) {
            Some((kept, other)) if look.has_color && !other.is_empty() => format!("{kept}{ON}{other}{OFF}"),
            _ => self.after.clone(),
        }
    }
}

/// The result of `ncfix diff --text`.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct TextReview {
    /// Version of this object.
    pub schema: u32,
    /// Whether the programs say the same.
    pub same: bool,
    /// `text`.
    pub compared: &'static str,
    /// Names of both programs.
    pub files: [String; 2],
    /// Lines that say the same.
    pub same_lines: u64,
    /// Lines with other numbers.
    pub changed: u64,
    /// Lines of the first program alone, and of the second.
    pub gone: u64,
    /// See `gone`.
    pub new: u64,
    /// What became of the numbers, by address, in the unit of the programs.
    pub words: BTreeMap<String, WordFigures>,
    /// The rows that were asked for.
    pub rows: Vec<TextLine>,
    /// Lines that differ and are not among the rows.
    pub more_rows: u64,
}

/// What became of the numbers of an address.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[expect(missing_docs, reason = "the names say it")]
pub struct WordFigures {
    pub count: u64,
    pub max: f64,
    pub max_line: u32,
}

/// A line that differs: its numbers in both programs, and its words, or its text where the other program lacks it.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[expect(missing_docs, reason = "the names say it")]
pub struct TextLine {
    pub lines: [Option<u32>; 2],
    pub words: Vec<TextWord>,
    pub text: String,
}

/// A word with another number.
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
    /// The summary.
    #[must_use]
    pub fn summary(&self) -> String {
        let mut out = String::new();
        let [same, changed, gone, new] = [self.same_lines, self.changed, self.gone, self.new].map(grouped);
        let _ = writeln!(out, "lines        {same} the same, {changed} with other numbers, {gone} gone, {new} new");
        for (address, one) in &self.words {
            let _ = writeln!(
                out,
                "  {address:<4} {:>9} times, by up to {:+.6} at line {}",
                grouped(one.count),
                one.max,
                one.max_line
            );
        }
        out
    }
}

impl TextLine {
    /// The row for a terminal, with a line feed behind every line.
    #[must_use]
    pub fn line(&self, look: &Look) -> String {
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
            if at > HEAD && at + width > look.width {
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
