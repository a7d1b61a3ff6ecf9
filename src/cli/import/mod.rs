//! `ncfix import`: turns the file of an instrument into a measurement.

pub(in crate::cli) mod arguments;

use std::io::{BufRead as _, IsTerminal as _};
use std::path::Path;

use crate::cli::arguments::ImportArguments;
use crate::cli::exit_code::ExitCode;
use crate::cli::findings::Findings;
use crate::cli::stop::Stop;
use crate::cli::{input, machine_choice, print, progress, say, tell};
use crate::import::InstrumentFile;
use crate::registry::Registry;
use ncfix_base::diagnostic::Code;
use ncfix_instruments::ImportOutcome;
use ncfix_instruments::preview::{list, preview};
use ncfix_instruments::readings::ImportedReadings;

/// Imports a file, or lists the formats.
pub(in crate::cli) fn run(arguments: &ImportArguments) -> Result<ExitCode, Stop> {
    let Some(file) = arguments.file.as_deref().filter(|_| !arguments.list) else {
        print(&list(&Registry::default().instrument_formats))?;
        return Ok(ExitCode::Done);
    };
    let mut findings = Findings::default();
    let result = import(arguments, file, &mut findings);
    findings.draw();
    match result? {
        Some(text) => tell(&text),
        None => tell(&format!("{}; nothing was written\n", findings.count())),
    }
    Ok(findings.exit_code())
}

/// Reads, asks, shows and writes; `None` if the file is refused.
fn import(arguments: &ImportArguments, path: &Path, findings: &mut Findings) -> Result<Option<String>, Stop> {
    let Some(file) = InstrumentFile::read(path, findings)? else { return Ok(None) };
    let Some(machine) = machine_choice::choose(&arguments.machine, path, findings)? else { return Ok(None) };
    if findings.first_of(Code::NO_MACHINE).is_some() {
        findings.withdraw(Code::NO_MACHINE);
        file.ask_without_machine(arguments.format.as_deref(), &arguments.answers.0, &machine, findings);
        return Ok(None);
    }
    let is_asked =
        std::io::stdin().is_terminal() && std::io::stderr().is_terminal() && !input::is_standard_stream(path);
    let mut answers = arguments.answers.0.clone();
    let readings: ImportedReadings = loop {
        let Some(outcome) = file.readings(arguments.format.as_deref(), &answers, &machine, findings) else {
            return Ok(None);
        };
        let questions = match outcome {
            ImportOutcome::Readings(readings) => break *readings,
            ImportOutcome::Questions(questions) => questions,
        };
        if !is_asked {
            questions.iter().for_each(|question| findings.add(question.refusal(), &[]));
            return Ok(None);
        }
        for question in questions {
            let Some(text) = ask(&format!("{} ({})", question.sentence, question.advice))? else {
                findings.add(question.refusal(), &[]);
                return Ok(None);
            };
            if question.option == "flat-reference" {
                answers.is_flat_reference = is_yes(&text);
            } else if let Err(sentence) = answers.set(question.option, &text) {
                say(&format!("{sentence}\n"));
            }
        }
    };
    let Some(output) = &arguments.output else {
        print(&preview(&readings))?;
        return Ok(Some("nothing was written; give -o NAME to write NAME.csv and NAME.toml\n".to_owned()));
    };
    tell(&preview(&readings));
    if is_asked && !arguments.yes && !ask("write the measurement? (y or n)")?.is_some_and(|text| is_yes(&text)) {
        return Ok(Some("nothing was written\n".to_owned()));
    }
    let inputs = machine.files.iter().cloned().chain([path.to_owned()]).collect::<Vec<_>>();
    let written = file.write(&readings, output, &inputs, arguments.force, findings)?;
    Ok(written.map(|[table, description]| format!("wrote {} and {}\n", table.display(), description.display())))
}

/// Asks a question on the terminal; `None` if there is no answer.
fn ask(question: &str) -> Result<Option<String>, Stop> {
    progress::end();
    say(&format!("{question}: "));
    let mut line = String::new();
    std::io::stdin()
        .lock()
        .read_line(&mut line)
        .map_err(|error| Stop::Usage(format!("no answer can be read: {error}")))?;
    Ok(Some(line.trim().to_owned()).filter(|line| !line.is_empty()))
}

/// True for an affirmative answer.
fn is_yes(text: &str) -> bool {
    text.to_lowercase().starts_with('y')
}
