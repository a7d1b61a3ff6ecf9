//! The page of a comparison.

use std::path::Path;

use crate::cli::input;
use crate::cli::machine_choice::digest;
use crate::cli::stop::Stop;
use crate::compare::Outcome;
use ncfix_base::source::{FileId, Source};
use ncfix_dnc::feed::{ThermalHistory, shown};
use ncfix_path::review::ReviewTrace;
use ncfix_report::page::review::{JournalTrace, ReviewedProgram, Subject, review};
use ncfix_report::review::Review;

/// Text of the page.
///
/// # Errors
/// If there is more than a page can show.
pub(in crate::cli) fn text(
    object: &Review,
    trace: &ReviewTrace,
    (outcome, corrected): (&Outcome, &Source),
    journal: Option<&JournalTrace>,
) -> Result<String, Stop> {
    let originals: Vec<ReviewedProgram<'_>> = outcome.sources[0].iter().map(of).collect();
    let subject = Subject { review: object, trace, originals: &originals, corrected: of(corrected), journal };
    review(&subject, &digest).map_err(Stop::Usage)
}

fn of(source: &Source) -> ReviewedProgram<'_> {
    ReviewedProgram { name: source.name(), bytes: source.bytes(), line_end: source.line_end() }
}

/// Reads temperatures, corrections and the fill of the buffer from the journal of a transfer.
pub(in crate::cli) fn journal(path: &Path) -> Result<JournalTrace, Stop> {
    let source = input::read(path, FileId(0), input::option("journal, --journal"))?;
    let text = String::from_utf8_lossy(source.bytes());
    let ThermalHistory { times_s, sensors_c, axes_um, waiting } =
        shown(&text).map_err(|(line, why)| Stop::Usage(format!("{}, line {line}: {why}", path.display())))?;
    Ok(JournalTrace { times_s, sensors_c, axes_um, waiting })
}
