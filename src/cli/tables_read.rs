//! Reads compensation tables of a control: files, several that belong together, archives.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use super::archive;
use super::findings::Findings;
use super::input;
use super::stop::Stop;
use crate::diagnostic::{Code, Diagnostic, Place};
use crate::geometry::Vector;
use crate::machine::Machine;
use crate::source::{FileId, Source, Span};
use crate::tables::{Control, FORMATS, Format, Tables, Wiring, format};

/// Tables that were read.
pub(super) struct ReadTables {
    pub(super) tables: Tables,
    pub(super) format: &'static Format,
    /// The tool that remarks of the file say they are for, from the gauge point to the tip, mm.
    pub(super) tool_mm: Option<Vector>,
}

/// Reads tables from files; `None` where findings forbid to use them.
///
/// # Errors
/// Where a file cannot be read, or nothing tells its format.
pub(super) fn read(
    paths: &[PathBuf],
    asked: Option<&'static Format>,
    wiring: &Wiring,
    findings: &mut Findings,
) -> Result<Option<ReadTables>, Stop> {
    let mut tables = Tables::default();
    let mut known = asked;
    let mut earlier: Vec<(Source, BTreeSet<usize>)> = Vec::new();
    let mut is_mixed = false;
    for path in paths {
        for source in members(path)? {
            let format = asked.or_else(|| format::guess(source.name(), source.bytes())).or(known);
            let Some(format) = format else { return Err(unknown(path)) };
            is_mixed |= known.is_some_and(|other| other.name != format.name);
            known = Some(format);
            let mut own = tables.clone();
            let mut found = (format.read)(&source, wiring, &mut own);
            let numbers = (format.numbers)(&source);
            found.extend(again(&source, &numbers, &earlier).or_else(|| second(&source, &numbers, &tables, &own)));
            tables = own;
            findings.extend(found, std::slice::from_ref(&source));
            earlier.push((source, numbers));
        }
    }
    let names: Vec<String> = paths.iter().map(|path| path.display().to_string()).collect();
    let names = names.join(", ");
    let nothing = || Stop::Usage(format!("no compensation table is in use in {names}"));
    let format = known.ok_or_else(nothing)?;
    if findings.has_errors() {
        return Ok(None);
    }
    // What the control would not take is damaged, or not what it seems.
    for fault in format.faults_of(&tables, wiring).into_iter().filter(|_| !is_mixed) {
        let help = "see that the file is whole and of this control; --format reads it as another one's";
        findings.add(Diagnostic::nowhere(Code::BAD_TABLES, format!("{names}: {fault}"), help), &[]);
    }
    if tables.is_empty() {
        return Err(nothing());
    }
    let tool_mm = earlier.iter().find_map(|(source, _)| tool_of(source.bytes()));
    Ok((!findings.has_errors()).then_some(ReadTables { tables, format, tool_mm }))
}

/// What is written before and behind the tool in a remark.
const TOOL: [&str; 2] = ["tool ", " mm from the gauge point"];
/// Lines in which such a remark stands.
const REMARKS: usize = 40;

/// The remark that says for which tool the tables are.
pub(super) fn tool_remark(tool_mm: &Vector) -> String {
    // No minus in front of zero.
    let [x, y, z] = [0, 1, 2].map(|index| tool_mm[index] + 0.0);
    format!("{}{x} {y} {z}{}", TOOL[0], TOOL[1])
}

/// The tool of such a remark.
fn tool_of(bytes: &[u8]) -> Option<Vector> {
    let lines = bytes.split(|&byte| byte == b'\n').filter_map(|line| std::str::from_utf8(line).ok());
    lines
        .take(REMARKS)
        .chain(bytes.rsplit(|&byte| byte == b'\n').filter_map(|line| std::str::from_utf8(line).ok()).take(REMARKS))
        .find_map(|line| {
            let (_, behind) = line.split_once(TOOL[0])?;
            let (numbers, _) = behind.split_once(TOOL[1])?;
            let mut numbers =
                numbers.split(' ').map(|number| number.parse::<f64>().ok().filter(|number| number.is_finite()));
            Some(Vector::new(numbers.next()??, numbers.next()??, numbers.next()??))
        })
}

/// A file that is there again, or that has a table of an earlier one: in the control the later one takes the place of the other.
fn again(source: &Source, numbers: &BTreeSet<usize>, earlier: &[(Source, BTreeSet<usize>)]) -> Option<Diagnostic> {
    let fault = |message: String, help: &str| {
        Some(Diagnostic::at(Code::BAD_TABLES, Place { file: source.id(), span: Span::new(0, 1) }, message, help))
    };
    for (other, known) in earlier {
        if other.bytes() == source.bytes() {
            let message = format!("this is {} once more", other.name());
            return fault(message, "name each file once: the control has its tables once");
        }
        if let Some(number) = numbers.intersection(known).next() {
            let message = format!("table {number} is in {} too", other.name());
            return fault(
                message,
                "name the files that are in the control now: of two with a table it has the later one",
            );
        }
    }
    None
}

/// A second table for the same, where tables have no numbers.
fn second(source: &Source, numbers: &BTreeSet<usize>, before: &Tables, after: &Tables) -> Option<Diagnostic> {
    if !numbers.is_empty() {
        return None;
    }
    let (known, new) = after.lookups.split_at(before.lookups.len().min(after.lookups.len()));
    let same = new.iter().find(|one| {
        known.iter().any(|other| (one.input, one.output, one.sense) == (other.input, other.output, other.sense))
    });
    let what = match same {
        Some(one) => format!("table of {} over {}", one.output, one.input),
        None if before.grid.is_some() && after.grid != before.grid => "grid".to_owned(),
        None if before.matrix.is_some() && after.matrix != before.matrix => "matrix".to_owned(),
        None => return None,
    };
    let message = format!("a second {what}");
    let place = Place { file: source.id(), span: Span::new(0, 1) };
    Some(Diagnostic::at(Code::BAD_TABLES, place, message, "name the files that are in the control now"))
}

/// The control with the tables that a machine file names as active, and the files; `None` where findings forbid to use them.
///
/// # Errors
/// Where a file cannot be read, or nothing tells its format.
pub(super) fn active(
    paths: &[PathBuf],
    machine: &Machine,
    findings: &mut Findings,
) -> Result<Option<(Control, Vec<Source>)>, Stop> {
    let read = read(paths, None, &Wiring::of(machine), findings)?;
    let mut sources = Vec::new();
    for path in paths {
        sources.extend(members(path)?);
    }
    Ok(read.map(|read| (Control::new(machine, &read.tables), sources)))
}

/// The files with tables at a path: the file itself, or those in an archive.
fn members(path: &Path) -> Result<Vec<Source>, Stop> {
    let source = input::read(path, FileId(0), "compensation tables")?;
    match archive::saved_data(path, source.bytes())? {
        None => Ok(vec![source]),
        Some(members) => {
            let is_table = |member: &Source| format::guess(member.name(), member.bytes()).is_some();
            Ok(members.into_iter().filter(is_table).collect())
        }
    }
}

fn unknown(path: &Path) -> Stop {
    let names: Vec<&str> = FORMATS.iter().map(|format| format.name).collect();
    Stop::Usage(format!("nothing in {} tells its format; give --format: {}", path.display(), names.join(", ")))
}
