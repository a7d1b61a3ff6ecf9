//! `ncfix verify`: executes an original and a corrected program and compares the errors of both on the error model.

pub(in crate::cli) mod arguments;

use crate::cli::arguments::VerifyArguments;
use crate::cli::pages::Pages;
use crate::cli::stop::Stop;
use crate::cli::{exit_code::ExitCode, findings::Findings};
use crate::cli::{machine_choice, print, program, progress};
use crate::compare::{ErrorsAlong, Outcome, Pair, verification};
use ncfix_path::path::Follow;
use ncfix_report::{correction::feed_rows, json, page, verdict::Grade};

/// Compares two programs.
pub(in crate::cli) fn run(arguments: &VerifyArguments) -> Result<ExitCode, Stop> {
    let mut findings = Findings::default();
    let pages = arguments.page.pages(None, arguments.json)?;
    if let Some(target) = pages.as_ref().and_then(Pages::target) {
        program::protect(target, [&arguments.original, &arguments.corrected], &mut findings);
    }
    let mut along = ErrorsAlong::default();
    let mut see = |follow: Follow<'_>| {
        if pages.is_some() {
            along.see(&follow);
        }
    };
    let outcome = compare(arguments, &mut findings, &mut see)?;
    if let (Some(pages), Some(outcome)) = (pages, &outcome) {
        pages.publish(&page::verification::verification(&along.verification(outcome, &findings)))?;
    }
    let result = verification(outcome.as_ref(), &findings);
    let is_bad = result.verdict.as_ref().is_some_and(|verdict| verdict.grade == Grade::Bad);
    let exit_code = if is_bad && !findings.has_errors() { ExitCode::Refused } else { findings.exit_code() };
    if arguments.json {
        print(&json::line(&result).map_err(Stop::Usage)?)?;
        return Ok(exit_code);
    }
    findings.draw();
    if result.after.is_some() {
        let max_at = outcome.as_ref().and_then(|outcome| outcome.max_at.as_ref());
        let at_feed = outcome.as_ref().and_then(|outcome| outcome.at_feed.as_ref());
        let at_feed = at_feed.map_or_else(String::new, |[original, corrected]| feed_rows(original, corrected));
        print(&(result.rows(max_at.map(|(line, file)| (*line, file.as_str()))) + &at_feed))?;
    }
    Ok(exit_code)
}

/// Reads both programs and the machine, and compares; `None` if there are errors.
fn compare(
    arguments: &VerifyArguments,
    findings: &mut Findings,
    see: &mut dyn FnMut(Follow<'_>),
) -> Result<Option<Outcome>, Stop> {
    // Both are read first, so that a missing file is reported first.
    let programs = program::both(&arguments.original, &arguments.corrected, &arguments.program)?;
    if findings.has_errors() {
        return Ok(None);
    }
    let search = programs[1].search(&arguments.original);
    let found = machine_choice::choose_in(&arguments.machine, &arguments.state, search, findings)?;
    let Some(machine) = found else { return Ok(None) };
    let pair = Pair {
        programs: programs.each_ref(),
        machine: &machine,
        promised: arguments.promised,
        at_feed: arguments.at_feed,
        requires_coverage: arguments.require_coverage,
        watch: Some(progress::watch),
    };
    Ok(pair.verify(findings, see)?)
}
