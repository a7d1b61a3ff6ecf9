//! `ncfix resume`: shows the plan to resume an interrupted job, and runs it only with its number.

use crate::cli::arguments::{self, Command, FeedArguments, ResumeArguments};
use crate::cli::exit_code::ExitCode;
use crate::cli::feed;
use crate::cli::findings::Findings;
use crate::cli::stop::Stop;
use crate::cli::{print, progress, tell};
use crate::feed::{Broken, began_with, check_same, plan, read_broken};
use ncfix_base::diagnostic::{Code, Diagnostic};
use ncfix_dnc::feed::JournalContents;
use ncfix_report::json;

/// Shows the plan, or runs it.
pub(in crate::cli) fn run(arguments: &ResumeArguments) -> Result<ExitCode, Stop> {
    let Broken { source, told } = read_broken(&arguments.journal)?;
    let shown = arguments.journal.display();
    let mut feed = arguments_of(&told)?;
    if arguments.port.is_some() {
        feed.port.clone_from(&arguments.port);
    }
    // A check at the start of the job is no check now.
    feed.i_checked_the_machine_stands_still = arguments.i_checked_the_machine_stands_still;
    feed.journal = Some(arguments.journal.clone());
    let mut findings = Findings::default();
    let Some((job, before)) = feed::prepare(&feed, &mut findings)? else {
        findings.draw();
        return Ok(findings.exit_code());
    };
    check_same(&told, &job, &before, &mut findings);
    if feed.dosing.zero_now {
        let message = "drift is relative to the condition at the start of the job (--zero-now), which is unknown now";
        let help = "touch off the workpiece zero again, remove the journal, and feed the program from the beginning with --zero-now";
        findings.add(Diagnostic::nowhere(Code::OTHER_JOB, message, help), &[]);
    }
    if findings.has_errors() {
        return Ok(nothing_sent(&findings));
    }
    let names = (feed.input.display().to_string(), feed.port.clone().unwrap_or_default());
    let from = (source.bytes(), arguments.clearance);
    let (plan, begin) = match plan(&told, names, &job, Some(progress::watch), from)? {
        Ok(planned) => planned,
        Err(finding) => {
            findings.add(finding, &[]);
            return Ok(nothing_sent(&findings));
        }
    };
    match &arguments.confirm {
        None => {
            print(&if arguments.json {
                json::line(&plan).map_err(Stop::Usage)?
            } else {
                plan.table(&shown.to_string())
            })?;
            Ok(ExitCode::Done)
        }
        Some(confirmed) if *confirmed == plan.plan => {
            tell(&format!("resuming at line {} of the original\n", plan.source_line));
            feed::send(&feed, job, &before, &begin)
        }
        Some(confirmed) => Err(Stop::Usage(format!(
            "{confirmed} is not the plan number of this journal: read the plan first, which has it (ncfix resume {shown})"
        ))),
    }
}

/// Reports that the transfer is not possible because of errors.
fn nothing_sent(findings: &Findings) -> ExitCode {
    findings.draw();
    tell(&format!("{}; nothing was sent\n", findings.count()));
    findings.exit_code()
}

/// Arguments at the start of the job.
fn arguments_of(told: &JournalContents) -> Result<FeedArguments, Stop> {
    let words = std::iter::once("ncfix").chain(began_with(told)?);
    match arguments::parse(words.map(std::ffi::OsString::from)) {
        Ok((_, Command::Feed(feed))) => Ok(*feed),
        _ => Err(Stop::Usage("the journal does not contain the command line of the job".into())),
    }
}
