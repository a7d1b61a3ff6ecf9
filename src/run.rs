//! Execution of programs: bytes, dialect, syntax tree, execution.

use std::cell::RefCell;
use std::path::{Path, PathBuf};
use std::rc::Rc;

use crate::assumed_start::each_g;
use crate::diagnostics::{Diagnostics, Hint};
use crate::disk::archive;
pub(crate) use crate::disk::archive::holds as is_in_archive;
use crate::disk::files::{self, STANDARD_INPUT, is_standard_stream};
use crate::disk::folder_library::FolderLibrary;
use crate::disk::kept_library::{KeptAnswers, KeptLibrary};
use crate::disk::machine_file::dialect_names;
use crate::error::Error;
use crate::machine::Machine;
use crate::options::ProgramReading;
use crate::recognition;
use ncfix_base::diagnostic::{Code, Diagnostic, Place};
use ncfix_base::source::{FileId, Source, Span};
use ncfix_dialect::{Dialect, Language};
use ncfix_language::exec::{Execution, Library, NoLibrary, Options, Radius, RapidOrder};
use ncfix_language::syntax::sinumerik::Macros;
use ncfix_language::syntax::{self, Program};
use ncfix_machine::machine::file::nearest;
use ncfix_machine::machine::{Kinematics, TipPath};
use ncfix_machine::snc::extent::PathExtent;
use ncfix_machine::snc::{Element, Kind, Turning};
use ncfix_path::emit;

/// Blocks executed in search of further diagnostics in a program with syntax errors.
const BLOCKS_IN_SEARCH: u64 = 100_000;

/// A program that was parsed.
pub(crate) struct Opened {
    /// Its bytes.
    pub(crate) source: Source,
    /// Its syntax tree.
    pub(crate) program: Program,
    /// Its dialect.
    pub(crate) dialect: &'static Dialect,
}

/// Parses the program in `source`; `None` if it has syntax errors, which are among the diagnostics.
///
/// # Errors
/// If the dialect does not exist.
pub(crate) fn open(
    source: &Source,
    subprograms: &Subprograms,
    choice: &ProgramReading,
    chosen: Option<&Machine>,
    findings: &mut Diagnostics,
) -> Result<Option<Opened>, Error> {
    let (dialect, why) = resolve(choice.dialect.as_deref(), chosen, source)?;
    log::info!("dialect of {}: {}, {why}", source.name(), dialect.name);
    if !dialect.is_executable {
        findings.add(
            Diagnostic::nowhere(
                Code::NOT_SUPPORTED,
                format!("programs in the dialect '{}' ({}) are not supported yet", dialect.name, dialect.title),
                "if the program is in another dialect, give it with --dialect",
            ),
            &[],
        );
        return Ok(None);
    }
    if let Some(found) = recognition::refusal(source, dialect, chosen) {
        findings.add(found, std::slice::from_ref(source));
        return Ok(None);
    }
    if let Some(other) = ncfix_dialect::guess(source.name(), source.bytes()).filter(|other| other.name != dialect.name)
    {
        // Nothing is reported if the program can be parsed nevertheless.
        let help = format!(
            "the file reads like {}: try --dialect {} and a machine file with this controller",
            other.title, other.name
        );
        let sentence = format!(
            "{} reads like {} and was read as {} ({why}): try --dialect {} and a machine file with this controller",
            source.name(),
            other.title,
            dialect.title,
            other.name
        );
        findings.hint(source, Hint { help, sentence: choice.dialect.is_none().then_some(sentence) });
    }
    let search_path = chosen.map_or(&[][..], |chosen| &chosen.machine.control.search_path);
    let (mut library, _) = library_of(&subprograms.beside(source), search_path);
    let mut macros = Macros::default();
    library.definitions().iter().for_each(|(_, bytes)| macros.read(bytes));
    let (program, found) = syntax::parse_with(source, dialect, &macros);
    let is_understood = !found.iter().any(Diagnostic::is_error);
    findings.extend(found, std::slice::from_ref(source));
    if let (false, Some(chosen)) = (is_understood, chosen) {
        // Unsupported functions should be reported in the same run; other diagnostics may only be consequences of the blocks with errors.
        let options = Options { max_blocks: Some(BLOCKS_IN_SEARCH), ..Options::default() };
        let execution = Execution::new(program, &chosen.machine, Box::new(NoLibrary), options);
        let unsupported = execution.filter_map(Result::err).filter(|found| found.code == Code::NOT_SUPPORTED);
        let more: Vec<Diagnostic> = unsupported.collect();
        findings.extend(more, std::slice::from_ref(source));
        return Ok(None);
    }
    Ok(is_understood.then(|| Opened { source: source.clone(), program, dialect }))
}

/// The source of the subprograms of a program.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum Subprograms {
    /// None: the program is alone.
    None,
    /// From the disk: the folders of the program in this file, if it is in one, and those of the machine file.
    Disk(Option<PathBuf>),
    /// From the disk, and in every later run as they were in the first one.
    Kept(Option<PathBuf>, KeptAnswers),
}

impl Subprograms {
    /// The subprograms of a program in a file or, for `-`, from standard input.
    pub(crate) fn of(path: &Path) -> Subprograms {
        Subprograms::Disk((!is_standard_stream(path)).then(|| path.to_path_buf()))
    }

    /// The subprograms of the text itself, by its name: a program in an archive has the definitions of the archive.
    fn beside(&self, source: &Source) -> Subprograms {
        let path = || (source.name() != STANDARD_INPUT).then(|| source.name().into());
        match self {
            Subprograms::None => Subprograms::None,
            Subprograms::Disk(_) => Subprograms::Disk(path()),
            Subprograms::Kept(_, answers) => Subprograms::Kept(path(), answers.clone()),
        }
    }

    /// Subprograms that stay as the first run reads them.
    pub(crate) fn kept(self) -> Subprograms {
        match self {
            Subprograms::Disk(path) => Subprograms::Kept(path, KeptAnswers::default()),
            other => other,
        }
    }
}

/// The library of a program, and the files that it has read.
fn library_of(subprograms: &Subprograms, search_path: &[String]) -> (Box<dyn Library>, Rc<RefCell<Vec<PathBuf>>>) {
    let program = match subprograms {
        Subprograms::None => return (Box::new(NoLibrary), Rc::default()),
        Subprograms::Disk(program) => program,
        Subprograms::Kept(program, answers) => {
            let (inner, loaded) = library_of(&Subprograms::Disk(program.clone()), search_path);
            return (Box::new(KeptLibrary::new(inner, answers.clone())), loaded);
        }
    };
    if let Some(archive) = program.as_deref().and_then(|path| archive::open(path).ok().flatten()) {
        let loaded = Rc::new(RefCell::new(vec![archive.path().to_path_buf()]));
        return (Box::new(archive), loaded);
    }
    let (library, loaded) = FolderLibrary::beside(program.as_deref(), search_path);
    (Box::new(library), loaded)
}

/// The dialect: the option, then the machine file, then file name and content. The demo machine was not chosen by the user, so its dialect is the
/// last resort. The second value is the reason for the choice.
pub(crate) fn resolve(
    name: Option<&str>,
    chosen: Option<&Machine>,
    source: &Source,
) -> Result<(&'static Dialect, String), Error> {
    if let Some(name) = name {
        let found = ncfix_dialect::find(name).map(|dialect| (dialect, "--dialect".to_owned()));
        return found.ok_or_else(|| {
            let guess = nearest(name, ncfix_dialect::DIALECTS.iter().map(|dialect| dialect.name));
            let guess = guess.map_or_else(String::new, |near| format!("; did you mean --dialect {near}?"));
            Error::usage(format!("unknown dialect '{name}'; --dialect allows {}{guess}", dialect_names()))
        });
    }
    let of_machine = chosen.filter(|chosen| !chosen.is_demo).and_then(|chosen| {
        Some((ncfix_dialect::find(&chosen.machine.controller)?, "the controller of the machine file".to_owned()))
    });
    let of_file = || {
        let found = ncfix_dialect::guess(source.name(), source.bytes())?;
        Some((found, "by its name or first lines".to_owned()))
    };
    let of_words = || {
        let found = ncfix_dialect::likeness(source.bytes())?;
        let reasons = found.reasons.iter().map(|(what, line)| format!("{what} (line {line})"));
        Some((found.dialect, format!("by its words: {}", reasons.collect::<Vec<_>>().join(", "))))
    };
    let of_rest = || {
        let (dialect, missing) = ncfix_dialect::elimination(source.bytes())?;
        Some((dialect, format!("as {} does not have {missing}", ncfix_dialect::sinumerik().title)))
    };
    let of_name = || Some((ncfix_dialect::usual_of_name(source.name())?, "by its name".to_owned()));
    let by_default = || (ncfix_dialect::sinumerik(), "by default".to_owned());
    Ok(of_machine.or_else(of_file).or_else(of_words).or_else(of_rest).or_else(of_name).unwrap_or_else(by_default))
}

/// The output keeps the unit of the program: on these controls G20 or G21 remains active after the program, and a Fanuc interprets its offsets in
/// that unit. With `is_sent`, line by line, only a Fanuc keeps it.
pub(crate) fn keep_unit(
    source: &Source,
    dialect: &Dialect,
    is_sent: bool,
    machine: &mut ncfix_machine::machine::Machine,
) {
    if !matches!(dialect.language, Language::Fanuc | Language::Rs274) || is_sent && dialect.language == Language::Rs274
    {
        return;
    }
    let control = &mut machine.control;
    control.has_inch_grid = dialect.language == Language::Fanuc;
    control.output_inch = last_unit(source.bytes()).or_else(|| last_unit(control.iso.startup_code.as_bytes()));
}

/// True if the numbers of a program are inches.
pub(crate) fn is_inch(source: &Source, dialect: &Dialect) -> bool {
    matches!(dialect.language, Language::Fanuc | Language::Rs274) && last_unit(source.bytes()) == Some(true)
}

/// True if the last G20 or G21 outside of comments is G20.
fn last_unit(bytes: &[u8]) -> Option<bool> {
    let mut found = None;
    each_g(bytes, |code, _| match code {
        20 => found = Some(true),
        21 => found = Some(false),
        _ => {}
    });
    found
}

/// Reads the bytes of a program.
///
/// # Errors
/// If the file cannot be read.
pub(crate) fn read(path: &Path) -> Result<Source, Error> {
    if let Some(archive) = archive::open(path)? {
        log::info!("read {}: program in an archive of the control", path.display());
        return archive.main();
    }
    files::read(path, FileId(0), "program")
}

/// Receives the progress of a program while it runs.
pub(crate) trait Watch {
    /// Called after `blocks` blocks; the current block starts at byte `offset` of the `length` bytes of the main program, or is in a subprogram if
    /// there is no offset.
    fn note(&mut self, blocks: u64, offset: Option<u32>, length: usize);
    /// The program has ended.
    fn end(&mut self);
}

/// Largest distance of the tip from its path between positions whose range is taken, mm: measured ranges have no finer ends.
const EXTENT_MM: f64 = 0.01;

/// A running program: its elements and diagnostics.
pub(crate) struct Running<'a> {
    execution: Execution<'a>,
    watch: Option<Box<dyn Watch>>,
    loaded: Rc<RefCell<Vec<PathBuf>>>,
    length: usize,
    /// End of the guard of the program, bytes.
    guard_end: usize,
    /// True if it was reported that a value of the control becomes a number.
    has_fixed: bool,
    moves: bool,
    elements: u64,
    extent: PathExtent,
    machine: &'a ncfix_machine::machine::Machine,
    /// Of machines with rotary axes: the axes move along curves while a control keeps the tip on its path.
    kinematics: Option<Kinematics>,
}

impl<'a> Running<'a> {
    /// Starts a program. A program that leaves wear to the control is read with the radius in its registers: none.
    pub(crate) fn start(
        opened: Opened,
        subprograms: &Subprograms,
        choice: &ProgramReading,
        machine: &'a ncfix_machine::machine::Machine,
        options: Options,
    ) -> Running<'a> {
        let (library, loaded) = library_of(subprograms, &machine.control.search_path);
        let is_alone = is_wear_alone(&opened.source) && options.radius == Radius::Whole;
        let options = Options {
            skip_levels: choice.skip,
            max_blocks: choice.max_blocks,
            start: choice.start,
            radius: if is_alone { Radius::Alone(0.0) } else { options.radius },
            ..options
        };
        let (length, guard_end) = (opened.source.bytes().len(), emit::guard_end(opened.source.bytes()));
        let execution = Execution::new(opened.program, machine, library, options);
        let turns = machine.axis_set().iter().any(|axis| axis.is_rotary());
        let changes_at_t = machine.control.tool_change == ncfix_machine::machine::ToolChange::T;
        let (extent, kinematics) = (PathExtent::new(changes_at_t), turns.then(|| Kinematics::new(machine)));
        Running {
            execution,
            watch: None,
            loaded,
            length,
            guard_end,
            has_fixed: false,
            moves: false,
            elements: 0,
            extent,
            machine,
            kinematics,
        }
    }

    /// True for a warning that a value of the control becomes a number if it says nothing new: a guard only compares such values, and one place is enough.
    fn is_known_value(&mut self, item: &Result<Element, Diagnostic>) -> bool {
        let Err(Diagnostic { code: Code::VALUE_FIXED, place, .. }) = item else { return false };
        let is_of_guard =
            place.is_some_and(|place| place.file == FileId(0) && (place.span.start as usize) < self.guard_end);
        is_of_guard || std::mem::replace(&mut self.has_fixed, true)
    }

    /// The run with an observer of its progress.
    pub(crate) fn watched(self, watch: Box<dyn Watch>) -> Self {
        Running { watch: Some(watch), ..self }
    }

    /// The main program and every subprogram read so far, for drawing diagnostics.
    pub(crate) fn sources(&self) -> &[Source] {
        self.execution.sources()
    }

    /// The lines that called the program of an element, innermost first.
    pub(crate) fn call_lines(&self, element: &Element) -> Vec<u32> {
        self.execution.call_lines(&element.origin)
    }

    /// Blocks executed so far.
    pub(crate) fn blocks(&self) -> u64 {
        self.execution.executed_blocks()
    }

    /// True if a motion has occurred so far.
    pub(crate) fn moves(&self) -> bool {
        self.moves
    }

    /// Elements of the flat stream so far.
    pub(crate) fn elements(&self) -> u64 {
        self.elements
    }

    /// Range of the positions and tools so far.
    pub(crate) fn extent(&self) -> &PathExtent {
        &self.extent
    }

    fn note_extent(&mut self, element: &Element) {
        if let (Kind::Setup(setup), Some(kinematics)) = (&element.kind, &mut self.kinematics) {
            kinematics.set_head(self.machine, setup.head);
        }
        if let (Kind::Move(motion), Some(kinematics)) = (&element.kind, &self.kinematics)
            && let Some(turning) = motion.tip
        {
            let ends = [self.extent.last(), &motion.target];
            let path = TipPath::new(kinematics, turning == Turning::Vector, ends, self.extent.tool_mm());
            let extent = &mut self.extent;
            path.divide(
                motion.arc.as_ref().map(|arc| (arc, motion.arc_basis.as_ref())),
                EXTENT_MM,
                |position, _, _| extent.pass(motion, &position),
            );
        }
        self.extent.see(element);
    }

    /// The files of the subprograms that were read.
    pub(crate) fn files(&self) -> Vec<PathBuf> {
        self.loaded.borrow().clone()
    }
}

impl Iterator for Running<'_> {
    type Item = Result<Element, Diagnostic>;

    fn next(&mut self) -> Option<Self::Item> {
        let mut item = self.execution.next();
        while item.as_ref().is_some_and(|item| self.is_known_value(item)) {
            item = self.execution.next();
        }
        self.moves |= matches!(&item, Some(Ok(Element { kind: Kind::Move(_), .. })));
        if let Some(Ok(element)) = &item {
            self.elements += u64::from(element.kind.is_in_text());
            self.note_extent(element);
        }
        match &item {
            Some(Ok(element)) if element.starts_block => {
                if let Some(watch) = &mut self.watch {
                    // While a subprogram runs, the main program does not advance.
                    let offset = (element.origin.file == FileId(0)).then_some(element.origin.span.start);
                    watch.note(self.execution.executed_blocks(), offset, self.length);
                }
            }
            Some(_) => {}
            None => self.watch.iter_mut().for_each(|watch| watch.end()),
        }
        item
    }
}

/// True if the stamp of a program says that the control must have only wear in its tool registers.
pub(crate) fn is_wear_alone(source: &Source) -> bool {
    emit::stamped_promise(source.bytes()).is_some_and(|promise| promise.keeps_wear)
}

/// Options for a program that will be written: an uncertain position is an error, and radius compensation of the control is removed. `rapid_order`
/// selects the rapid moves that are split.
pub(crate) fn strict(rapid_order: RapidOrder) -> Options {
    Options { strict: true, tells_compensation: true, rapid_order, ..Options::default() }
}

/// The diagnostic for a program without motion.
pub(crate) fn without_motion(source: &Source, code: Code) -> Diagnostic {
    let place = Place { file: source.id(), span: Span::new(0, 1) };
    let help = "check where its motions are: after M30, in a program that nothing calls, in skip blocks";
    Diagnostic::at(code, place, "this program moves no axis: there is nothing to correct", help)
}
