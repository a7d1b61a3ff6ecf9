//! The flat stream of a program, as an iterator and as a text.

use std::cell::RefCell;
use std::fmt;
use std::io::{self, Write};
use std::path::PathBuf;

use crate::diagnostics::Diagnostics;
use crate::disk::stated_machine::{FLAT_HEAD, MARK, from_head};
use crate::error::Error;
use crate::machine::Machine;
use crate::program::Program;
use crate::run::{self, Running, Watch};
use ncfix_base::diagnostic::{Code, Diagnostic, Place};
use ncfix_base::geometry::{Axis, AxisSet, AxisVector, Vector};
use ncfix_base::source::Span;
use ncfix_language::exec::{Options, RapidOrder};
use ncfix_machine::machine::Kinematics;
use ncfix_machine::snc::{self, Element, Kind, TextReader, TextWriter};

/// The elements of a program in their order, from [`Program::moves`](crate::Program::moves): moves, dwells, tool and auxiliary words.
///
/// ```
/// use ncfix::prelude::*;
///
/// let machine = Machine::demo();
/// let program = Program::parse("part.mpf", "G0 X50 Y50 Z100\nG1 X600 F500\nM30\n", DialectChoice::Sinumerik)?;
/// let elements = program.moves(&machine)?.collect::<Result<Vec<Element>, Error>>()?;
/// assert_eq!(elements.iter().filter(|one| matches!(one.kind, Kind::Move(_))).count(), 2);
/// # Ok::<(), ncfix::Error>(())
/// ```
pub struct Elements<'m> {
    running: Running<'m>,
    found: Diagnostics,
}

impl fmt::Debug for Elements<'_> {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        out.debug_struct("Elements").field("found", &self.found).finish_non_exhaustive()
    }
}

impl<'m> Elements<'m> {
    pub(crate) fn new(running: Running<'m>, found: Diagnostics) -> Elements<'m> {
        Elements { running, found }
    }

    /// The diagnostics so far, including warnings.
    ///
    /// ```
    /// use ncfix::prelude::*;
    ///
    /// let machine = Machine::demo();
    /// let program = Program::parse("part.mpf", "G0 X50 Y50 Z100\nG1 X600 F500\nM30\n", DialectChoice::Sinumerik)?;
    /// let mut elements = program.moves(&machine)?;
    /// assert!(elements.by_ref().all(|one| one.is_ok()));
    /// assert!(!elements.diagnostics().has_errors());
    /// # Ok::<(), ncfix::Error>(())
    /// ```
    #[must_use]
    pub fn diagnostics(&self) -> &Diagnostics {
        &self.found
    }

    /// The lines that called the program of an element, innermost first.
    ///
    /// ```
    /// use ncfix::prelude::*;
    ///
    /// let machine = Machine::demo();
    /// let program = Program::parse("part.mpf", "G0 X50 Y50 Z100\nG1 X600 F500\nM30\n", DialectChoice::Sinumerik)?;
    /// let mut elements = program.moves(&machine)?;
    /// let first = elements.next().unwrap()?;
    /// assert!(elements.call_lines(&first).is_empty(), "no subprogram is called");
    /// # Ok::<(), ncfix::Error>(())
    /// ```
    #[must_use]
    pub fn call_lines(&self, element: &Element) -> Vec<u32> {
        self.running.call_lines(element)
    }
}

impl Iterator for Elements<'_> {
    type Item = Result<Element, Error>;

    /// The next element. After an error the program continues, so that one run reports all errors.
    fn next(&mut self) -> Option<Self::Item> {
        loop {
            match self.running.next()? {
                Ok(element) => return Some(Ok(element)),
                Err(found) => {
                    let is_error = found.is_error();
                    let mut one = Diagnostics::default();
                    one.add(found, self.running.sources());
                    self.found.absorb(one.clone());
                    if is_error {
                        return Some(Err(Error::found(one)));
                    }
                }
            }
        }
    }
}

impl Program {
    /// Writes the flat stream in its text form, SNC: each line as soon as it is known.
    ///
    /// ```
    /// use ncfix::prelude::*;
    ///
    /// let machine = Machine::demo();
    /// let program = Program::parse("part.mpf", "G0 X50 Y50 Z100\nG1 X600 F500\nM30\n", DialectChoice::Sinumerik)?;
    /// let mut text = Vec::new();
    /// program.write_moves(&machine, &mut text)?;
    /// assert!(String::from_utf8(text).unwrap().contains("G1 X600 Y50 Z100 F500 ;@2"));
    /// # Ok::<(), ncfix::Error>(())
    /// ```
    ///
    /// # Errors
    /// If the program cannot be parsed or cannot be executed to its end, or `out` refuses the text.
    pub fn write_moves(&self, machine: &Machine, out: &mut dyn Write) -> Result<(), Error> {
        let mut found = Diagnostics::default();
        if let Some(flat) = FlatText::of(self, machine, None, &mut found)?.filter(|_| !found.has_errors()) {
            flat.write(out, &mut found).map_err(|error| Error::sink(&error))?;
        }
        if found.has_errors() { Err(Error::found(found)) } else { Ok(()) }
    }
}

/// A program that is about to be written as a flat stream.
pub(crate) struct FlatText<'a> {
    program: &'a Program,
    machine: &'a Machine,
    running: Running<'a>,
}

impl<'a> FlatText<'a> {
    /// Parses the program; `None` if there are errors.
    ///
    /// # Errors
    /// If the dialect does not exist.
    pub(crate) fn of(
        program: &'a Program,
        machine: &'a Machine,
        watch: Option<fn() -> Box<dyn Watch>>,
        found: &mut Diagnostics,
    ) -> Result<Option<FlatText<'a>>, Error> {
        let Some(opened) = program.open(Some(machine), found)? else { return Ok(None) };
        let options = Options { rapid_order: RapidOrder::All, tells_assumed: true, ..Options::default() };
        let mut running = program.start_as(opened, &machine.machine, options);
        if let Some(watch) = watch {
            running = running.watched(watch());
        }
        Ok(Some(FlatText { program, machine, running }))
    }

    /// Writes the elements up to the first error and collects all diagnostics; returns the files of the subprograms
    /// that were read.
    ///
    /// # Errors
    /// The errors of `out`.
    pub(crate) fn write(self, out: impl Write, found: &mut Diagnostics) -> io::Result<Vec<PathBuf>> {
        let FlatText { program, machine: Machine { machine, .. }, mut running } = self;
        let turned = |command: &AxisVector, tool_mm: &Vector| machine.turned_tool_mm(command, tool_mm);
        let kinematics = RefCell::new(Kinematics::new(machine));
        let mut writer = TextWriter::new(out, &machine.name, machine.axis_set(), turned)?
            .with_workpiece(|command, tool_mm| kinematics.borrow().on_workpiece(command, tool_mm));
        if let Some(start) = program.reading().start {
            writer.start_at(start);
        }
        while let Some(item) = running.next() {
            if let Ok(Element { kind: Kind::Setup(setup), .. }) = &item {
                kinematics.borrow_mut().set_head(machine, setup.head);
            }
            match item {
                // A stream with a gap would be read as another program: it ends before the first error, and the rest is only executed.
                Ok(_) if found.has_errors() => {}
                Ok(element) if element.origin.calls == 0 => writer.write(&element, &[])?,
                Ok(element) => writer.write(&element, &running.call_lines(&element))?,
                Err(diagnostic) => {
                    found.add(diagnostic, running.sources());
                    if found.is_hopeless() {
                        break;
                    }
                }
            }
        }
        writer.finish()?;
        if !running.moves() && !found.has_errors() {
            found.add(run::without_motion(program.source(), Code::MOVES_NOTHING), running.sources());
        }
        Ok(running.files())
    }
}

/// Reads a flat stream in its text form and writes it again; `None` if there are errors.
pub(crate) fn written_again(program: &Program, machine: &Machine, found: &mut Diagnostics) -> Option<Vec<u8>> {
    let (source, machine) = (program.source(), &machine.machine);
    let text = String::from_utf8_lossy(source.bytes());
    if let Some(finding) = of_other_machine(program, &machine.name) {
        found.add(finding, std::slice::from_ref(source));
        return None;
    }
    let mut report = |line: usize, message: String| {
        let start = text.split_inclusive('\n').take(line - 1).map(str::len).sum();
        let place = Place { file: source.id(), span: Span::new(start, start + 1) };
        let help = "correct the line, or print the stream again from its program";
        found.add(Diagnostic::at(Code::UNEXPECTED, place, message, help), std::slice::from_ref(source));
    };
    for (line, words) in text.lines().enumerate() {
        if let Some(message) = wrong_axes(words, machine.axis_set()) {
            report(line + 1, message);
        }
    }
    let mut reader = TextReader::new(text.strip_prefix(MARK).unwrap_or(&text));
    // Positions are those of the tip already, so there is no tool to add. Nothing refuses bytes in memory.
    let mut writer = TextWriter::new(Vec::new(), &machine.name, machine.axis_set(), |_, tool| *tool).ok()?;
    while let Some(item) = reader.next() {
        match item {
            Ok(element) => {
                let lines = reader.call_lines().to_vec();
                writer.write(&element, &lines).ok()?;
            }
            Err(fault) => report(fault.line, fault.message),
        }
    }
    if found.has_errors() { None } else { writer.finish().ok() }
}

/// The refusal of a flat stream that is not one of this machine.
fn of_other_machine(program: &Program, machine: &str) -> Option<Diagnostic> {
    let bytes = program.bytes();
    let start = bytes.len() - from_head(bytes).len();
    let place = Place { file: program.source().id(), span: Span::new(start, start + FLAT_HEAD.len()) };
    let Some(stated) = snc::stated_machine(from_head(bytes)) else {
        let message = "the head line of this flat stream names no machine, or another unit";
        let help = format!("write it as ncfix snc does: ; snc 1 machine={machine} units=mm");
        return Some(Diagnostic::at(Code::UNEXPECTED, place, message, help));
    };
    let message = format!(
        "this flat stream is for the machine {stated}, and the machine file is that of {machine}: its positions hold for one machine only"
    );
    let help = format!("name the machine file of {stated} with --machine, or print the stream again from its program");
    (stated != machine).then(|| Diagnostic::at(Code::STATED_MACHINE_MISSING, place, message, help))
}

/// The fault of a moving line that lacks an axis of the machine, or has another one.
fn wrong_axes(line: &str, own: AxisSet) -> Option<String> {
    let mut words = line.split(';').next()?.split_ascii_whitespace();
    let is_move = matches!(words.next()?.as_bytes(), [b'G', b'0'..=b'3'] | [b'G', b'0'..=b'3', b'.', ..]);
    let axes: AxisSet = words.filter_map(|word| Axis::from_letter(*word.as_bytes().first()?)).collect();
    let names = |axes: AxisSet| axes.iter().map(|axis| axis.to_string()).collect::<Vec<_>>().join(", ");
    let (other, lacking) = (axes.difference(own), own.difference(axes));
    if !is_move || other.is_empty() && lacking.is_empty() {
        return None;
    }
    if !other.is_empty() {
        return Some(format!("the machine has no axis {}", names(other)));
    }
    Some(format!("the position of {} is missing: a move names every axis of the machine", names(lacking)))
}
