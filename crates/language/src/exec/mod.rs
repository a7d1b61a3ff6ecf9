//! Executes a program as the control would and yields the flat stream, lazily and in bounded memory.
//!
//! A *family* is a group of dialects with one executor, in a folder of its name: Sinumerik, Grundig, or `iso` (Fanuc and RS274/NGC). Common parts are in
//! `core`: the motion sink, which converts paths into moves (radius compensation and roundings in `contour`, five-axis transformations in `five_axis`), and
//! the run state with files, diagnostics and calls. Diagnostics are items of the stream too. After an error the execution continues, so that one run
//! reports all errors; its output then only serves further diagnostics.

mod core;
mod grundig;
mod iso;
mod sinumerik;

pub use core::library::{Library, NoLibrary};
pub use core::options::{Options, RapidOrder};
pub use core::radius::Radius;

use crate::syntax::Program;
use core::executor::Executor;
use ncfix_base::diagnostic::Diagnostic;
use ncfix_base::source::Source;
use ncfix_dialect::Language;
use ncfix_machine::machine::Machine;
use ncfix_machine::snc::{Element, Origin};

/// Applies data that a control has saved (tools, zero offsets, parameters) to the machine.
#[must_use]
pub fn apply_archive(source: &Source, machine: &mut Machine) -> Vec<Diagnostic> {
    match ncfix_dialect::find(&machine.controller) {
        Some(dialect) if dialect.language == Language::Grundig => grundig::apply_tables(source, dialect, machine),
        _ => sinumerik::apply_archive(source, machine),
    }
}

/// A running program: an iterator over the elements of the flat stream and the diagnostics.
pub struct Execution<'a> {
    executor: Box<dyn Executor + 'a>,
}

impl<'a> Execution<'a> {
    /// Starts a program. The caller handles syntax diagnostics of the main program; faulty blocks have no effect here.
    #[must_use]
    pub fn new(program: Program, machine: &'a Machine, library: Box<dyn Library + 'a>, options: Options) -> Self {
        let executor: Box<dyn Executor + 'a> = match program {
            Program::Sinumerik(program) => sinumerik::start(program, machine, library, &options),
            Program::Words(program) if program.dialect.language == Language::Grundig => {
                grundig::start(program, machine, library, &options)
            }
            Program::Words(program) => iso::start(program, machine, library, &options),
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
