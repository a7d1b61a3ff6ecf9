//! Executes a program as the control would and yields the flat stream, lazily and in bounded memory.
//!
//! Every family of languages has an executor of its own, in a folder of its name. What they share is here: the outlet that turns
//! paths into moves (radius compensation and roundings in `contour`, five-axis transformations in `five_axis`), and the ledger
//! of files, findings and calls. Findings are items of the stream too; after an error the execution goes on, so that one run shows
//! them all, but what it yields is then no longer good for anything but more findings.

mod arc;
mod contour;
mod fault;
mod five_axis;
mod flags;
mod grid;
mod grundig;
mod iso;
mod ledger;
mod library;
mod outlet;
mod path;
mod radius;
mod resolve;
mod rollover;
mod sagitta;
mod sinumerik;
mod tilted_plane;

pub use library::{Library, NoLibrary};
pub use radius::Radius;

use std::collections::VecDeque;

use crate::syntax::Program;
use ledger::{Ledger, Stage};
use ncfix_base::diagnostic::Diagnostic;
use ncfix_base::geometry::AxisVector;
use ncfix_base::source::Source;
use ncfix_dialect::Language;
use ncfix_machine::machine::Machine;
use ncfix_machine::snc::{Element, Origin};

/// Puts data that a control has saved (tools, zero offsets, parameters) into the machine that it controls.
#[must_use]
pub fn apply_archive(source: &Source, machine: &mut Machine) -> Vec<Diagnostic> {
    match ncfix_dialect::find(&machine.controller) {
        Some(dialect) if dialect.language == Language::Grundig => grundig::apply_tables(source, dialect, machine),
        _ => sinumerik::apply_archive(source, machine),
    }
}

/// How to execute.
#[derive(Clone, Debug, Default)]
pub struct Options {
    /// Skip levels whose blocks are left out.
    pub skip_levels: [bool; 10],
    /// Executed blocks after which the run stops with a finding; `None` for ten million, or twenty times the blocks of the
    /// main program if that is more.
    pub max_blocks: Option<u64>,
    /// Axis commands (mm, rad) at the start, where they are known.
    pub start: Option<AxisVector>,
    /// Refuse what a correction must not assume: zero offsets and tools without value, motions from unknown positions.
    pub strict: bool,
    /// Say at the end where radius compensation has become the way of the tool center (`W0236`).
    pub tells_compensation: bool,
    /// Which radius G41 and G42 work with.
    pub radius: Radius,
    /// Leave the control the words that begin and end radius compensation, for wear alone (`W0237`).
    pub keeps_wear: bool,
    /// Which rapid moves are taken apart, where the control orders its axes.
    pub rapid_order: RapidOrder,
}

/// Which rapid moves an executor takes apart as a control does that moves the tool axis first or last.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum RapidOrder {
    /// All; a start that is not known is assumed, unless the run is strict.
    #[default]
    All,
    /// Those whose start the program has stated.
    Stated,
    /// None: in a corrected program they are apart already, and what else they move is micrometers.
    None,
}

/// What an executor of a language is.
trait Executor {
    /// Its books.
    fn ledger(&self) -> &Ledger;

    /// Its books, and the elements that are final.
    fn books(&mut self) -> (&mut Ledger, &mut VecDeque<Element>);

    /// Executes a block.
    fn step(&mut self);

    /// Ends what is held back when no more blocks are executed; called once.
    fn finish(&mut self);

    /// The next finding or element.
    fn advance(&mut self) -> Option<Result<Element, Diagnostic>> {
        loop {
            let (ledger, queue) = self.books();
            if let Some(finding) = ledger.findings.pop_front() {
                return Some(Err(finding));
            }
            if let Some(element) = queue.pop_front() {
                return Some(Ok(element));
            }
            match ledger.stage {
                Stage::Runs => self.step(),
                Stage::Over => {
                    ledger.stage = Stage::Finished;
                    self.finish();
                }
                Stage::Finished => return None,
            }
        }
    }
}

/// A running program: an iterator over the elements of the flat stream and the findings.
pub struct Execution<'a> {
    executor: Box<dyn Executor + 'a>,
}

impl<'a> Execution<'a> {
    /// Starts a program. Syntax findings of the main program are the caller's business; faulty blocks do nothing here.
    #[must_use]
    pub fn new(program: Program, machine: &'a Machine, library: Box<dyn Library + 'a>, options: Options) -> Self {
        let executor: Box<dyn Executor + 'a> = match program {
            Program::Sinumerik(program) => Box::new(sinumerik::Interpreter::new(program, machine, library, options)),
            Program::Words(program) if program.dialect.language == Language::Grundig => {
                Box::new(grundig::Interpreter::new(program, machine, library, options))
            }
            Program::Words(program) => Box::new(iso::Interpreter::new(program, machine, library, options)),
        };
        Execution { executor }
    }

    /// All files of the run so far, by [`ncfix_base::source::FileId`].
    #[must_use]
    pub fn sources(&self) -> &[Source] {
        &self.executor.ledger().sources
    }

    /// Blocks executed so far.
    #[must_use]
    pub fn executed_blocks(&self) -> u64 {
        self.executor.ledger().executed()
    }

    /// Lines of the calls that led to an element, innermost first; empty in the main program.
    #[must_use]
    pub fn call_lines(&self, origin: &Origin) -> Vec<u32> {
        self.executor.ledger().call_lines(origin)
    }
}

impl Iterator for Execution<'_> {
    type Item = Result<Element, Diagnostic>;

    fn next(&mut self) -> Option<Self::Item> {
        self.executor.advance()
    }
}
