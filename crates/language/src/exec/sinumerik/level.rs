//! The family for the core: its types, and what it keeps for each level and call.

use std::collections::{HashMap, HashSet};

use super::argument::Argument;
use super::cycles::Cycle;
use super::gathered::Call;
use super::loaded::Lookups;
use super::modal::Modal;
use super::variables::Locals;
use crate::exec::core;
use crate::exec::core::family::Family;
use crate::syntax::sinumerik::{NameId, Program};
use ncfix_base::source::{FileId, Span};

/// Sinumerik.
#[derive(Debug)]
pub(super) struct Sinumerik;

/// A running program.
pub(super) type Interpreter<'a> = core::interpreter::Runner<'a, Sinumerik>;
/// A program that is being executed.
pub(super) type Level = core::level::ProgramLevel<Sinumerik>;
/// What comes after a block.
pub(super) type Action = core::level::AfterBlock<Sinumerik>;
/// A program file, ready to run.
pub(super) type Loaded = core::family::FileOf<Sinumerik>;

impl Family for Sinumerik {
    type Program = Program;
    type Prepared = Lookups;
    type Name = String;
    /// File and section.
    type Entry = (usize, usize);
    type Call = CallForm;
    type Return = ReturnTarget;
    /// The number of M2, M17 or M30, where there is one.
    type End = Option<u32>;
    type Pass = ();
    type Level = CalledWith;
}

/// What calls a program.
#[derive(Debug)]
pub(super) enum CallForm {
    /// A word: `NAME(…)`, `L10 P2`.
    Word(Call),
    /// CALL, MCALL …: a place among the call statements.
    Statement(u32),
}

/// Where RET goes.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct ReturnTarget {
    /// Label or block number in the caller; empty for the block behind the call.
    pub(super) place: Vec<u8>,
    /// Whether to go on behind that block.
    pub(super) behind: bool,
    /// How many program levels back.
    pub(super) levels: u32,
}

/// A program that is called.
#[derive(Clone, Debug)]
pub(super) struct Entry {
    pub(super) program: usize,
    pub(super) section: usize,
    pub(super) arguments: Vec<Argument>,
    pub(super) repeats: u32,
    pub(super) is_modal: bool,
    /// Only these blocks, first and last.
    pub(super) part: Option<(usize, usize)>,
    pub(super) span: Span,
    /// The file of the call.
    pub(super) file: FileId,
}

/// How a program that runs was called, and what its caller gets back.
#[derive(Default)]
pub(super) struct CalledWith {
    /// What it was called with.
    pub(super) arguments: Vec<Argument>,
    /// Variables of the level that called this one.
    pub(super) callers_variables: Locals,
    /// Modal state of the caller, where the program has SAVE.
    pub(super) saved: Option<Box<Modal>>,
    /// Whether MCALL called it: its own motions call nothing.
    pub(super) is_modal: bool,
    /// The call, in the file of the caller.
    pub(super) span: Span,
    /// The call of the built-in cycle to which the program belongs.
    pub(super) cycle: Option<Cycle>,
    /// First and last block, where only a part of the program was called.
    pub(super) within: Option<(usize, usize)>,
    /// For a text of EXECSTRING: variables that it has from its caller, their names there and here.
    pub(super) lent: Option<Vec<(NameId, NameId)>>,
    /// End values of FOR loops by the block of the FOR.
    pub(super) for_ends: HashMap<usize, f64>,
    /// DEF blocks that were executed: a jump back over them defines nothing anew.
    pub(super) defined: HashSet<usize>,
}
