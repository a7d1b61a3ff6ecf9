//! `ncfix load`: weighs the workpiece from readings of a strain gauge.

pub(in crate::cli) mod arguments;

use crate::cli::arguments::LoadArguments;
use crate::cli::exit_code::ExitCode;
use crate::cli::findings::Findings;
use crate::cli::input::is_standard_stream;
use crate::cli::output::Target;
use crate::cli::program::protect;
use crate::cli::stop::Stop;
use crate::cli::{deliver, input, machine_choice, pages};
use ncfix_base::source::FileId;
use ncfix_metrology::results::weighed::weigh;
use ncfix_report::{json, load};

/// Weighs.
pub(in crate::cli) fn run(arguments: &LoadArguments) -> Result<ExitCode, Stop> {
    let goes_out = arguments.output.as_deref().is_some_and(is_standard_stream);
    if arguments.json && goes_out {
        return Err(Stop::Usage("--json and the state cannot both go to standard output; give -o a file".into()));
    }
    let mut findings = Findings::default();
    let mut report = load::Load::default();
    let result = find(arguments, &mut findings, &mut report);
    let page = report.table();
    deliver(
        result,
        &findings,
        goes_out,
        page,
        arguments.json.then(|| {
            report.diagnostics = findings.json();
            json::line(&report)
        }),
    )
}

fn find(arguments: &LoadArguments, findings: &mut Findings, report: &mut load::Load) -> Result<(), Stop> {
    let source = input::read(&arguments.data, FileId(0), "readings")?;
    let target = arguments.output.as_deref().map(Target::new).transpose()?;
    let Some(chosen) = machine_choice::choose(&arguments.machine, &arguments.data, findings)? else { return Ok(()) };
    report.machine.clone_from(&chosen.machine.name);
    if let Some(target) = &target {
        protect(target, chosen.files.iter().chain([&arguments.data]), findings);
    }
    let mut found = Vec::new();
    let weighing = weigh(&source, &chosen.machine, arguments.known.unwrap_or_default(), &mut found);
    findings.extend(found, std::slice::from_ref(&source));
    let Some(weighing) = weighing.filter(|_| !findings.has_errors()) else { return Ok(()) };
    report.found = (&weighing).into();
    if let (Some(target), Some(path)) = (target, &arguments.output) {
        let text = weighing.state_text(source.name(), &chosen.machine.name);
        pages::publish(target, &text)?;
        report.output = Some(path.display().to_string());
    }
    Ok(())
}
