//! `ncfix weigh`: weighs the workpiece from readings of a strain gauge.

pub(in crate::cli) mod arguments;

use crate::cli::arguments::LoadArguments;
use crate::cli::exit_code::ExitCode;
use crate::cli::findings::Findings;
use crate::cli::input::is_standard_stream;
use crate::cli::output::Target;
use crate::cli::program::protect;
use crate::cli::stop::Stop;
use crate::cli::{deliver, input, machine_choice, pages};
use ncfix_base::csv::Table;
use ncfix_base::diagnostic::{Code, Diagnostic};
use ncfix_base::source::FileId;
use ncfix_metrology::measure::strain;
use ncfix_metrology::measure::weighing;
use ncfix_report::{json, load};

/// Weighs.
pub(in crate::cli) fn run(arguments: &LoadArguments) -> Result<ExitCode, Stop> {
    let goes_out = arguments.output.as_deref().is_some_and(is_standard_stream);
    if arguments.json && goes_out {
        return Err(Stop::Usage("--json and the state cannot both go to standard output; give -o a file".into()));
    }
    let mut findings = Findings::default();
    let mut report = load::Load::default();
    let result = weigh(arguments, &mut findings, &mut report);
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

fn weigh(arguments: &LoadArguments, findings: &mut Findings, report: &mut load::Load) -> Result<(), Stop> {
    let source = input::read(&arguments.data, FileId(0), "readings")?;
    let sources = std::slice::from_ref(&source);
    let target = arguments.output.as_deref().map(Target::new).transpose()?;
    let Some(chosen) = machine_choice::choose(&arguments.machine, &arguments.data, findings)? else { return Ok(()) };
    report.machine.clone_from(&chosen.machine.name);
    if let Some(target) = &target {
        protect(target, chosen.files.iter().chain([&arguments.data]), findings);
    }
    let Some(gauge) = &chosen.machine.strain else {
        let message = format!("the machine {} has no section [strain]", chosen.machine.name);
        let help = "give the signals of the strain gauge in [strain] of the machine file, or the load itself";
        findings.add(Diagnostic::nowhere(Code::MISSING_KEY, message, help), &[]);
        return Ok(());
    };
    let (table, found) = Table::read(&source);
    findings.extend(found, sources);
    let Some(table) = table else { return Ok(()) };
    let readings = match strain::read(&table, gauge) {
        Ok(readings) => readings,
        Err(found) => {
            findings.extend(found, sources);
            return Ok(());
        }
    };
    let (weighing, found) = weighing::weigh(&readings, gauge, arguments.known.unwrap_or_default());
    findings.extend(found, sources);
    let Some(weighing) = weighing.filter(|_| !findings.has_errors()) else { return Ok(()) };
    report.note(&weighing);
    if let (Some(target), Some(path)) = (target, &arguments.output) {
        let text = weighing.state_text(source.name(), &chosen.machine.name);
        pages::publish(target, &text)?;
        report.output = Some(path.display().to_string());
    }
    Ok(())
}
