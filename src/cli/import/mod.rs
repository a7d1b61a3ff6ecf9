//! `ncfix import`: turns the file of an instrument into a measurement.

pub(in crate::cli) mod arguments;

use std::io::{BufRead as _, IsTerminal as _};
use std::path::Path;

use crate::cli::arguments::ImportArguments;
use crate::cli::exit_code::ExitCode;
use crate::cli::findings::Findings;
use crate::cli::stop::Stop;
use crate::cli::{input, machine_choice, print, progress, say, tell};
use crate::import::{InstrumentFiles, QuestionToPerson, is_yes};
use crate::next_line;
use crate::registry::Registry;
use ncfix_base::diagnostic::Code;
use ncfix_instruments::preview::list;

/// Imports files, or lists the formats.
pub(in crate::cli) fn run(arguments: &ImportArguments) -> Result<ExitCode, Stop> {
    if arguments.list || arguments.files.is_empty() {
        print(&list(&Registry::default().instrument_formats))?;
        return Ok(ExitCode::Done);
    }
    let mut findings = Findings::default();
    let result = import(arguments, &mut findings);
    findings.draw();
    let Some((text, is_partial)) = result? else {
        tell(&format!("{}; nothing was written\n", findings.count()));
        return Ok(findings.exit_code());
    };
    tell(&text);
    Ok(if is_partial { ExitCode::Different } else { findings.exit_code() })
}

/// Reads, asks, shows and writes; `None` if a file is refused. True if files of a folder that may have readings were not read.
fn import(arguments: &ImportArguments, findings: &mut Findings) -> Result<Option<(String, bool)>, Stop> {
    let paths = &arguments.files;
    let Some(mut files) = InstrumentFiles::read(paths, findings)? else { return Ok(None) };
    let first = paths.first().map_or(Path::new("-"), |path| path);
    let Some(machine) = machine_choice::choose(&arguments.machine, first, findings)? else { return Ok(None) };
    if findings.first_of(Code::NO_MACHINE).is_some() {
        findings.withdraw(Code::NO_MACHINE);
        files.ask_without_machine(arguments.format.as_deref(), &arguments.answers.0, &machine, findings);
        return Ok(None);
    }
    let is_asked = is_attended() && !paths.iter().any(|path| input::is_standard_stream(path));
    let mut by_person = ask;
    let asker: Option<QuestionToPerson<'_, Stop>> = if is_asked { Some(&mut by_person) } else { None };
    let stated = (arguments.format.as_deref(), &arguments.answers.0);
    let Some(all) = files.understood(stated, &machine, asker, findings)? else { return Ok(None) };
    let shown = files.preview(&all);
    let Some(output) = &arguments.output else {
        print(&shown)?;
        let text = "nothing was written; give -o NAME to write NAME.csv and NAME.toml\n";
        return Ok(Some((files.unread_files() + text, files.is_partial())));
    };
    tell(&shown);
    if is_asked && !arguments.yes && !ask("write the measurement? (y or n)")?.is_some_and(|text| is_yes(&text)) {
        return Ok(Some(("nothing was written\n".to_owned(), files.is_partial())));
    }
    let inputs = machine.files.iter().chain(files.paths()).cloned().collect::<Vec<_>>();
    let Some(text) = files.write(&all, output, &inputs, arguments.force, findings)? else { return Ok(None) };
    Ok(Some((text + &next_line::after_import(output, &machine), files.is_partial())))
}

/// True if a person can answer on the terminal.
pub(in crate::cli) fn is_attended() -> bool {
    std::io::stdin().is_terminal() && std::io::stderr().is_terminal()
}

/// Asks a question on the terminal; `None` if there is no answer.
pub(in crate::cli) fn ask(question: &str) -> Result<Option<String>, Stop> {
    progress::end();
    say(&format!("{question}: "));
    let mut line = String::new();
    std::io::stdin()
        .lock()
        .read_line(&mut line)
        .map_err(|error| Stop::Usage(format!("no answer can be read: {error}")))?;
    Ok(Some(line.trim().to_owned()).filter(|line| !line.is_empty()))
}
