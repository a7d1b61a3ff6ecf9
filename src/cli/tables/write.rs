//! Writes the files of compensation tables and their picture: all of them, or none.

use std::path::PathBuf;

use crate::cli::arguments::TablesArguments;
use crate::cli::atomic_writes::AtomicWrites;
use crate::cli::findings::Findings;
use crate::cli::output::Target;
use crate::cli::stop::Stop;
use crate::cli::{input, pages, program};
use ncfix_base::source::FileId;
use ncfix_report::page;
use ncfix_report::tables::{TablesReport, charts, picture};
use ncfix_tables::tables::Tables;

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
    let mut together = AtomicWrites::default();
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
            return Err(Stop::Usage(format!("--report and {} name the same file", path.display())));
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
