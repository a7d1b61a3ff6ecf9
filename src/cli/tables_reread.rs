//! `ncfix tables --read`: shows the tables of a control, checks them, compares them and converts them.

use std::path::PathBuf;

use super::arguments::TablesArguments;
use super::findings::Findings;
use super::stop::Stop;
use super::tables::worse;
use super::tables_compare::{difference, range_of};
use super::tables_job::{SEED, job};
use super::tables_read::{self, Reading};
use super::tables_write::{publish, texts};
use ncfix_base::geometry::Vector;
use ncfix_report::tables::TablesReport;
use ncfix_tables::tables::Wiring;

/// Tools whose tips are no farther apart are one, mm.
const SAME_TOOL_MM: f64 = 1e-6;

/// Reads tables and does with them what is asked.
pub(super) fn work(
    arguments: &TablesArguments,
    report: &mut TablesReport,
    findings: &mut Findings,
) -> Result<(), Stop> {
    let needs_machine = arguments.machine.machine.is_some() || arguments.check;
    let job = if needs_machine { job(arguments, findings)? } else { None };
    if needs_machine && job.is_none() {
        return Ok(());
    }
    let mut wiring = job.as_ref().map_or_else(Wiring::usual, |job| job.wiring.clone());
    arguments.axis_name.iter().for_each(|(axis, name)| wiring.rename(*axis, name));
    // A format to read in is only asked for where nothing is written.
    let asked = if arguments.output.is_none() { arguments.format } else { None };
    let multiplication = job
        .as_ref()
        .map_or_else(|| arguments.multiplication.map(|choice| choice.multiplication()), |job| job.multiplication());
    let machine = job.as_ref().map(|job| &job.chosen.machine);
    let reading = Reading { format: asked, multiplication, machine, wiring: &wiring };
    let Some(read) = tables_read::read(&arguments.read, &reading, findings)? else { return Ok(()) };
    report.note(&read.tables);
    report.format = read.names();
    if let Some(job) = &job {
        report.machine.clone_from(&job.chosen.machine.name);
        if arguments.check {
            report.check = Some(job.check(&read.tables));
            let other = read.tool_mm.filter(|own| (own - job.tool_mm).norm() > SAME_TOOL_MM);
            report.made_for_tool_mm = other.map(|own| [own.x, own.y, own.z]);
        }
    }
    let other = match &arguments.compare {
        None => None,
        Some(path) => {
            match tables_read::read(std::slice::from_ref(path), &Reading { format: None, ..reading }, findings)? {
                Some(other) => Some(other),
                None => return Ok(()),
            }
        }
    };
    if let Some(other) = &other {
        let both = [&read.tables, &other.tables];
        let found = match &job {
            Some(job) => difference(both, Some(&job.chosen.machine), &job.region, job.tool_mm, SEED, arguments.poses),
            None => difference(both, None, &range_of(both), Vector::zeros(), SEED, arguments.poses),
        };
        report.difference = found?;
    }
    let mut files = Vec::new();
    if let (Some(format), Some(output)) = (arguments.format, &arguments.output) {
        let mut tables = read.tables.clone();
        (format.round)(&mut tables);
        if let Some(job) = &job {
            let checked = job.everywhere(&tables, &job.check(&tables));
            if let Some(finding) = worse(&checked, &job.volume()) {
                findings.add(finding, &[]);
                return Ok(());
            }
        }
        let notes = [format!("read from {}", shown(&arguments.read))];
        files = texts(format, &tables, &wiring, &notes, output, findings)?;
        report.format = format!("{} as {}", read.names(), format.name);
    } else if arguments.output.is_some() {
        return Err(Stop::Usage("give --format to convert the tables, or leave -o out".into()));
    }
    let mut sets = vec![("", &read.tables)];
    if let Some(other) = &other {
        sets = vec![("first ", &read.tables), ("second ", &other.tables)];
    }
    let inputs: Vec<PathBuf> = arguments.read.iter().chain(&arguments.compare).cloned().collect();
    publish(arguments, files, &sets, inputs, report, findings)
}

fn shown(paths: &[PathBuf]) -> String {
    let names = paths.iter().map(|path| path.file_name().unwrap_or_default().to_string_lossy().into_owned());
    names.collect::<Vec<_>>().join(", ")
}
