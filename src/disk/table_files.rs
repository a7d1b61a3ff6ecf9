//! Reads compensation tables of a control: single files, sets of files, archives.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use super::archive;
use super::files;
use crate::diagnostics::Diagnostics;
use crate::error::Error;
use ncfix_base::diagnostic::{Code, Diagnostic, Place};
use ncfix_base::geometry::{AXES, Axis, Vector};
use ncfix_base::source::{FileId, Source, Span};
use ncfix_machine::machine::Machine;
use ncfix_tables::results::result::rounded_mm;
use ncfix_tables::tables::{Control, FORMATS, Format, Multiplication, Sense, Tables, Wiring, format};

/// Tables that were read.
pub(crate) struct ReadTables {
    pub(crate) tables: Tables,
    /// The formats that were found: a control may save tables of several kinds in one file.
    pub(crate) formats: Vec<&'static Format>,
    /// The tool stated in remarks of the file, from the gauge point to the tip, mm.
    pub(crate) tool_mm: Option<Vector>,
}

impl ReadTables {
    /// `cec, enc`
    pub(crate) fn names(&self) -> String {
        self.formats.iter().map(|format| format.name).collect::<Vec<_>>().join(", ")
    }
}

/// Options for reading files.
#[derive(Clone, Copy)]
pub(crate) struct TableReading<'a> {
    /// The format; detected from the files if not given.
    pub(crate) format: Option<&'static Format>,
    /// The value of a table that is multiplied by another one; as stated in the files if not given.
    pub(crate) multiplication: Option<Multiplication>,
    /// The machine whose control has the tables, if known.
    pub(crate) machine: Option<&'a Machine>,
    /// The axis names of the control.
    pub(crate) wiring: &'a Wiring,
}

/// The files read so far.
#[derive(Default)]
struct Files {
    /// The tables of each format.
    sets: Vec<(&'static Format, Tables)>,
    earlier: Vec<(Source, BTreeSet<usize>)>,
    /// The corrected axis, the input axis and the sign convention of tables without numbers.
    unnumbered: Vec<(Axis, Axis, Sense)>,
    /// The interpretation of products stated in the files.
    mark: Option<Multiplication>,
}

impl Files {
    fn read(
        &mut self,
        source: Source,
        format: &'static Format,
        reading: &TableReading<'_>,
    ) -> (Vec<Diagnostic>, Source) {
        let place = self.sets.iter().position(|(known, _)| known.name == format.name).unwrap_or_else(|| {
            self.sets.push((format, Tables::default()));
            self.sets.len() - 1
        });
        let Some((_, tables)) = self.sets.get_mut(place) else { return (Vec::new(), source) };
        let before = tables.lookups.len();
        let mut found = (format.read)(&source, reading.wiring, tables);
        let numbers = (format.numbers)(&source);
        let new = tables.lookups.get(before..).unwrap_or_default();
        let new: Vec<_> = new.iter().map(|one| (one.input, one.output, one.sense)).collect();
        if numbers.is_empty() {
            found.extend(second(&source, &new, &self.unnumbered));
            self.unnumbered.extend(new);
        }
        (found, source)
    }

    /// The multiplication stated in a file must be that of the other files.
    fn note_mark(&mut self, source: &Source) -> Option<Diagnostic> {
        let mark = format::multiplication_of(source);
        let fault = self.mark.zip(mark).filter(|(known, own)| known != own).map(|_| {
            let place = Place { file: source.id(), span: Span::new(0, 1) };
            let message = "its products are for another --multiplication than those of the files before it";
            Diagnostic::at(Code::BAD_TABLES, place, message, "make all of them for the same --multiplication")
        });
        self.mark = self.mark.or(mark);
        fault
    }
}

/// Reads tables from files; `None` if there are errors.
///
/// # Errors
/// If a file cannot be read, or its format cannot be detected.
pub(crate) fn read(
    paths: &[PathBuf],
    reading: &TableReading<'_>,
    findings: &mut Diagnostics,
) -> Result<Option<ReadTables>, Error> {
    let mut files = Files::default();
    for path in paths {
        let (sources, programs) = members(path)?;
        for program in &programs {
            findings.extend([not_read(program)], std::slice::from_ref(program));
        }
        for source in sources {
            let known = files.sets.last().map(|(format, _)| *format);
            let guesses = format::guesses(source.name(), source.bytes());
            let formats = match (reading.format, &guesses[..], known) {
                (Some(asked), ..) => vec![asked],
                (None, [], Some(known)) => vec![known],
                (None, [], None) => return Err(unknown(path)),
                (None, ..) => guesses.clone(),
            };
            let mut found = Vec::new();
            let mut source = source;
            for &format in &formats {
                let (own, back) = files.read(source, format, reading);
                found.extend(own);
                source = back;
                found.extend(left_out(&source, format, &formats, &guesses));
            }
            let numbers = formats.iter().flat_map(|format| (format.numbers)(&source)).collect();
            found.extend(again(&source, &numbers, &files.earlier));
            found.extend(files.note_mark(&source));
            findings.extend(found, std::slice::from_ref(&source));
            files.earlier.push((source, numbers));
        }
    }
    let names: Vec<String> = paths.iter().map(|path| path.display().to_string()).collect();
    let names = names.join(", ");
    if findings.has_errors() {
        return Ok(None);
    }
    let tool_mm = files.earlier.iter().find_map(|(source, _)| tool_of(source.bytes()));
    let formats: Vec<_> = files.sets.iter().filter(|(_, set)| !set.is_empty()).map(|(format, _)| *format).collect();
    let mut tables = joined(files.sets, &names, reading, findings);
    if tables.is_empty() && !findings.has_errors() {
        return Err(Error::usage(format!("{names} has no compensation table in use")));
    }
    tables.multiplication = Multiplication::Instead;
    if tables.lookups.iter().any(|one| one.factor.is_some()) {
        tables.multiplication = multiplication(&names, reading.multiplication, files.mark, findings);
    }
    Ok((!findings.has_errors()).then_some(ReadTables { tables, formats, tool_mm }))
}

/// The tables of all formats together, if the control uses several formats.
fn joined(
    sets: Vec<(&'static Format, Tables)>,
    names: &str,
    reading: &TableReading<'_>,
    findings: &mut Diagnostics,
) -> Tables {
    let mut all = Tables::default();
    let mut fault = |message: String, help: &str| {
        findings.add(Diagnostic::nowhere(Code::BAD_TABLES, format!("{names}: {message}"), help), &[]);
    };
    for (format, tables) in sets {
        // Values that the control would refuse are errors. Empty cells of a file are allowed.
        let mut whole = tables.clone();
        whole.multiplication = Multiplication::Instead;
        (format.round)(&mut whole);
        for message in format.faults_of(&whole, reading.wiring) {
            fault(
                message,
                "check that the file is complete and of this control; --format reads it as that of another control",
            );
        }
        if !all.add(tables) {
            let message = format!("the tables of {} and others describe the same errors", format.title);
            fault(message, "name the files of one control only");
        }
    }
    let lacks = |axis: &Axis| reading.machine.is_some_and(|machine| machine.axis(*axis).is_none());
    for axis in AXES.into_iter().filter(lacks).filter(|&axis| all.names(axis)) {
        let help = "remove the table, or state which axis it is: axis_order in the machine file, --axis-name";
        fault(format!("a table is for axis {axis}, which the machine does not have"), help);
    }
    all
}

/// The warning for axes whose numbers at the control are not stated; `axes` lists them.
pub(crate) fn numbers_assumed(axes: &str) -> Diagnostic {
    let message = format!(
        "the numbers of the axes at the control are not stated; ncfix assumes {axes}; a spindle with a number of its own shifts those after it"
    );
    let help = "compare them with the machine axes of the control (MD10000), and state them: axis_order = [\"X\", \"Y\", \"Z\", \"-\", \"A\", \"C\"] in [machine], \"-\" for the spindle; or --axis-name A=AX5";
    Diagnostic::nowhere(Code::AXIS_NUMBERS_ASSUMED, message, help)
}

/// The warning for products if it is not stated which ones the control forms.
pub(crate) fn products_assumed(names: &str) -> Diagnostic {
    let message = format!(
        "{names}: it is not stated whether the control adds the product of two tables, or product plus value; ncfix assumes the product alone"
    );
    let help = "state what the control does: --multiplication, or table_multiplication in the machine file";
    Diagnostic::nowhere(Code::PRODUCTS_ASSUMED, message, help)
}

/// The value of a table that is multiplied by another one: as requested, or as stated in the files, or the default.
fn multiplication(
    names: &str,
    asked: Option<Multiplication>,
    mark: Option<Multiplication>,
    findings: &mut Diagnostics,
) -> Multiplication {
    match (asked, mark) {
        (Some(asked), Some(mark)) if asked != mark => {
            let message =
                format!("{names}: its products are written for a control with the other table_multiplication");
            let help = "make the file again with the --multiplication of the control, or correct table_multiplication";
            findings.add(Diagnostic::nowhere(Code::UNUSED_TABLE, message, help), &[]);
        }
        (None, None) => {
            findings.add(products_assumed(names), &[]);
        }
        _ => {}
    }
    asked.or(mark).unwrap_or_default()
}

/// Tables of the file that are not in the requested format.
fn left_out(
    source: &Source,
    format: &'static Format,
    formats: &[&'static Format],
    guesses: &[&'static Format],
) -> Vec<Diagnostic> {
    let is_read = |other: &Format| formats.iter().any(|one| one.name == other.name);
    let others = guesses.iter().filter(|other| format.beside.contains(&other.name) && !is_read(other));
    let told = others.map(|other| {
        let message = format!("the file also has tables of {}, which are ignored", other.title);
        let place = Place { file: source.id(), span: Span::new(0, 1) };
        Diagnostic::at(Code::UNUSED_TABLE, place, message, "remove --format to read all of them")
    });
    told.collect()
}

/// The text before and after the tool in a remark.
const TOOL: [&str; 2] = ["tool ", " mm from the gauge point"];
/// Number of lines that may contain such a remark.
const REMARKS: usize = 40;

/// The remark with the tool of the tables.
pub(crate) fn tool_remark(tool_mm: &Vector) -> String {
    let [x, y, z] = rounded_mm(tool_mm);
    format!("{}{x} {y} {z}{}", TOOL[0], TOOL[1])
}

/// The tool in such a remark.
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

/// A duplicate file, or one with a table of an earlier file: in the control the later one replaces the earlier one.
fn again(source: &Source, numbers: &BTreeSet<usize>, earlier: &[(Source, BTreeSet<usize>)]) -> Option<Diagnostic> {
    let fault = |message: String, help: &str| {
        Some(Diagnostic::at(Code::BAD_TABLES, Place { file: source.id(), span: Span::new(0, 1) }, message, help))
    };
    for (other, known) in earlier {
        if other.bytes() == source.bytes() {
            let message = format!("this is {} again", other.name());
            return fault(message, "give each file only once");
        }
        if let Some(number) = numbers.intersection(known).next() {
            let message = format!("table {number} is also in {}", other.name());
            return fault(
                message,
                "give the files that are now in the control: the later file replaces a table of an earlier one",
            );
        }
    }
    None
}

/// A second table for the same axes, in a format without table numbers.
fn second(source: &Source, new: &[(Axis, Axis, Sense)], known: &[(Axis, Axis, Sense)]) -> Option<Diagnostic> {
    let (input, output, _) = new.iter().find(|one| known.contains(one))?;
    let place = Place { file: source.id(), span: Span::new(0, 1) };
    let message = format!("a second table of {output} over {input}");
    Some(Diagnostic::at(Code::BAD_TABLES, place, message, "give the files that are now in the control"))
}

/// The control with the tables that a machine file names as active, and the files; `None` if there are errors.
///
/// # Errors
/// If a file cannot be read, or its format cannot be detected.
pub(crate) fn active(
    paths: &[PathBuf],
    machine: &Machine,
    findings: &mut Diagnostics,
) -> Result<Option<(Control, Vec<Source>)>, Error> {
    let wiring = Wiring::of(machine);
    let multiplication = machine.active_tables.multiplication.map(Multiplication::from);
    let reading = TableReading { format: None, multiplication, machine: Some(machine), wiring: &wiring };
    let read = read(paths, &reading, findings)?;
    let mut sources = Vec::new();
    for path in paths {
        sources.extend(members(path)?.0);
    }
    Ok(read.map(|read| (Control::new(machine, &read.tables), sources)))
}

/// The files with tables at a path: the file itself, or those in an archive; and programs of the archive with such variables.
fn members(path: &Path) -> Result<(Vec<Source>, Vec<Source>), Error> {
    const PROGRAMS: [&str; 3] = [".MPF", ".SPF", ".CPF"];
    let source = files::read(path, FileId(0), "compensation tables")?;
    let Some(files) = archive::members(path, source.bytes())? else { return Ok((vec![source], Vec::new())) };
    // Only formats with named variables can be distinguished from other saved data of a control.
    let is_table =
        |file: &Source| format::guess(file.name(), file.bytes()).is_some_and(|format| !format.beside.is_empty());
    let is_program = |file: &Source| {
        let name = file.name().to_ascii_uppercase();
        PROGRAMS.iter().any(|ending| name.ends_with(ending))
    };
    Ok(files.into_iter().filter(is_table).partition(|file| !is_program(file)))
}

/// The diagnostic for a program that sets tables when it runs: an archive does not show whether it ran.
fn not_read(program: &Source) -> Diagnostic {
    let place = Place { file: program.id(), span: Span::new(0, 1) };
    let help = "save the tables of the control as they are now, NC active data, if it ran";
    Diagnostic::at(Code::UNUSED_TABLE, place, "a program with table variables, which is not read", help)
}

fn unknown(path: &Path) -> Error {
    let names: Vec<&str> = FORMATS.iter().map(|format| format.name).collect();
    Error::usage(format!("the format of {} is not recognized; give --format: {}", path.display(), names.join(", ")))
}
