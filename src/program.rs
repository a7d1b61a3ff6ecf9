//! Part programs: reading, checks, correction, comparison.

use std::path::Path;

use crate::correction::{Correction, corrected_before};
use crate::diagnostics::Diagnostics;
use crate::disk::stated_machine::MachineSearch;
use crate::error::Error;
use crate::machine::Machine;
use crate::moves::Elements;
use crate::options::{DialectChoice, Options, ProgramReading};
use crate::registry::Registry;
use crate::run::{self, Opened, Running, Subprograms};
use ncfix_base::diagnostic::{Code, Diagnostic};
use ncfix_base::geometry::AxisVector;
use ncfix_base::source::{FileId, Source};
use ncfix_language::exec;

/// The text of a part program and the options for reading it. It is parsed again for every run, so that memory is
/// bounded by the text.
///
/// ```
/// use ncfix::prelude::*;
///
/// let machine = Machine::demo();
/// let program = Program::parse("part.mpf", "G0 X50 Y50 Z100\nG1 X900 F500\nM30\n", DialectChoice::Sinumerik)?;
/// let found = program.check(&machine);
/// let first = found.iter().next().unwrap();
/// assert_eq!((first.line(), first.column()), (Some(2), Some(1)));
/// assert!(first.message().contains("limit of 700 mm"), "{first}");
/// # Ok::<(), ncfix::Error>(())
/// ```
#[derive(Clone, Debug)]
pub struct Program {
    source: Source,
    reading: ProgramReading,
    subprograms: Subprograms,
}

impl Program {
    /// A program from memory, in the given language or a detected one. It has only its own subprograms: no file is read.
    ///
    /// ```
    /// use ncfix::prelude::*;
    ///
    /// let program = Program::parse("part.ngc", "G21 G0 X10\nM2\n", DialectChoice::Guess)?;
    /// assert_eq!(program.name(), "part.ngc");
    /// # Ok::<(), ncfix::Error>(())
    /// ```
    ///
    /// # Errors
    /// If the text cannot be parsed; all diagnostics are in the error.
    pub fn parse(name: &str, text: impl Into<Vec<u8>>, dialect: DialectChoice) -> Result<Program, Error> {
        let too_large = |_| Error::usage(format!("{name} is too large"));
        let source = Source::new(FileId(0), name, text.into()).map_err(too_large)?;
        Program { source, reading: ProgramReading::default(), subprograms: Subprograms::None }.parsed(dialect)
    }

    /// A program from a file, or from an archive of a control (`SAVE.arc/PART.MPF`); `-` is standard input. When it
    /// runs, subprograms are read from the folder of the program and those of the machine file.
    ///
    /// ```
    /// use ncfix::prelude::*;
    ///
    /// let program = Program::from_file("samples/programs/sinumerik/cover.mpf", DialectChoice::Guess)?;
    /// assert!(program.moves(&Machine::demo())?.count() > 1);
    /// # Ok::<(), ncfix::Error>(())
    /// ```
    ///
    /// # Errors
    /// If the file cannot be read or its text cannot be parsed.
    pub fn from_file(path: impl AsRef<Path>, dialect: DialectChoice) -> Result<Program, Error> {
        let path = path.as_ref();
        Program::new(run::read(path)?, path, ProgramReading::default()).parsed(dialect)
    }

    /// As [`Program::parse`], with the detectors of a registry. If a detector that was added decides, its dialect is that of the program on any machine.
    ///
    /// ```
    /// use ncfix::extend::dialect::{Detector, find};
    /// use ncfix::prelude::*;
    ///
    /// let own = Detector::new("our post", find("rs274").unwrap(), &["tap"], r"^\(OUR POST \d+\)$")?;
    /// let registry = Registry::default().with_detector(own);
    /// let text = "O1 sub\nO1 endsub\nM2\n";
    /// assert!(Program::parse_with("part.tap", text, DialectChoice::Guess, &registry).is_ok());
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// If the text cannot be parsed; all diagnostics are in the error.
    pub fn parse_with(
        name: &str,
        text: impl Into<Vec<u8>>,
        dialect: DialectChoice,
        registry: &Registry,
    ) -> Result<Program, Error> {
        let text = text.into();
        let dialect = detected(name, &text, dialect, registry);
        Program::parse(name, text, dialect)
    }

    /// As [`Program::from_file`], with the detectors of a registry, like [`Program::parse_with`].
    ///
    /// ```
    /// use ncfix::prelude::*;
    ///
    /// let cover = "samples/programs/sinumerik/cover.mpf";
    /// let program = Program::from_file_with(cover, DialectChoice::Guess, &Registry::default())?;
    /// assert!(program.moves(&Machine::demo())?.count() > 1);
    /// # Ok::<(), ncfix::Error>(())
    /// ```
    ///
    /// # Errors
    /// If the file cannot be read or its text cannot be parsed.
    pub fn from_file_with(
        path: impl AsRef<Path>,
        dialect: DialectChoice,
        registry: &Registry,
    ) -> Result<Program, Error> {
        let path = path.as_ref();
        let source = run::read(path)?;
        let dialect = detected(source.name(), source.bytes(), dialect, registry);
        Program::new(source, path, ProgramReading::default()).parsed(dialect)
    }

    /// A program that was read from a file.
    pub(crate) fn new(source: Source, path: &Path, reading: ProgramReading) -> Program {
        Program { source, reading, subprograms: Subprograms::of(path) }
    }

    /// The program, if it can be parsed.
    fn parsed(mut self, dialect: DialectChoice) -> Result<Program, Error> {
        self.reading.dialect = dialect.name().map(str::to_owned);
        let mut found = Diagnostics::default();
        let opened = self.open(None, &mut found)?;
        if opened.is_some() { Ok(self) } else { Err(Error::found(found)) }
    }

    /// Sets the axis positions before the first block, in machine coordinates, mm and rad: for programs that begin with an incremental move or an
    /// arc.
    ///
    /// ```
    /// use ncfix::prelude::*;
    ///
    /// let machine = Machine::demo();
    /// let program = Program::parse("part.mpf", "G91 G1 X5 F500\nM30\n", DialectChoice::Sinumerik)?;
    /// assert!(program.correct(&machine, &Options::default()).report().is_err(), "the position of X is unknown");
    /// let program = program.starting_at("X10,Y20,Z30".parse()?);
    /// program.correct(&machine, &Options::default()).report()?;
    /// # Ok::<(), ncfix::Error>(())
    /// ```
    #[must_use]
    pub fn starting_at(mut self, start: AxisVector) -> Program {
        self.reading.start = Some(start);
        self
    }

    /// Skips `/` blocks of these levels, 0 to 9, as the switches of the control do; other levels are ignored.
    ///
    /// ```
    /// use ncfix::prelude::*;
    ///
    /// let machine = Machine::demo();
    /// let program = Program::parse("part.mpf", "G0 X1\n/G0 X2\nM30\n", DialectChoice::Sinumerik)?;
    /// let moves = |program: &Program| program.moves(&machine).map(|moves| moves.filter(|one| one.is_ok()).count());
    /// assert_eq!(moves(&program.clone().skipping(&[0]))?, moves(&program)? - 1);
    /// # Ok::<(), ncfix::Error>(())
    /// ```
    #[must_use]
    pub fn skipping(mut self, levels: &[usize]) -> Program {
        levels.iter().for_each(|&level| self.reading.skip.iter_mut().skip(level).take(1).for_each(|skip| *skip = true));
        self
    }

    /// Stops a program that executes more blocks than this. The default limit is the larger of two million and twenty times the number of blocks.
    ///
    /// ```
    /// use ncfix::prelude::*;
    ///
    /// let machine = Machine::demo();
    /// let endless = Program::parse("part.mpf", "AGAIN:\nG0 X1\nGOTOB AGAIN\n", DialectChoice::Sinumerik)?;
    /// assert!(endless.stopping_after(1000).check(&machine).has_errors());
    /// # Ok::<(), ncfix::Error>(())
    /// ```
    #[must_use]
    pub fn stopping_after(mut self, blocks: u64) -> Program {
        self.reading.max_blocks = Some(blocks);
        self
    }

    /// Its name, as diagnostics show it.
    ///
    /// ```
    /// # use ncfix::prelude::*;
    /// assert_eq!(Program::parse("part.ngc", "G0 X1", DialectChoice::Rs274)?.name(), "part.ngc");
    /// # Ok::<(), ncfix::Error>(())
    /// ```
    #[must_use]
    pub fn name(&self) -> &str {
        self.source.name()
    }

    /// Its text.
    ///
    /// ```
    /// # use ncfix::prelude::*;
    /// assert_eq!(Program::parse("part.ngc", "G0 X1", DialectChoice::Rs274)?.bytes(), b"G0 X1");
    /// # Ok::<(), ncfix::Error>(())
    /// ```
    #[must_use]
    pub fn bytes(&self) -> &[u8] {
        self.source.bytes()
    }

    /// The correction of the program for a machine; nothing is executed yet. See [`Correction`].
    ///
    /// ```
    /// use ncfix::prelude::*;
    ///
    /// let machine = Machine::demo();
    /// let program = Program::parse("part.mpf", "G0 X50 Y50 Z100\nG1 X600 F500\nM30\n", DialectChoice::Sinumerik)?;
    /// let report = program.correct(&machine, &Options::default()).report()?;
    /// assert!(report.after.unwrap().max_um < 1.0);
    /// # Ok::<(), ncfix::Error>(())
    /// ```
    #[must_use]
    pub fn correct<'a>(&'a self, machine: &Machine, options: &Options) -> Correction<'a> {
        Correction::new(self, machine, options)
    }

    /// The flat stream of the program: moves, dwells, tool and auxiliary words, without calls, loops, frames or cycles. It is lazy, so a program
    /// with an endless loop is possible.
    ///
    /// ```
    /// use ncfix::prelude::*;
    ///
    /// let machine = Machine::demo();
    /// let program = Program::parse("part.mpf", "G0 X50 Y50 Z100\nG1 X600 F500\nM30\n", DialectChoice::Sinumerik)?;
    /// let mut ends_mm = Vec::new();
    /// for element in program.moves(&machine)? {
    ///     if let Kind::Move(motion) = element?.kind {
    ///         ends_mm.push(motion.target[Axis::X]);
    ///     }
    /// }
    /// assert_eq!(ends_mm, [50.0, 600.0]);
    /// # Ok::<(), ncfix::Error>(())
    /// ```
    ///
    /// # Errors
    /// If the program cannot be parsed; errors during execution are in the stream.
    pub fn moves<'m>(&self, machine: &'m Machine) -> Result<Elements<'m>, Error> {
        let mut found = Diagnostics::default();
        match self.open(Some(machine), &mut found)?.filter(|_| !found.has_errors()) {
            Some(opened) => {
                let options = exec::Options { rapid_order: exec::RapidOrder::All, ..exec::Options::default() };
                Ok(Elements::new(self.start_as(opened, &machine.machine, options), found))
            }
            None => Err(Error::found(found)),
        }
    }

    /// True if the program has a sign of a correction, which is reported as a diagnostic.
    pub(crate) fn was_corrected_before(&self, found: &mut Diagnostics) -> bool {
        let corrected = corrected_before(&self.source);
        let was_corrected = corrected.is_some();
        if let Some(corrected) = corrected {
            found.add(corrected, std::slice::from_ref(&self.source));
        }
        was_corrected
    }

    /// The search for its machine, with the nearest machine file from the folder of `near` upwards.
    pub(crate) fn search<'a>(&'a self, near: &'a Path) -> MachineSearch<'a> {
        MachineSearch { near, made: Some((Path::new(self.source.name()), self.bytes())), changes_heads: true }
    }

    /// The text.
    pub(crate) fn source(&self) -> &Source {
        &self.source
    }

    /// The options for reading it.
    pub(crate) fn reading(&self) -> &ProgramReading {
        &self.reading
    }

    /// The program with another text.
    pub(crate) fn with_source(&self, source: Source) -> Program {
        Program { source, ..self.clone() }
    }

    /// The program with the same subprograms in every run, even if their files change.
    pub(crate) fn keeping_subprograms(mut self) -> Program {
        self.subprograms = self.subprograms.kept();
        self
    }

    /// The program without its own block limit.
    pub(crate) fn without_block_limit(mut self) -> Program {
        self.reading.max_blocks = None;
        self
    }

    /// Parses it; `None` if it has syntax errors, which are among the diagnostics.
    ///
    /// # Errors
    /// If the dialect does not exist.
    pub(crate) fn open(&self, machine: Option<&Machine>, found: &mut Diagnostics) -> Result<Option<Opened>, Error> {
        run::open(&self.source, &self.subprograms, &self.reading, machine, found)
    }

    /// Starts the parsed program.
    pub(crate) fn start_as<'m>(
        &self,
        opened: Opened,
        machine: &'m ncfix_machine::machine::Machine,
        options: exec::Options,
    ) -> Running<'m> {
        Running::start(opened, &self.subprograms, &self.reading, machine, options)
    }
}

/// The dialect if the detectors of a registry recognize another one than the built-in detectors; otherwise the given choice.
fn detected(name: &str, text: &[u8], choice: DialectChoice, registry: &Registry) -> DialectChoice {
    if choice.name().is_some() {
        return choice;
    }
    let found = ncfix_dialect::guess_with(&registry.detectors, name, text).map(|dialect| dialect.name);
    let is_added = found != ncfix_dialect::guess(name, text).map(|dialect| dialect.name);
    found.filter(|_| is_added).and_then(|dialect| dialect.parse().ok()).unwrap_or(choice)
}

/// Refuses to replace a file whose further programs are not in the output.
pub(crate) fn keep_programs(target: &str, findings: &mut Diagnostics) {
    let Some((left, source)) = findings.first_of(Code::MORE_PROGRAMS) else { return };
    let (place, source) = (left.place, source.clone());
    let message = format!("--in-place would remove other programs from {target}: {}", left.message);
    let help = "give -o another file, or put each program into a file of its own";
    let found = match place {
        Some(place) => Diagnostic::at(Code::LOST_PROGRAM, place, message, help),
        None => Diagnostic::nowhere(Code::LOST_PROGRAM, message, help),
    };
    findings.add(found, source.as_slice());
}
