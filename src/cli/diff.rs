//! `ncfix diff`: what was changed between an original and a corrected program.

mod listing;
mod pager;
mod text;

use super::arguments::DiffArguments;
use super::exit_code::ExitCode;
use super::findings::Findings;
use super::pair::{Outcome, Pair};
use super::stop::Stop;
use super::{fix, print, tell};
use crate::diagnostic::{Code, Diagnostic};
use crate::geometry::{AXES, Axis};
use crate::report::json;
use crate::report::review::{Figures, Limit, Review, Step};
use crate::review::{Row, Summary};
use crate::source::Source;
use crate::units::{um_from_mm, urad_from_rad};

use listing::Listing;
use pager::Page;

/// Rows in the object for programs where nothing else is said.
const ROWS_OF_JSON: usize = 20;
/// A line of a corrected program is hardly shorter, bytes.
const LEAST_LINE: u64 = 16;
/// An angle counts what it makes at this arm, mm.
const ARM_MM: f64 = 1000.0;

/// Compares two programs.
pub(super) fn run(arguments: &DiffArguments) -> Result<ExitCode, Stop> {
    if arguments.text {
        return text::run(arguments);
    }
    let mut findings = Findings::default();
    // As many as lines there may be; memory that is not written is not taken.
    let bytes = std::fs::metadata(&arguments.corrected).map_or(0, |data| data.len());
    let mut rows: Vec<Row> = Vec::with_capacity(usize::try_from(bytes / LEAST_LINE).unwrap_or(0));
    let pair = Pair {
        original: &arguments.original,
        corrected: &arguments.corrected,
        machine: &arguments.machine,
        state: &arguments.state,
        program: &arguments.program,
    };
    let outcome = pair.compare(&mut findings, &mut |follow| rows.push(Row::new(&follow)))?;
    let Some(outcome) = outcome else {
        if arguments.json {
            let review = Review { schema: 1, diagnostics: findings.json(), ..Review::default() };
            print(&json::line(&review).map_err(Stop::Usage)?)?;
        } else {
            findings.draw();
            tell(&format!(
                "{}; nothing was compared; --text compares the words as they are written\n",
                findings.count()
            ));
        }
        return Ok(findings.exit_code());
    };
    let Some(corrected) = outcome.sources[1].first() else { return Err(Stop::Usage("nothing was executed".into())) };
    let job = Job { arguments, rows: &rows, outcome: &outcome, corrected };
    let mut review = job.review();
    if let Some(limit) = review.limits.iter().find(|limit| !limit.is_kept) {
        let message =
            format!("{} reaches {:.1} µm, more than the {:.1} µm allowed", limit.name, limit.value_um, limit.limit_um);
        let help = "look at the largest rows with --top 20; correct again where they are not meant";
        findings.add(Diagnostic::nowhere(Code::CORRECTION_TOO_LARGE, message, help), &[]);
    }
    let listing = Listing::new(arguments, &rows, &outcome.sources[0], corrected);
    if arguments.json {
        (review.rows, review.more_rows) = listing.some(arguments.top.unwrap_or(ROWS_OF_JSON));
        review.diagnostics = findings.json();
        print(&json::line(&review).map_err(Stop::Usage)?)?;
    } else {
        findings.draw();
        let mut page = Page::open(arguments.no_pager);
        page.write(&review.summary())?;
        if !arguments.summary && review.changed > 0 {
            page.write("\n")?;
            listing.draw(&mut page)?;
        }
        page.close();
    }
    if findings.has_errors() {
        return Ok(findings.exit_code());
    }
    Ok(if review.same || arguments.fail_above.is_some() { ExitCode::Done } else { ExitCode::Different })
}

/// Both programs, compared.
struct Job<'a> {
    arguments: &'a DiffArguments,
    rows: &'a [Row],
    outcome: &'a Outcome,
    corrected: &'a Source,
}

/// The axes that are asked for.
fn axes_of(arguments: &DiffArguments) -> Vec<Axis> {
    AXES.into_iter().filter(|axis| arguments.axis.is_empty() || arguments.axis.contains(axis)).collect()
}

/// What is the same, mm and rad.
fn tolerance_of(arguments: &DiffArguments) -> [f64; 2] {
    let mm = arguments.tolerance.unwrap_or(0.0);
    [mm, mm / ARM_MM]
}

impl Job<'_> {
    /// The report without its rows.
    fn review(&self) -> Review {
        let axes = axes_of(self.arguments);
        let found = Summary::of(self.rows, &axes, tolerance_of(self.arguments), self.outcome.increments[0]);
        let left = [
            ("without an error of an increment", found.left.no_error),
            ("before the axes were stated", found.left.unstated),
            ("rapid", found.left.rapid),
            ("that are not corrected", found.left.other),
        ];
        let figures = found.axes.iter().map(|one| {
            let scale: fn(f64) -> f64 = if one.axis.is_rotary() { urad_from_rad } else { um_from_mm };
            let [max, mean, rms, p99] = [one.max, one.mean, one.rms, one.p99].map(scale);
            let unit = if one.axis.is_rotary() { "urad" } else { "um" };
            (one.axis.to_string(), Figures { unit, max, max_line: one.max_at.original.1, mean, rms, p99 })
        });
        let original = self.outcome.sources[0].first();
        let limits = self.arguments.fail_above.map(|limit_mm| {
            let largest = self.rows.iter().map(|row| row.largest(&axes)).fold(0.0, f64::max);
            let name = "the largest change of an axis".to_owned();
            Limit { name, value_um: largest, limit_um: um_from_mm(limit_mm), is_kept: largest <= um_from_mm(limit_mm) }
        });
        Review {
            schema: 1,
            same: found.changed == 0,
            compared: "executed",
            files: [&self.arguments.original, &self.arguments.corrected].map(|path| path.display().to_string()),
            bytes: [original.map_or(0, |source| source.bytes().len() as u64), self.corrected.bytes().len() as u64],
            moves: [found.moves, found.pieces],
            changed: found.changed,
            split: found.split,
            left: left.into_iter().filter(|(_, count)| *count > 0).collect(),
            other_feeds: found.other_feeds,
            axes: figures.collect(),
            largest_step: found.largest_step.map(|(mm, at)| Step { um: um_from_mm(mm), line: at.original.1 }),
            longest_line: longest(self.corrected),
            before: Some(fix::spread(&self.outcome.comparison.before)),
            after: Some(fix::spread(&self.outcome.comparison.after)),
            limits: limits.into_iter().collect(),
            ..Review::default()
        }
    }
}

/// Length and number of the longest line.
fn longest(source: &Source) -> [u64; 2] {
    let lines = source.bytes().split(|&byte| byte == source.line_end()).enumerate();
    let length = |line: &[u8]| line.strip_suffix(b"\r").unwrap_or(line).len() as u64;
    let longest = lines.map(|(number, line)| [length(line), number as u64 + 1]);
    longest.max_by(|a, b| a[0].cmp(&b[0]).then(b[1].cmp(&a[1]))).unwrap_or_default()
}
