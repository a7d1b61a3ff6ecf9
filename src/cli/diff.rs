//! `ncfix diff`: what was changed between an original and a corrected program.

mod job;
mod listing;
mod page;
mod pager;
mod text;

use super::arguments::DiffArguments;
use super::exit_code::ExitCode;
use super::findings::Findings;
use super::pair::{Outcome, Pair};
use super::stop::Stop;
use super::{pages, print, program, tell};
use ncfix_base::diagnostic::{Code, Diagnostic};
use ncfix_base::source::Source;
use ncfix_path::review::Trace;
use ncfix_report::json;
use ncfix_report::review::{Limit, Review};
use ncfix_report::verdict::Verdict;

use job::Job;
use listing::Listing;
use pager::Page;

/// Rows in the object for programs where nothing else is said.
const ROWS_OF_JSON: usize = 20;
/// A line of a corrected program is hardly shorter, bytes.
const LEAST_LINE: usize = 16;

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
    // Both are read before anything else: a file that is missing is the first thing to know.
    let sources = [program::read(&arguments.original)?, program::read(&arguments.corrected)?];
    let Some((trace, outcome)) = compare(arguments, sources, target.is_some(), &mut findings)? else {
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
    let has_differences = !outcome.differences.is_empty();
    findings.extend(outcome.differences.iter().cloned(), &outcome.sources[1]);
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
        pages::publish(target, &page::text(&review, &trace, (&outcome, corrected), journal.as_ref())?)?;
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
    if has_differences && arguments.fail_above.is_none() {
        return Ok(ExitCode::Different);
    }
    if findings.has_errors() {
        return Ok(findings.exit_code());
    }
    Ok(if review.same || arguments.fail_above.is_some() { ExitCode::Done } else { ExitCode::Different })
}

/// Walks both programs; `None` where findings forbid it.
fn compare(
    arguments: &DiffArguments,
    sources: [Source; 2],
    has_places: bool,
    findings: &mut Findings,
) -> Result<Option<(Trace, Outcome)>, Stop> {
    let mut trace = Trace::new(sources[1].bytes().len() / LEAST_LINE, has_places);
    let pair = Pair {
        original: &arguments.original,
        corrected: &arguments.corrected,
        machine: &arguments.machine,
        state: &arguments.state,
        program: &arguments.program,
        promised: arguments.promised,
        at_feed: false,
    };
    let outcome = pair.compare(sources, findings, &mut |follow| trace.see(&follow, has_places))?;
    Ok(outcome.filter(|_| !findings.has_errors()).map(|outcome| (trace, outcome)))
}

/// What the page of a program that was just corrected says, and the page; `None` where findings forbid it. `limit` is what the correction was allowed.
pub(super) fn review(
    arguments: &DiffArguments,
    sources: [Source; 2],
    limit: impl FnOnce(&Trace) -> Limit,
    findings: &mut Findings,
) -> Result<Option<(Verdict, String)>, Stop> {
    let Some((trace, outcome)) = compare(arguments, sources, true, findings)? else { return Ok(None) };
    let Some(corrected) = outcome.sources[1].first() else { return Ok(None) };
    findings.extend(outcome.differences.iter().cloned(), &outcome.sources[1]);
    let mut review = Job { arguments, trace: &trace, outcome: &outcome, corrected }.review(findings);
    review.limits.push(limit(&trace));
    review.verdict = Verdict::of(&review);
    let listing = Listing::new(arguments, &trace.rows, &outcome.sources[0], corrected);
    (review.rows, review.more_rows) = listing.some(ROWS_OF_JSON);
    let page = page::text(&review, &trace, (&outcome, corrected), None)?;
    Ok(Some((review.verdict, page)))
}
