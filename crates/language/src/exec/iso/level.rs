//! The types of this family for the core, and its data per level.

use std::rc::Rc;

use super::call::{Call, CallKind};
use super::loaded::Loops;
use crate::exec::core;
use crate::exec::core::family::Family;
use crate::syntax::words::Program;

/// Fanuc and RS274/NGC.
#[derive(Debug)]
pub(super) struct Iso;

/// A running program.
pub(super) type Interpreter<'a> = core::interpreter::Runner<'a, Iso>;
/// A program that is being executed.
pub(super) type Level = core::level::ProgramLevel<Iso>;
/// Action after a block.
pub(super) type Action = core::level::AfterBlock<Iso>;
/// A program file, ready for execution.
pub(super) type Loaded = core::family::FileOf<Iso>;

/// Call data of a running program.
#[derive(Debug, Default)]
pub(super) struct Called {
    /// Its first block.
    pub(super) start: usize,
    /// The call; `None` for the main program.
    pub(super) call: Option<Rc<Call>>,
    /// Index of the modal call that contains this program: motions here trigger only earlier ones.
    pub(super) modal: Option<usize>,
    /// `true` if a mapped code called this program or one of its callers.
    pub(super) is_of_code: bool,
}

impl Called {
    /// `true` if it is an O-word subroutine.
    pub(super) fn is_sub(&self) -> bool {
        self.call.as_ref().is_some_and(|call| call.kind == CallKind::Sub)
    }
}

impl Family for Iso {
    type Program = Program;
    type Prepared = Loops;
    type Name = String;
    /// The file; the start of a program in it is searched at each call.
    type Entry = usize;
    type Call = Box<Call>;
    /// The block number in the caller, if any.
    type Return = Option<u32>;
    type End = ();
    type Pass = ();
    type Level = Called;
}
