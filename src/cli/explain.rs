//! `ncfix explain`: the long text of a diagnostic code, or what the texts say about some words.

use super::arguments::ExplainArguments;
use super::exit_code::ExitCode;
use super::print;
use super::stop::Stop;
use crate::answers;

/// Prints the texts of codes, what the texts say about words, or the list of codes.
pub(super) fn run(arguments: &ExplainArguments) -> Result<ExitCode, Stop> {
    let words = arguments.words.join(" ");
    let unknown = || Stop::Usage(format!("no code and no text has '{words}'; `ncfix explain` lists all codes"));
    print(&answers::to(&arguments.words).ok_or_else(unknown)?)?;
    Ok(ExitCode::Done)
}
