//! `ncfix check`: parses and executes a program, looks whether the axes reach where it leads, reports every finding, writes nothing.

use super::arguments::CheckArguments;
use super::exit_code::ExitCode;
use super::findings::Findings;
use super::machine_choice::{self, Chosen};
use super::program::{self, Running};
use super::stop::Stop;
use super::support_file;
use super::{print, tell};
use ncfix_base::diagnostic::Code;
use ncfix_base::source::Source;
use ncfix_language::exec::RapidOrder;
use ncfix_language::syntax::Program;
use ncfix_path::path::Reach;
use ncfix_report::json;
use ncfix_report::number::grouped;

/// Behind so many blocks that are not understood nothing is sure.
const MOST_ERRORS: u32 = 1000;

/// Checks a program.
pub(super) fn run(arguments: &CheckArguments) -> Result<ExitCode, Stop> {
    let mut findings = Findings::default();
    let mut check =
        json::Check { parsed: false, executed: false, support_file: None, elements: 0, diagnostics: Vec::new() };
    examine(arguments, &mut findings, &mut check)?;
    if arguments.json {
        check.diagnostics = findings.json();
        print(&json::line(&check).map_err(Stop::Usage)?)?;
    } else {
        findings.draw();
        let done = match (check.parsed, check.executed) {
            (true, _) if check.support_file.is_some() => {
                format!("understood, no program but a support file: {}", check.support_file.unwrap_or_default())
            }
            (false, _) => "not understood".to_owned(),
            (true, false) if arguments.syntax_only => "understood".to_owned(),
            (true, false) => "understood, not executed to its end".to_owned(),
            (true, true) => format!("understood and executed, {} elements", grouped(check.elements)),
        };
        tell(&format!("{}: {done}; {}\n", arguments.input.display(), findings.count()));
    }
    Ok(findings.exit_code())
}

/// Parses, and executes unless `--syntax-only`.
fn examine(arguments: &CheckArguments, findings: &mut Findings, check: &mut json::Check) -> Result<(), Stop> {
    let source = program::read(&arguments.input)?;
    if let Some(kind) = support_file::kind_of_text(&source) {
        // Another language: there is nothing to understand for a program.
        check.parsed = true;
        check.support_file = Some(kind);
        return Ok(());
    }
    // Only the dialect could matter to the syntax, so a machine is read where one is named, and the demo machine is no topic.
    let chosen = if arguments.syntax_only && arguments.machine.machine.is_none() {
        None
    } else {
        machine_choice::choose(&arguments.machine, &arguments.input, findings)?
    };
    let Some(opened) = program::open(&source, &arguments.program, chosen.as_ref(), findings)? else { return Ok(()) };
    check.parsed = true;
    check.support_file = match &opened.program {
        Program::Sinumerik(program) => support_file::kind(program),
        Program::Words(_) => None,
    };
    if check.support_file.is_some() {
        return Ok(());
    }
    let Some(chosen) = chosen.filter(|_| !arguments.syntax_only) else { return Ok(()) };
    let mut running =
        Running::start(opened, &arguments.input, &arguments.program, &chosen.machine, false, RapidOrder::All);
    check.executed = true;
    // Nobody's program is for the demo machine.
    let mut reach = (!chosen.is_demo).then(|| Reach::new(&chosen.machine, arguments.program.start));
    let mut is_beyond = false;
    while let Some(item) = running.next() {
        match item {
            Ok(element) => {
                check.elements += u64::from(element.kind.is_in_text());
                if let Some(reach) = &mut reach {
                    is_beyond |= reach.note(&element).count() > 0;
                }
            }
            Err(diagnostic) => {
                check.executed &= !diagnostic.is_error();
                findings.add(diagnostic, running.sources());
                if findings.is_hopeless() {
                    break;
                }
            }
        }
    }
    if check.executed && !running.moves() {
        findings.add(program::without_motion(&source, Code::MOVES_NOTHING), running.sources());
    }
    if is_beyond {
        travel(&source, arguments, &chosen, findings)?;
    }
    Ok(())
}

/// Says where axes would leave their travel, as far as the program tells: what only an assumed place would do is no finding. For that it is executed as
/// for a correction.
fn travel(source: &Source, arguments: &CheckArguments, chosen: &Chosen, findings: &mut Findings) -> Result<(), Stop> {
    let mut again = Findings::default();
    let Some(opened) = program::open(source, &arguments.program, Some(chosen), &mut again)? else { return Ok(()) };
    let (program, machine) = (&arguments.program, &chosen.machine);
    let mut running = Running::start(opened, &arguments.input, program, machine, true, RapidOrder::All);
    let mut reach = Reach::new(machine, program.start);
    let mut errors = 0;
    while let Some(item) = running.next() {
        match item {
            Ok(element) => reach.note(&element).for_each(|found| findings.add(found, running.sources())),
            Err(found) => errors += u32::from(found.is_error()),
        }
        if errors > MOST_ERRORS || findings.is_hopeless() {
            break;
        }
    }
    Ok(())
}
