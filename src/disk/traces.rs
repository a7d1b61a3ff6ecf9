//! Reads traces: tables with a description of `kind = "trace"`, and recordings of a control in its own format.

use std::path::{Path, PathBuf};

use super::files;
use super::measurements::description_of;
use crate::diagnostics::Diagnostics;
use crate::error::Error;
use ncfix_base::diagnostic::{Code, Diagnostic, Place};
use ncfix_base::source::{FileId, Source, Span};
use ncfix_machine::machine::Machine;
use ncfix_metrology::measure::trace::{self, Trace, xml};
use ncfix_metrology::results::measurement::control_file;

/// A trace with its files: table, description, and recording of the control.
pub(crate) struct Read {
    pub(crate) trace: Trace,
    pub(crate) sources: Vec<Source>,
}

/// Reads a trace; `None` if there are errors. `number` identifies the file.
///
/// # Errors
/// If a file cannot be read.
pub(crate) fn read(
    table: &Path,
    number: usize,
    machine: &Machine,
    findings: &mut Diagnostics,
) -> Result<Option<Read>, Error> {
    let description = description_of(table)?;
    let id = |offset: usize| FileId(u16::try_from(3 * number + offset).unwrap_or(u16::MAX));
    let mut sources = vec![
        files::read(table, id(1), "trace")?,
        files::read_written(&description, id(2), files::FileRole::Description)?,
    ];
    let name = table.file_stem().map_or_else(String::new, |stem| stem.to_string_lossy().into_owned());
    let Some((described, found)) = trace::describe(&name, &sources[1]) else {
        let place = Place { file: sources[1].id(), span: Span::new(0, 0) };
        let help = "write kind = \"trace\" below [measurement], or use ncfix calibrate or ncfix diagnose";
        findings.add(Diagnostic::at(Code::BAD_VALUE, place, "the description is not that of a trace", help), &sources);
        return Ok(None);
    };
    findings.extend(found, &sources);
    let Some(described) = described else { return Ok(None) };
    let mut control = None;
    if let Some(path) = control_file(table, &described) {
        sources.push(files::read(&path, id(3), "record of the control")?);
        match xml::read(&sources[2], &described.signals, machine) {
            Ok(signals) => control = Some(signals),
            Err(found) => {
                findings.extend(found, &sources);
                return Ok(None);
            }
        }
    }
    let (trace, found) = trace::read(&described, &sources[0], control.as_ref(), machine);
    findings.extend(found, &sources);
    Ok(trace.map(|trace| Read { trace, sources }))
}

/// All table files, which must not be overwritten; a file that cannot be read is reported later.
pub(crate) fn files(tables: &[PathBuf]) -> Vec<PathBuf> {
    let mut files = Vec::new();
    for table in tables {
        files.push(table.clone());
        let Ok(description) = description_of(table) else { continue };
        if let Ok(source) = files::read(&description, FileId(0), "")
            && let Some((Some(described), _)) = trace::describe("", &source)
        {
            files.extend(control_file(table, &described));
        }
        files.push(description);
    }
    files
}

/// Joins the traces of one set-up.
pub(crate) fn joined(all: Vec<Read>, findings: &mut Diagnostics) -> Option<(Trace, Vec<Source>)> {
    let mut sources = Vec::new();
    let mut whole: Option<Trace> = None;
    for one in all {
        let place = Place { file: one.sources[1].id(), span: Span::new(0, 0) };
        if let Some(whole) = &mut whole {
            let is_same = whole.ball_mm == one.trace.ball_mm
                && whole.free == one.trace.free
                && whole.runs.first().map(|run| run.tool_mm) == one.trace.runs.first().map(|run| run.tool_mm);
            if !is_same {
                let help = "decompose each set-up separately: ball, tool and free must be the same in all traces";
                findings
                    .add(Diagnostic::at(Code::BAD_VALUE, place, "this trace has another set-up", help), &one.sources);
                return None;
            }
            whole.runs.extend(one.trace.runs);
        } else {
            whole = Some(one.trace);
        }
        sources.extend(one.sources);
    }
    let whole = whole?;
    if whole.runs.len() > 1 && whole.runs.iter().any(|run| run.feed_mm_min.is_none()) {
        let help = "fill the column feed_mm_min, or write feed_mm_min below [measurement] of each description";
        findings.add(Diagnostic::nowhere(Code::DATA_COLUMN, "runs without a programmed feed", help), &sources);
        return None;
    }
    Some((whole, sources))
}
