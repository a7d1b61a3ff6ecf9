//! The types of this family for the core, and its data per level and call.

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
/// Action after a block.
pub(super) type Action = core::level::AfterBlock<Sinumerik>;
/// A program file, ready for execution.
pub(super) type Loaded = core::family::FileOf<Sinumerik>;

impl Family for Sinumerik {
    type Program = Program;
    type Prepared = Lookups;
    type Name = String;
    /// Indices of file and section.
    type Entry = (usize, usize);
    type Call = CallForm;
    type Return = ReturnTarget;
    /// The number of M2, M17 or M30, if any.
    type End = Option<u32>;
    type Pass = ();
    type Level = CalledWith;
}

/// Form of a call.
#[derive(Debug)]
pub(super) enum CallForm {
    /// A word: `NAME(…)`, `L10 P2`.
    Word(Call),
    /// CALL, MCALL …: an index in the call statements.
    Statement(u32),
}

/// Target of RET.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct ReturnTarget {
    /// Label or block number in the caller; empty for the block after the call.
    pub(super) place: Vec<u8>,
    /// `true` to continue after that block.
    pub(super) behind: bool,
    /// Number of program levels to return.
    pub(super) levels: u32,
}

/// A called program.
#[derive(Clone, Debug)]
pub(super) struct Entry {
    pub(super) program: usize,
    pub(super) section: usize,
    pub(super) arguments: Vec<Argument>,
    pub(super) repeats: u32,
    pub(super) is_modal: bool,
    /// The first and last block to execute, for a part.
    pub(super) part: Option<(usize, usize)>,
    pub(super) span: Span,
    /// The file of the call.
    pub(super) file: FileId,
}

/// Call data of a running program, and the state to restore for its caller.
#[derive(Default)]
pub(super) struct CalledWith {
    /// Arguments of the call.
    pub(super) arguments: Vec<Argument>,
    /// Variables of the level that called this one.
    pub(super) callers_variables: Locals,
    /// Modal state of the caller, if the program has SAVE.
    pub(super) saved: Option<Box<Modal>>,
    /// `true` if called by MCALL: its own motions do not trigger the modal call.
    pub(super) is_modal: bool,
    /// The call, in the file of the caller.
    pub(super) span: Span,
    /// The call of the built-in cycle that contains the program.
    pub(super) cycle: Option<Cycle>,
    /// First and last block, if only a part of the program was called.
    pub(super) within: Option<(usize, usize)>,
    /// For a text of EXECSTRING: variables lent by its caller, with their names there and here.
    pub(super) lent: Option<Vec<(NameId, NameId)>>,
    /// End values of FOR loops, by the block of the FOR.
    pub(super) for_ends: HashMap<usize, f64>,
    /// Executed DEF blocks: a jump back over them does not define them again.
    pub(super) defined: HashSet<usize>,
}
