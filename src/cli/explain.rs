//! `ncfix explain`: the long text of a diagnostic code, or what the texts say about some words.

use super::arguments::ExplainArguments;
use super::exit_code::ExitCode;
use super::print;
use super::stop::Stop;
use crate::answers;
use ncfix_base::diagnostic::{CODES, Code, CodeRow};

/// Prints the texts of codes, what the texts say about words, or the list of codes.
pub(super) fn run(arguments: &ExplainArguments) -> Result<ExitCode, Stop> {
    if arguments.words.is_empty() {
        let mut list: Vec<String> = CODES.iter().map(|row| format!("{}  {}\n", row.code, row.title)).collect();
        list.sort();
        print(&list.concat())?;
        return Ok(ExitCode::Done);
    }
    let codes: Vec<&CodeRow> = arguments.words.iter().flat_map(|word| Code::meant(word)).collect();
    let texts: Vec<String> =
        codes.iter().map(|row| format!("{}: {}\n\n{}\n", row.code, row.title, row.explain)).collect();
    let is_code = |word: &String| word.starts_with(['E', 'W', 'e', 'w']) && word[1..].parse::<u16>().is_ok();
    let text = if texts.is_empty() && !arguments.words.iter().any(is_code) {
        answers::about(&arguments.words)
    } else {
        Some(texts.join("\n"))
    };
    let Some(text) = text.filter(|text| !text.is_empty()) else {
        let words = arguments.words.join(" ");
        return Err(Stop::Usage(format!("no code and no text has '{words}'; `ncfix explain` lists all codes")));
    };
    print(&text)?;
    Ok(ExitCode::Done)
}
