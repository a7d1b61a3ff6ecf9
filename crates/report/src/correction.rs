//! Result of a correction: table for people and the JSON object.

use std::collections::BTreeMap;
use std::fmt::Write as _;

use serde::Serialize;

use super::coverage::CoverageReport;
use super::guard::GuardReport;
use super::json::{AtFeed, DiagnosticReport, FeedLimit, RemainingReport, SpreadReport, VerificationReport, ZeroReport};
use super::number::{counted, duration, grouped, micrometers, significant};
use super::prediction::PredictionReport;
use super::verdict::Verdict;
use ncfix_base::geometry::AxisKey;

/// Growth from which the table states it; a smaller one is usual.
const SHOWN_GROWTH: f64 = 2.0;

/// Largest share of the form error in the error at which it is stated separately.
pub(super) const MOST_FORM: f64 = 0.5;

/// The row for a program whose axes move in no zero offset, such as one in G53 or G500.
pub(super) const NO_ZERO: &str = "no offset in force: corrected to true positions of the machine";

/// Output of `ncfix fix`. Errors are distances of the tool tip from the programmed path, predicted by the error model.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct CorrectionReport {
    /// Errors as programmed; `null` if the program was refused, or if no move starts at a known position.
    pub before: Option<SpreadReport>,
    /// Errors as programmed, beyond the constant displacement that a touched zero offset takes up; `null` if the program was refused.
    pub before_form: Option<SpreadReport>,
    /// Zero offsets in which axes move.
    pub zeros: Vec<ZeroReport>,
    /// Errors as written, including rounding.
    pub after: Option<SpreadReport>,
    /// Largest absolute correction of each axis: `X_um`, `C_urad`.
    pub max_correction: BTreeMap<AxisKey, f64>,
    /// Result of the feed limit; absent if none was requested.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub feed_limit: Option<FeedLimit>,
    /// Errors that no axis can correct, by source.
    pub remaining: Vec<RemainingReport>,
    /// Rapid moves that stay as programmed: in machine coordinates, to reference points and tool changes, along the tool.
    pub rapids_as_programmed: u64,
    /// Largest tool error at the ends of rapid moves that do not approach a cut, µm.
    pub off_at_rapids_um: f64,
    /// Cutting blocks shorter than the block cycle of the control; absent if the machine file does not state it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub short_blocks: Option<ShortBlocksReport>,
    /// Executed blocks.
    pub blocks_in: u64,
    /// Written blocks.
    pub blocks_out: u64,
    /// Written blocks per line with words of the source.
    pub growth: f64,
    /// The line of the source that gives the most blocks: a loop, a subprogram or a cycle; `null` if each line gives one.
    pub most_repeated: Option<RepeatedBlock>,
    /// Holes that stay a drilling cycle.
    pub drilling_cycles: u64,
    /// Largest distance of the tip from the corrected path in these holes, µm, if it exceeds the tolerance of the other moves.
    pub cycles_off_um: Option<f64>,
    /// Holes of drilling cycles that are written as moves.
    pub drilled_by_moves: u64,
    /// Tolerance with which these holes could stay cycles, µm; `null` if they are moves for another reason.
    pub cycles_need_um: Option<f64>,
    /// Check by the control at the start of the output; `null` without --guard.
    pub guard: Option<GuardReport>,
    /// Wall time of the run.
    pub seconds: f64,
    /// Source line of the largest residual error.
    pub max_at_line: Option<u32>,
    /// File of that line.
    pub max_at_file: Option<String>,
    /// File that was written, `-` for standard output; `null` if nothing was written.
    pub output: Option<String>,
    /// Subprograms of the output; absent without them.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub subprograms: Vec<String>,
    /// File with the original of a program that was corrected in place.
    pub backup: Option<String>,
    /// Review page; `null` if none was requested or written.
    pub review: Option<String>,
    /// Coverage by the measured ranges of the machine; `null` if the program was refused.
    pub coverage: Option<CoverageReport>,
    /// Intervals of the true errors; `null` if the program was refused or nothing was corrected.
    pub prediction: Option<PredictionReport>,
    /// Verdict on running the program, as on the page.
    pub verdict: Option<Verdict>,
    /// Name of the machine.
    pub machine: String,
    /// Diagnostics in order of occurrence.
    pub diagnostics: Vec<DiagnosticReport>,
}

/// Cutting blocks that take less time at their feed than the control needs for a block.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct ShortBlocksReport {
    /// Time that the control needs for a block, ms.
    pub block_cycle_ms: f64,
    /// Number in the program.
    pub source: u64,
    /// Number in the corrected program.
    pub written: u64,
    /// Time of the shortest one in the corrected program, ms; `null` if no block is shorter.
    pub shortest_ms: Option<f64>,
}

impl ShortBlocksReport {
    /// `2 ms: 12 cutting blocks are shorter, the shortest 0.4 ms; 10 of the program`.
    #[must_use]
    pub fn words(&self) -> String {
        let cycle = format!("{} ms", self.block_cycle_ms);
        match self.shortest_ms {
            None => format!("{cycle}: no cutting block is shorter"),
            Some(shortest_ms) => format!(
                "{cycle}: {} shorter, the shortest takes {shortest_ms:.2} ms; {} in the program",
                counted(self.written, "cutting block"),
                grouped(self.source)
            ),
        }
    }
}

impl CorrectionReport {
    /// Returns the table for people, with a line feed after every line.
    #[must_use]
    pub fn table(&self) -> String {
        let mut out = String::new();
        if let (Some(before), Some(after)) = (self.before, self.after) {
            let place = self.max_at_line.zip(self.max_at_file.as_deref());
            out.push_str(&error_rows(before, after, place));
            out.push_str(&form_row(before, self.before_form));
        } else {
            push_row(
                &mut out,
                "error",
                "not known: no move begins where the positions of all axes are known; --start states them",
            );
        }
        out.push_str(&self.prediction.as_ref().map_or_else(String::new, PredictionReport::rows));
        out.push_str(&zero_rows(&self.zeros));
        if self.zeros.is_empty() && !self.max_correction.is_empty() {
            push_row(&mut out, "zero", NO_ZERO);
        }
        let mut row = |name: &str, text: &str| push_row(&mut out, name, text);
        if !self.max_correction.is_empty() {
            let mut sizes: Vec<_> = self.max_correction.iter().collect();
            // Linear axes first.
            sizes.sort_by_key(|(key, _)| key.is_rotary());
            let parts: Vec<String> = sizes.into_iter().map(|(&key, &size)| largest(key, size)).collect();
            row("correction", &format!("up to {}", parts.join(", ")));
        }
        let turns = self.max_correction.keys().any(|axis| axis.is_rotary());
        for (name, size, is_shown) in [
            ("tool tilt", (|left: &RemainingReport| left.tilt_urad) as fn(&RemainingReport) -> f64, true),
            // On a machine with three axes, a roll of the tool has neither an effect nor a remedy.
            ("tool roll", |left| left.roll_urad, turns),
        ] {
            if let Some(text) = left_over(&self.remaining, size, 0.05, "µrad").filter(|_| is_shown) {
                row(name, &text);
            }
        }
        if let Some(text) = left_over(&self.remaining, |left| left.position_um, 0.005, "µm") {
            row("uncorrected", &format!("{text}, less than an increment"));
        }
        if self.rapids_as_programmed > 0 {
            let off = match self.off_at_rapids_um {
                off_um if off_um > 0.0 => format!("; there the tool is up to {} off", micrometers(off_um)),
                _ => String::new(),
            };
            row("rapids", &format!("{} as programmed{off}", grouped(self.rapids_as_programmed)));
        }
        if let Some(limit) = &self.feed_limit {
            let [before, after] = [limit.contouring_before.max_um, limit.contouring_after.max_um].map(micrometers);
            let exceeding = match limit.exceeding {
                0 => String::new(),
                count => format!(", {} of them still above the limit", grouped(count)),
            };
            row("contouring", &format!("up to {before} before, {after} after; limit {}", micrometers(limit.limit_um)));
            row("slowed", &format!("{}{exceeding}", counted(limit.slowed, "block")));
            row(
                "on machine",
                &format!("{} before, {} after", duration(limit.time_before_s), duration(limit.time_after_s)),
            );
        }
        let growth = match self.growth {
            growth if growth >= SHOWN_GROWTH => format!(", {growth:.1} times the blocks of the original"),
            _ => String::new(),
        };
        let repeated =
            self.most_repeated.as_ref().filter(|_| !growth.is_empty()).map_or_else(String::new, |repeated| {
                format!("; most often {}:{}, {} times", repeated.file, repeated.line, grouped(repeated.times))
            });
        if self.drilling_cycles + self.drilled_by_moves > 0 {
            let holes = counted(self.drilling_cycles, "hole");
            let moves = match self.drilled_by_moves {
                0 => String::new(),
                count => {
                    let way = self
                        .cycles_need_um
                        .map(|needed_um| format!("; with --hole-tolerance {needed_um:.0}um they would stay"))
                        .unwrap_or_default();
                    format!(", {} written as moves{way}", grouped(count))
                }
            };
            let off = self
                .cycles_off_um
                .map(|off_um| format!(", up to {} off the exact path", micrometers(off_um)))
                .unwrap_or_default();
            row("cycles", &format!("{holes} kept{off}{moves}"));
        }
        if let Some(guard) = &self.guard {
            row("guard", &guard.words());
        }
        row("executed", &format!("{}{repeated}", counted(self.blocks_in, "block")));
        row("output", &format!("{}{growth}", counted(self.blocks_out, "block")));
        if let Some(short) = &self.short_blocks {
            row("block cycle", &short.words());
        }
        row("computed", &format!("in {}", duration(self.seconds)));
        row("machine", &self.machine);
        if let Some(coverage) = &self.coverage {
            row("coverage", &coverage.words());
        }
        if let Some(output) = &self.output {
            row("written", output_name(output));
        }
        match &self.subprograms[..] {
            [] => {}
            [one] => row("subprogram", one),
            [first, .., last] => row("subprograms", &format!("{}: {first} to {last}", self.subprograms.len())),
        }
        if let Some(backup) = &self.backup {
            row("original", backup);
        }
        if let Some(review) = &self.review {
            row("review", review);
        }
        if let Some(verdict) = &self.verdict {
            row("verdict", verdict.sentence());
            for text in verdict.doubts_and_errors() {
                row("", text);
            }
        }
        out
    }
}

impl VerificationReport {
    /// Returns the rows for people: verdict, errors and their interval. `max_at` is the line of the largest residual error and its file.
    #[must_use]
    pub fn rows(&self, max_at: Option<(u32, &str)>) -> String {
        let mut out = self.verdict.as_ref().map_or_else(String::new, Verdict::rows);
        if let (Some(before), Some(after)) = (self.before, self.after) {
            out.push_str(&error_rows(before, after, max_at));
        }
        out.push_str(&self.prediction.as_ref().map_or_else(String::new, PredictionReport::rows));
        out
    }
}

/// Returns the rows of the error table; `max_at` is the line of the largest residual error and its file.
#[must_use]
pub fn error_rows(before: SpreadReport, after: SpreadReport, max_at: Option<(u32, &str)>) -> String {
    let mut out = String::new();
    let place = max_at.map_or(String::new(), |(line, file)| format!("   largest at {file}:{line}"));
    push_row(&mut out, "", &format!("{:>12}{:>12}{:>12}", "mean", "RMS", "max"));
    push_row(&mut out, "error before", &columns(before));
    push_row(&mut out, "error after", &format!("{}{place}", columns(after)));
    let row = if after.mean_um > before.mean_um { "change" } else { "improvement" };
    push_row(&mut out, row, &improvement(before, after));
    out
}

/// Returns the row of the form error, if most of the error is a constant displacement.
#[must_use]
pub fn form_row(before: SpreadReport, form: Option<SpreadReport>) -> String {
    let mut out = String::new();
    if let Some(form) = form.filter(|form| form.mean_um < MOST_FORM * before.mean_um) {
        push_row(
            &mut out,
            "form error",
            &format!("{}   error before, minus the constant offset that touching off removes", columns(form)),
        );
    }
    out
}

/// Returns a row for each zero offset.
#[must_use]
pub fn zero_rows(zeros: &[ZeroReport]) -> String {
    let mut out = String::new();
    for zero in zeros {
        let stated = if zero.is_stated { "" } else { " (not stated)" };
        push_row(&mut out, "zero", &format!("{} {}{stated}{}", zero.name, zero.set, zero.contents_in_line()));
    }
    out
}

/// Returns the rows about two programs at feed.
#[must_use]
pub fn feed_rows(original: &AtFeed, corrected: &AtFeed) -> String {
    let mut out = String::new();
    push_row(&mut out, "", &format!("{:>12}{:>12}{:>12}", "RMS", "max", "time"));
    for (name, at_feed) in [("at feed", original), ("corrected", corrected)] {
        let [rms, max] = [at_feed.contouring.rms_um, at_feed.contouring.max_um].map(micrometers);
        let place = match (&at_feed.file, at_feed.line) {
            (Some(file), Some(line)) => format!("   largest deviation at {file}:{line}"),
            _ => String::new(),
        };
        push_row(&mut out, name, &format!("{rms:>12}{max:>12}{:>12}{place}", duration(at_feed.time_s)));
    }
    out
}

/// Lists residuals, such as `up to 12.3 µrad (geometry), 3.1 µrad (load) remaining`; `None` if none is large enough for a line.
fn left_over(all: &[RemainingReport], size: fn(&RemainingReport) -> f64, least: f64, unit: &str) -> Option<String> {
    let parts: Vec<String> = all
        .iter()
        .filter(|&left| size(left) >= least)
        .map(|left| format!("{} {unit} ({})", significant(size(left)), left.source))
        .collect();
    (!parts.is_empty()).then(|| format!("up to {} remaining", parts.join(", ")))
}

/// A file that was written, as people read it.
pub(super) fn output_name(output: &str) -> &str {
    if output == "-" { "standard output" } else { output }
}

/// Appends one row of a table.
pub(super) fn push_row(out: &mut String, name: &str, text: &str) {
    // Writing into a String cannot fail.
    let _ = writeln!(out, "{name:<13}{text}");
}

/// Formats the three columns of the error table.
fn columns(spread: SpreadReport) -> String {
    let [mean, rms, max] = [spread.mean_um, spread.rms_um, spread.max_um].map(micrometers);
    format!("{mean:>12}{rms:>12}{max:>12}")
}

/// Formats the share of the mean error that the correction removed, Spaan's efficiency (eq. 3.6).
fn improvement(before: SpreadReport, after: SpreadReport) -> String {
    if before.mean_um > 0.0 {
        let percent = (1.0 - after.mean_um / before.mean_um) * 100.0;
        // Rounding must not suggest that no error remains.
        if percent < 0.0 {
            format!("mean error {:.1} % larger", -percent)
        } else if percent < 99.95 {
            format!("mean error reduced by {percent:.1} %")
        } else {
            format!("mean error reduced by {:.2} %", percent.min(99.99))
        }
    } else {
        "none: no error on this path".into()
    }
}

/// `X 12.3 µm`, `C 4.56 µrad`.
fn largest(key: AxisKey, size: f64) -> String {
    format!("{} {} {}", key.letter(), significant(size), key.sign())
}

/// A block that was executed several times.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct RepeatedBlock {
    /// Its line.
    pub line: u32,
    /// Its file.
    pub file: String,
    /// Number of executions.
    pub times: u64,
}

#[cfg(test)]
mod tests {
    use super::*;
    use ncfix_base::geometry::Axis;

    fn sample() -> CorrectionReport {
        CorrectionReport {
            before: Some(SpreadReport { mean_um: 25.04, rms_um: 28.1, max_um: 103.2 }),
            before_form: None,
            zeros: Vec::new(),
            after: Some(SpreadReport { mean_um: 0.25, rms_um: 0.31, max_um: 0.98 }),
            max_correction: [(AxisKey::of_deviation(Axis::X), 41.26), (AxisKey::of_deviation(Axis::C), 3.0)].into(),
            feed_limit: None,
            remaining: Vec::new(),
            rapids_as_programmed: 12,
            off_at_rapids_um: 35.2,
            short_blocks: None,
            blocks_in: 1234,
            blocks_out: 2345,
            growth: 2.5,
            most_repeated: Some(RepeatedBlock { line: 7, file: "part.mpf".into(), times: 40 }),
            drilling_cycles: 38,
            cycles_off_um: Some(1.4),
            drilled_by_moves: 2,
            cycles_need_um: Some(3.0),
            guard: None,
            seconds: 0.123,
            max_at_line: Some(17),
            max_at_file: Some("part.mpf".into()),
            output: Some("out.mpf".into()),
            subprograms: ["PART_1.SPF", "PART_2.SPF"].map(str::to_owned).into(),
            backup: Some("part.mpf.bak".into()),
            review: Some("review.html".into()),
            coverage: Some(CoverageReport { is_complete: true, is_stated: true, gaps: Vec::new() }),
            prediction: Some(PredictionReport::default()),
            verdict: Some(Verdict { is_covered: true, ..Verdict::default() }),
            machine: "demo".into(),
            diagnostics: Vec::new(),
        }
    }

    #[test]
    fn the_table_is_aligned() {
        insta::assert_snapshot!(sample().table(), @r"
                             mean         RMS         max
        error before      25.0 µm     28.1 µm      103 µm
        error after      0.250 µm    0.310 µm    0.980 µm   largest at part.mpf:17
        improvement  mean error reduced by 99.0 %
        interval     not known: the machine file has no [uncertainty]
        zero         no offset in force: corrected to true positions of the machine
        correction   up to X 41.3 µm, C 3.00 µrad
        rapids       12 as programmed; there the tool is up to 35.2 µm off
        cycles       38 holes kept, up to 1.40 µm off the exact path, 2 written as moves; with --hole-tolerance 3um they would stay
        executed     1,234 blocks; most often part.mpf:7, 40 times
        output       2,345 blocks, 2.5 times the blocks of the original
        computed     in 0.12 s
        machine      demo
        coverage     within the measured ranges
        written      out.mpf
        subprograms  2: PART_1.SPF to PART_2.SPF
        original     part.mpf.bak
        review       review.html
        verdict      nothing found against running it; uncertainty not known
        ");
    }

    #[test]
    fn improvement_never_reaches_a_hundred_by_rounding() {
        let before = SpreadReport { mean_um: 20.0, ..SpreadReport::default() };
        let after = |mean_um| SpreadReport { mean_um, ..SpreadReport::default() };
        assert_eq!(improvement(before, after(1.0)), "mean error reduced by 95.0 %");
        assert_eq!(improvement(before, after(0.004)), "mean error reduced by 99.98 %");
        assert_eq!(improvement(before, after(0.000_01)), "mean error reduced by 99.99 %");
        assert_eq!(improvement(before, after(30.0)), "mean error 50.0 % larger");
    }
}
