//! Writes the files of compensation tables and their picture: all of them, or none.

use std::path::{Path, PathBuf};

use super::arguments::TablesArguments;
use super::findings::Findings;
use super::input::{self, is_standard_stream};
use super::output::Target;
use super::stop::Stop;
use super::together::Together;
use super::{pages, program};
use ncfix_base::diagnostic::{Code, Diagnostic};
use ncfix_base::source::FileId;
use ncfix_report::page;
use ncfix_report::tables::{TablesReport, charts, picture};
use ncfix_tables::tables::{Format, Tables, Wiring};

/// The files of tables; none where the control cannot take them, which the findings say.
pub(super) fn texts(
    format: &Format,
    tables: &Tables,
    wiring: &Wiring,
    notes: &[String],
    output: &Path,
    findings: &mut Findings,
) -> Result<Vec<(PathBuf, String)>, Stop> {
    for fault in format.faults_of(tables, wiring) {
        let help = "try --scheme auto, fewer --points or a larger --tolerance; ncfix tables --list shows the limits";
        findings.add(Diagnostic::nowhere(Code::TABLES_DO_NOT_FIT, fault, help), &[]);
    }
    if findings.has_errors() {
        return Ok(Vec::new());
    }
    let written = (format.write)(tables, wiring, notes);
    if is_standard_stream(output) && written.len() > 1 {
        let what = format!("{} are {} files, and standard output is one", format.title, written.len());
        return Err(Stop::Usage(format!("{what}; give -o the name that they begin with, such as -o mill")));
    }
    let stem = output.file_stem().unwrap_or_default().to_string_lossy().into_owned();
    let name = |suffix: &str| {
        if suffix.is_empty() || is_standard_stream(output) {
            output.to_owned()
        } else {
            output.with_file_name(format!("{stem}{suffix}"))
        }
    };
    Ok(written.into_iter().map(|one| (name(&one.suffix), one.text)).collect())
}

/// Writes all files and the picture, or none.
pub(super) fn publish(
    arguments: &TablesArguments,
    mut files: Vec<(PathBuf, String)>,
    sets: &[(&str, &Tables)],
    inputs: Vec<PathBuf>,
    report: &mut TablesReport,
    findings: &mut Findings,
) -> Result<(), Stop> {
    if findings.has_errors() {
        return Ok(());
    }
    if let Some(path) = &arguments.svg {
        files.push((path.clone(), picture(sets)));
    }
    let mut together = Together::default();
    for (path, text) in &files {
        let target = Target::new(path)?;
        if arguments.json && target == Target::Standard {
            return Err(Stop::Usage("--json and the tables cannot both go to standard output; give -o a file".into()));
        }
        program::protect(&target, inputs.iter(), findings);
        if findings.has_errors() {
            return Ok(());
        }
        together.add(target, text.as_bytes())?;
    }
    let page = arguments.report.as_deref().map(pages::file).transpose()?;
    if let Some(page) = &page {
        program::protect(page, inputs.iter(), findings);
        if let Some((path, _)) = files.iter().find(|(path, _)| page.is(path) || Some(path) == arguments.report.as_ref())
        {
            return Err(Stop::Usage(format!("--report and {} are one file", path.display())));
        }
    }
    if findings.has_errors() {
        return Ok(());
    }
    report.written = files.iter().map(|(path, _)| path.display().to_string()).collect();
    if let (Some(page), Some(path)) = (page, &arguments.report) {
        report.diagnostics = findings.json();
        let mut all = Vec::new();
        for path in &inputs {
            all.push(pages::input(&input::read(path, FileId(0), "file")?, "read"));
        }
        together.add(page, page::tables::tables(report, &charts(sets), &all).as_bytes())?;
        report.written.push(path.display().to_string());
    }
    Ok(together.publish()?)
}
