//! `ncfix load`: weighs the workpiece from readings of a strain gauge.

pub(in crate::cli) mod arguments;

use std::fmt::Write as _;

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
use ncfix_machine::machine::condition::file::load_text;
use ncfix_metrology::measure::strain;
use ncfix_metrology::measure::weighing::{self, Coordinate, Weighing};
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
    fill(report, &weighing);
    if let (Some(target), Some(path)) = (target, &arguments.output) {
        let text = state(&weighing, source.name(), &chosen.machine.name);
        pages::publish(target, &text)?;
        report.output = Some(path.display().to_string());
    }
    Ok(())
}

fn fill(report: &mut load::Load, weighing: &Weighing) {
    report.force_n = Some(weighing.force_n.value);
    report.force_sigma_n = Some(weighing.force_n.sigma);
    report.place = Some(weighing.position_mm.map(|coordinate| {
        let (sigma_mm, basis) = match coordinate {
            Coordinate::Measured(measured) => (Some(measured.sigma), "measured"),
            Coordinate::Known(_) => (None, "known"),
            Coordinate::Assumed => (None, "assumed"),
        };
        load::Coordinate { value_mm: coordinate.value(), sigma_mm, basis }
    }));
    report.noise_um_m = Some(weighing.noise_um_m);
    report.degrees_of_freedom = weighing.freedom;
    report.readings = weighing.used;
    report.left_out = weighing.left_out.len();
}

/// The state file.
fn state(weighing: &Weighing, data: &str, machine: &str) -> String {
    // A name may have any character; a comment ends with its line.
    let name = |text: &str| text.replace(char::is_control, " ");
    let mut text = format!("# Weighed by strain on {} from {}.\n", name(machine), name(data));
    let sigma = |coordinate: &Coordinate| match coordinate {
        Coordinate::Measured(measured) => format!("{:.1}", measured.sigma),
        Coordinate::Known(_) => "known".to_owned(),
        Coordinate::Assumed => "assumed".to_owned(),
    };
    let [x, y, z] = [0, 1, 2].map(|i| sigma(&weighing.position_mm[i]));
    // Writing into a String cannot fail.
    let _ = writeln!(text, "# Standard uncertainties: {:.1} N; X {x}, Y {y}, Z {z} (mm).", weighing.force_n.sigma);
    text + &load_text(&weighing.load())
}
