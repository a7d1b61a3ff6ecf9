//! `ncfix diff`: changes between an original and a corrected program.

pub(in crate::cli) mod arguments;

mod page;
mod text;

use crate::cli::arguments::DiffArguments;
use crate::cli::stop::Stop;
use crate::cli::{exit_code::ExitCode, findings::Findings};
use crate::cli::{machine_choice, pages, print, program, progress, tell};
use crate::compare::{CompareOptions, ComparedPrograms, Listing, Outcome, Pair, ROWS};
use crate::disk::pager::Page;
use crate::program::Program;
use ncfix_base::diagnostic::{Code, Diagnostic};
use ncfix_path::review::ReviewTrace;
use ncfix_report::{json, review::Review, verdict::Grade};

pub(in crate::cli) use page::text as page;

/// Compares two programs.
pub(in crate::cli) fn run(arguments: &DiffArguments) -> Result<ExitCode, Stop> {
    if arguments.text {
        return text::run(arguments);
    }
    let mut findings = Findings::default();
    let target = arguments.html.as_deref().map(pages::file).transpose()?;
    let journal = arguments.journal.as_deref().map(page::journal).transpose()?;
    if let Some(target) = &target {
        program::protect(target, [&arguments.original, &arguments.corrected], &mut findings);
    }
    // Both are read first, so that a missing file is reported first.
    let programs = program::both(&arguments.original, &arguments.corrected, &arguments.program)?;
    let Some((trace, outcome)) = compare(arguments, programs.each_ref(), target.is_some(), &mut findings)? else {
        if arguments.json {
            let review = Review { schema: 1, diagnostics: findings.json(), ..Review::default() };
            print(&json::line(&review).map_err(Stop::Usage)?)?;
        } else {
            findings.draw();
            tell(&format!("{}; nothing was compared; --text compares the programs as text\n", findings.count()));
        }
        return Ok(findings.exit_code());
    };
    let Some(corrected) = outcome.sources[1].first() else { return Err(Stop::Usage("nothing was executed".into())) };
    let wanted = wanted(arguments);
    let compared =
        ComparedPrograms { wanted: &wanted, names: names(arguments), trace: &trace, outcome: &outcome, corrected };
    let has_differences = !outcome.differences.is_empty();
    findings.extend(outcome.differences.iter().cloned(), &outcome.sources[1]);
    let mut review = compared.review(&findings);
    if let Some(limit) = review.limits.iter().find(|limit| !limit.is_kept) {
        let message =
            format!("{} reaches {:.1} µm, more than the {:.1} µm allowed", limit.name, limit.value_um, limit.limit_um);
        let help = "list the largest changes with --top 20; correct again if they are not intended";
        findings.add(Diagnostic::nowhere(Code::CORRECTION_TOO_LARGE, message, help), &[]);
    }
    let listing = Listing::new(&wanted, (&trace.rows, &outcome), corrected);
    if target.is_some() || arguments.json {
        (review.rows, review.more_rows) = listing.some(arguments.top.unwrap_or(ROWS));
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
        // The page already has the rows.
        if !arguments.summary && review.changed > 0 && arguments.html.is_none() {
            page.write("\n")?;
            let style = page.style();
            listing.draw(&style, |text| page.write(text))?;
        }
        page.close();
    }
    if has_differences && arguments.fail_above.is_none() {
        return Ok(ExitCode::Different);
    }
    if findings.has_errors() {
        return Ok(findings.exit_code());
    }
    if arguments.fail_above.is_some() && review.verdict.grade == Grade::Bad {
        return Ok(ExitCode::Refused);
    }
    Ok(if review.same || arguments.fail_above.is_some() { ExitCode::Done } else { ExitCode::Different })
}

/// Reads the machine, and walks both programs; `None` if there are errors.
fn compare(
    arguments: &DiffArguments,
    programs: [&Program; 2],
    has_places: bool,
    findings: &mut Findings,
) -> Result<Option<(ReviewTrace, Outcome)>, Stop> {
    let search = programs[1].search(&arguments.original);
    let found = machine_choice::choose_in(&arguments.machine, &arguments.state, search, findings)?;
    let Some(machine) = found else { return Ok(None) };
    machine.check_axes("--axis", &arguments.axis)?;
    let (promised, watch) = (arguments.promised, Some(progress::watch as fn() -> _));
    let pair = Pair { programs, machine: &machine, promised, at_feed: false, requires_coverage: false, watch };
    Ok(pair.trace(has_places, findings)?)
}

/// Options of the comparison.
fn wanted(arguments: &DiffArguments) -> CompareOptions {
    CompareOptions {
        axes: arguments.axis.clone(),
        tolerance_mm: arguments.tolerance.unwrap_or(0.0),
        least_mm: arguments.only,
        limit_mm: arguments.fail_above,
        rows: arguments.top,
    }
}

/// Names of both programs, as given.
fn names(arguments: &DiffArguments) -> [String; 2] {
    [&arguments.original, &arguments.corrected].map(|path| path.display().to_string())
}
