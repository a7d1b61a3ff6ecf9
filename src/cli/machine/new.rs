//! `ncfix machine new`: a machine file from a template, statements and data of the control.

use crate::cli::arguments::NewMachineArguments;
use crate::cli::atomic_writes::AtomicWrites;
use crate::cli::exit_code::ExitCode;
use crate::cli::findings::Findings;
use crate::cli::output::Target;
use crate::cli::stop::Stop;
use crate::cli::{import, pages, print, tell};
use crate::new_machine::{self, describe};
use crate::next_line;
use ncfix_machine::describe::Question;

/// Lists the templates, or writes a machine file.
pub(super) fn run(arguments: &NewMachineArguments) -> Result<ExitCode, Stop> {
    if arguments.list {
        print(&new_machine::templates())?;
        return Ok(ExitCode::Done);
    }
    let (Some(output), Some(like)) = (&arguments.output, &arguments.like) else {
        let sentence = "give the machine file to write, and --like TEMPLATE; --list lists the templates";
        return Err(Stop::Usage(sentence.into()));
    };
    if output.exists() {
        return Err(Stop::Usage(format!("{} exists already; choose another name", output.display())));
    }
    let target = Target::new(output)?;
    let goes_out = !target.is_file();
    let picture = arguments.picture.as_deref().map(pages::file).transpose()?;
    let mut findings = Findings::default();
    let made = describe(&arguments.request(), like, (&arguments.from, &arguments.setup), &mut ask, &mut findings);
    findings.draw();
    let Some(made) = made? else { return Ok(findings.exit_code()) };
    let mut together = AtomicWrites::default();
    together.add(target, made.text.as_bytes())?;
    if let Some(picture) = picture {
        together.add(picture, made.picture.as_bytes())?;
    }
    together.publish()?;
    if goes_out {
        tell(&made.sketch)
    } else {
        print(&made.sketch)?;
        tell(&next_line::after_new_machine(output, like));
    }
    Ok(findings.exit_code())
}

/// Asks on a terminal; nobody answers elsewhere.
fn ask(question: &Question) -> Option<String> {
    if import::is_attended() { import::ask(&question.text).ok().flatten() } else { None }
}
