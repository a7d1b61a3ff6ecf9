//! `ncfix diff --text`: the words of two programs as they are written.

use super::{names, wanted};
use crate::cli::arguments::DiffArguments;
use crate::cli::exit_code::ExitCode;
use crate::cli::stop::Stop;
use crate::cli::{print, program};
use crate::compare::{ROWS, TextComparison};
use crate::disk::pager::Page;
use ncfix_report::json;

/// Compares two programs.
pub(super) fn run(arguments: &DiffArguments) -> Result<ExitCode, Stop> {
    let programs = program::both(&arguments.original, &arguments.corrected, &arguments.program)?;
    let (wanted, most) = (wanted(arguments), if arguments.json { ROWS } else { usize::MAX });
    let mut found = TextComparison::new(programs.each_ref().map(|one| one.source()), names(arguments), &wanted, most);
    if arguments.json {
        found.review.rows = found.rows().collect();
        print(&json::line(&found.review).map_err(Stop::Usage)?)?;
    } else {
        let mut page = Page::open(arguments.no_pager);
        page.write(&found.review.summary())?;
        if !arguments.summary && !found.review.same {
            page.write("\n")?;
            let style = page.style();
            for row in found.rows() {
                page.write(&row.line(&style))?;
            }
        }
        page.close();
    }
    Ok(match (found.review.same, arguments.fail_above) {
        (false, None) => ExitCode::Different,
        (false, Some(_)) if found.is_beyond => ExitCode::Refused,
        _ => ExitCode::Done,
    })
}
