//! The family for the core: its types, and what it keeps for each level.

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
/// What comes after a block.
pub(super) type Action = core::level::AfterBlock<Iso>;
/// A program file, ready to run.
pub(super) type Loaded = core::family::FileOf<Iso>;

/// How a program that runs was called.
#[derive(Debug, Default)]
pub(super) struct Called {
    /// The block that it begins with.
    pub(super) start: usize,
    /// How it was called; `None` for the main program.
    pub(super) call: Option<Rc<Call>>,
    /// The modal call whose program this is or belongs to: motions here trigger only those before it.
    pub(super) modal: Option<usize>,
    /// Whether a mapped code called this program, or one that led here.
    pub(super) is_of_code: bool,
}

impl Called {
    /// Whether it is a subroutine of O-words.
    pub(super) fn is_sub(&self) -> bool {
        self.call.as_ref().is_some_and(|call| call.kind == CallKind::Sub)
    }
}

impl Family for Iso {
    type Program = Program;
    type Prepared = Loops;
    type Name = String;
    /// The file; where in it a program begins is found with each call.
    type Entry = usize;
    type Call = Box<Call>;
    /// The block number in the caller, where there is one.
    type Return = Option<u32>;
    type End = ();
    type Pass = ();
    type Level = Called;
}
