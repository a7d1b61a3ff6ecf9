//! `ncfix check`: parses and executes a program, checks the travel of the axes and reports every diagnostic; writes nothing.

use crate::check::Checked;
use crate::cli::arguments::CheckArguments;
use crate::cli::exit_code::ExitCode;
use crate::cli::findings::Findings;
use crate::cli::stop::Stop;
use crate::cli::{machine_choice, print, program, progress, tell};
use ncfix_report::json;
use ncfix_report::number::counted;

/// Checks a program.
pub(in crate::cli) fn run(arguments: &CheckArguments) -> Result<ExitCode, Stop> {
    let mut findings = Findings::default();
    let Checked { parsed, executed, support_file, elements } = examine(arguments, &mut findings)?;
    if arguments.json {
        let check = json::ProgramCheck { parsed, executed, support_file, elements, diagnostics: findings.json() };
        print(&json::line(&check).map_err(Stop::Usage)?)?;
    } else {
        findings.draw();
        let done = match (parsed, executed) {
            (true, _) if support_file.is_some() => {
                format!("understood; a support file, not a program: {}", support_file.unwrap_or_default())
            }
            (false, _) => "not understood".to_owned(),
            (true, false) if arguments.syntax_only => "understood".to_owned(),
            (true, false) => "understood, not executed to the end".to_owned(),
            (true, true) => format!("understood and executed, {}", counted(elements, "element")),
        };
        tell(&format!("{}: {done}; {}\n", arguments.input.display(), findings.count()));
    }
    Ok(findings.exit_code())
}

/// Parses, and executes unless `--syntax-only`.
fn examine(arguments: &CheckArguments, findings: &mut Findings) -> Result<Checked, Stop> {
    let program = program::of(&arguments.input, &arguments.program)?;
    if let Some(checked) = Checked::of_text(&program) {
        return Ok(checked);
    }
    // Only the dialect can affect the syntax, so a machine is read only if one is named; the demo machine is irrelevant.
    let machine = if arguments.syntax_only && arguments.machine.machine.is_none() {
        None
    } else {
        machine_choice::choose(&arguments.machine, &arguments.input, findings)?
    };
    Ok(program.examine(machine.as_ref(), arguments.syntax_only, Some(progress::watch), findings)?)
}
