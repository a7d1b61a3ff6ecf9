//! The family for the core: its types, and what it keeps for each level and call.

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
/// What comes after a block.
pub(super) type Action = core::level::AfterBlock<Grundig>;
/// A file, ready to run.
pub(super) type Loaded = core::family::FileOf<Grundig>;

/// What a level runs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum LevelKind {
    /// The main program.
    Main,
    /// A program that G23 has called.
    Program,
    /// A macro that G22 has called.
    Macro,
}

/// G22 and G23.
#[derive(Clone, Copy, Debug)]
pub(super) struct MacroCall {
    pub(super) kind: LevelKind,
    pub(super) number: u32,
    pub(super) span: Span,
}

impl Family for Grundig {
    type Program = Program;
    type Prepared = ();
    /// Whether it is a macro, and its number.
    type Name = (bool, u32);
    /// File and part.
    type Entry = (usize, usize);
    type Call = MacroCall;
    type Return = Infallible;
    /// M30 or M2.
    type End = Option<u16>;
    /// The parameter of G14 that counts, and by how much it falls with each pass.
    type Pass = Option<(usize, f64)>;
    type Level = LevelKind;
}
