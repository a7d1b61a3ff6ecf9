//! `ncfix diff`: what was changed between an original and a corrected program.

mod job;
mod listing;
mod page;
mod pager;
mod text;

use super::arguments::DiffArguments;
use super::exit_code::ExitCode;
use super::findings::Findings;
use super::output::Target;
use super::pair::{Outcome, Pair};
use super::stop::Stop;
use super::{pages, print, program, tell};
use crate::diagnostic::{Code, Diagnostic};
use crate::report::json;
use crate::report::review::{Limit, Review};
use crate::report::verdict::Verdict;
use crate::review::Trace;

use job::Job;
use listing::Listing;
use pager::Page;

/// Rows in the object for programs where nothing else is said.
const ROWS_OF_JSON: usize = 20;
/// A line of a corrected program is hardly shorter, bytes.
const LEAST_LINE: u64 = 16;

/// Compares two programs.
pub(super) fn run(arguments: &DiffArguments) -> Result<ExitCode, Stop> {
    if arguments.text {
        return text::run(arguments);
    }
    let mut findings = Findings::default();
    let target = arguments.html.as_deref().map(pages::file).transpose()?;
    let journal = arguments.journal.as_deref().map(page::journal).transpose()?;
    if let Some(target) = &target {
        program::protect(target, [&arguments.original, &arguments.corrected], &mut findings);
    }
    let Some((trace, outcome)) = compare(arguments, target.is_some(), &mut findings)? else {
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
    let job = Job { arguments, trace: &trace, outcome: &outcome, corrected };
    let mut review = job.review(&findings);
    if let Some(limit) = review.limits.iter().find(|limit| !limit.is_kept) {
        let message =
            format!("{} reaches {:.1} µm, more than the {:.1} µm allowed", limit.name, limit.value_um, limit.limit_um);
        let help = "look at the largest rows with --top 20; correct again where they are not meant";
        findings.add(Diagnostic::nowhere(Code::CORRECTION_TOO_LARGE, message, help), &[]);
    }
    let listing = Listing::new(arguments, &trace.rows, &outcome.sources[0], corrected);
    if target.is_some() || arguments.json {
        (review.rows, review.more_rows) = listing.some(arguments.top.unwrap_or(ROWS_OF_JSON));
        review.diagnostics = findings.json();
    }
    if let Some(target) = target {
        page::write(target, &review, &trace, &outcome, journal.as_ref())?;
    }
    if arguments.json {
        print(&json::line(&review).map_err(Stop::Usage)?)?;
    } else {
        findings.draw();
        let mut page = Page::open(arguments.no_pager || arguments.html.is_some());
        page.write(&review.summary())?;
        // Who asks for the page has the rows there.
        if !arguments.summary && review.changed > 0 && arguments.html.is_none() {
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

/// Walks both programs; `None` where findings forbid it.
fn compare(
    arguments: &DiffArguments,
    has_places: bool,
    findings: &mut Findings,
) -> Result<Option<(Trace, Outcome)>, Stop> {
    let mut trace = room_for(&arguments.corrected, has_places);
    let pair = Pair {
        original: &arguments.original,
        corrected: &arguments.corrected,
        machine: &arguments.machine,
        state: &arguments.state,
        program: &arguments.program,
        at_feed: false,
    };
    let outcome = pair.compare(findings, &mut |follow| trace.see(&follow, has_places))?;
    Ok(outcome.filter(|_| !findings.has_errors()).map(|outcome| (trace, outcome)))
}

/// Writes the page of a program that was just corrected, and says what it says; `None` where findings forbid it. `limit` is what the correction was
/// allowed.
pub(super) fn review(
    arguments: &DiffArguments,
    limit: impl FnOnce(&Trace) -> Limit,
    target: Target,
    findings: &mut Findings,
) -> Result<Option<Verdict>, Stop> {
    let Some((trace, outcome)) = compare(arguments, true, findings)? else { return Ok(None) };
    let Some(corrected) = outcome.sources[1].first() else { return Ok(None) };
    let mut review = Job { arguments, trace: &trace, outcome: &outcome, corrected }.review(findings);
    review.limits.push(limit(&trace));
    review.verdict = Verdict::of(&review);
    let listing = Listing::new(arguments, &trace.rows, &outcome.sources[0], corrected);
    (review.rows, review.more_rows) = listing.some(ROWS_OF_JSON);
    page::write(target, &review, &trace, &outcome, None)?;
    Ok(Some(review.verdict))
}

/// For as many rows as a corrected program may have lines.
pub(super) fn room_for(corrected: &std::path::Path, has_places: bool) -> Trace {
    let bytes = std::fs::metadata(corrected).map_or(0, |data| data.len());
    Trace::new(usize::try_from(bytes / LEAST_LINE).unwrap_or(0), has_places)
}
