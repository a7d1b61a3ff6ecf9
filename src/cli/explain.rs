//! `ncfix explain`: the long text of a diagnostic code.

use std::fmt::Write as _;

use super::arguments::ExplainArguments;
use super::exit_code::ExitCode;
use super::print;
use super::stop::Stop;
use ncfix_base::diagnostic::{CODES, Code};

/// Prints the text of a code, or the list of codes.
pub(super) fn run(arguments: &ExplainArguments) -> Result<ExitCode, Stop> {
    let Some(text) = &arguments.code else {
        let mut list = String::new();
        for row in CODES {
            // Writing into a String cannot fail.
            let _ = writeln!(list, "{}  {}", row.code, row.title);
        }
        print(&list)?;
        return Ok(ExitCode::Done);
    };
    let row = Code::find(text)
        .ok_or_else(|| Stop::Usage(format!("unknown code '{text}'; `ncfix explain` lists all codes")))?;
    print(&format!("{}: {}\n\n{}\n", row.code, row.title, row.explain))?;
    Ok(ExitCode::Done)
}
