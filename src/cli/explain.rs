//! `ncfix explain`: the long text of a diagnostic code.

use super::arguments::ExplainArguments;
use super::exit_code::ExitCode;
use super::print;
use super::stop::Stop;
use ncfix_base::diagnostic::{CODES, Code};

/// Prints the text of a code, or the list of codes.
pub(super) fn run(arguments: &ExplainArguments) -> Result<ExitCode, Stop> {
    let Some(text) = &arguments.code else {
        let mut list: Vec<String> = CODES.iter().map(|row| format!("{}  {}\n", row.code, row.title)).collect();
        list.sort();
        print(&list.concat())?;
        return Ok(ExitCode::Done);
    };
    let found = Code::meant(text).map(|row| format!("{}: {}\n\n{}\n", row.code, row.title, row.explain));
    let texts: Vec<String> = found.collect();
    if texts.is_empty() {
        return Err(Stop::Usage(format!("unknown code '{text}'; `ncfix explain` lists all codes")));
    }
    print(&texts.join("\n"))?;
    Ok(ExitCode::Done)
}
