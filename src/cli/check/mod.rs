//! `ncfix check`: executes and corrects a program like `ncfix fix`, reports every diagnostic, and writes nothing.

use crate::check::{self, Checked};
use crate::cli::arguments::CheckArguments;
use crate::cli::exit_code::ExitCode;
use crate::cli::findings::Findings;
use crate::cli::stop::Stop;
use crate::cli::{machine_choice, print, program, progress, tell};
use crate::options::Options;
use ncfix_report::{json, number::grouped};

/// Checks a program.
pub(in crate::cli) fn run(arguments: &CheckArguments) -> Result<ExitCode, Stop> {
    let mut findings = Findings::default();
    let (checked, machine, faulty) = examine(arguments, &mut findings)?;
    let Checked { parsed, executed, support_file, elements } = checked;
    if arguments.json {
        let diagnostics = findings.json();
        let check = json::ProgramCheck { parsed, executed, machine, support_file, elements, diagnostics };
        print(&json::line(&check).map_err(Stop::Usage)?)?;
    } else {
        findings.draw();
        let is_faulty = faulty.map(|file| format!("not examined, because of an error in {file}"));
        let done = is_faulty.unwrap_or_else(|| match (parsed, executed) {
            (true, _) if support_file.is_some() => {
                format!("understood; a support file, not a program: {}", support_file.unwrap_or_default())
            }
            (true, false) if arguments.syntax_only => "understood".to_owned(),
            (_, false) if findings.has_language_errors() => "not understood".to_owned(),
            (_, false) => "understood, but a correction would be refused".to_owned(),
            _ => format!("understood and executed, {} moves and functions", grouped(elements)),
        });
        tell(&format!("{}: {done}; {}\n", arguments.input.display(), findings.count()));
    }
    Ok(findings.exit_code())
}

/// Parses, executes and corrects unless `--syntax-only`; with the name of the machine, or else with what has errors that prevent it.
fn examine(
    arguments: &CheckArguments,
    findings: &mut Findings,
) -> Result<(Checked, Option<String>, Option<String>), Stop> {
    let program = program::of(&arguments.input, &arguments.program)?;
    if let Some(checked) = Checked::of_text(&program) {
        return Ok((checked, None, None));
    }
    // Only the dialect can affect the syntax, so a machine is read only if one is named.
    let search = machine_choice::MachineSearch::of_program(&arguments.input);
    let machine = match arguments.syntax_only && arguments.machine.machine.is_none() {
        true => None,
        false => {
            let found = machine_choice::choose_in(&arguments.machine, &arguments.state, search, findings)?;
            if found.is_none() {
                return Ok((Checked::default(), None, Some(check::faulty_file(findings))));
            }
            found
        }
    };
    let options = Options { require_coverage: arguments.require_coverage, ..arguments.correction.options() };
    let how = (arguments.syntax_only, &options);
    let name = machine.as_ref().filter(|_| !arguments.syntax_only).map(|chosen| chosen.machine.name.clone());
    Ok((program.examine(machine.as_ref(), how, Some(progress::watch), findings)?, name, None))
}
