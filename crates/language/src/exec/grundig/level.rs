//! The types of this family for the core, and its data per level and call.

use std::convert::Infallible;

use crate::exec::core;
use crate::exec::core::family::Family;
use crate::syntax::words::Program;
use ncfix_base::source::Span;

/// Grundig, Philips and `MillPlus`.
#[derive(Debug)]
pub(super) struct Grundig;

/// A running program.
pub(super) type Interpreter<'a> = core::interpreter::Runner<'a, Grundig>;
/// A program that is being executed.
pub(super) type Level = core::level::ProgramLevel<Grundig>;
/// Action after a block.
pub(super) type Action = core::level::AfterBlock<Grundig>;
/// A file, ready for execution.
pub(super) type Loaded = core::family::FileOf<Grundig>;

/// Kind of a level.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum LevelKind {
    /// The main program.
    Main,
    /// A program called by G23.
    Program,
    /// A macro called by G22.
    Macro,
}

/// A call by G22 or G23.
#[derive(Clone, Copy, Debug)]
pub(super) struct MacroCall {
    pub(super) kind: LevelKind,
    pub(super) number: u32,
    pub(super) span: Span,
}

impl Family for Grundig {
    type Program = Program;
    type Prepared = ();
    /// `true` for a macro, and the number.
    type Name = (bool, u32);
    /// Indices of file and part.
    type Entry = (usize, usize);
    type Call = MacroCall;
    type Return = Infallible;
    /// M30 or M2.
    type End = Option<u16>;
    /// The counting parameter of G14, and its decrement per pass.
    type Pass = Option<(usize, f64)>;
    type Level = LevelKind;
}
