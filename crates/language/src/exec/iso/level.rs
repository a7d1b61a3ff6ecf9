//! Program levels: which program runs, where it is, and what its caller gets back.

use std::rc::Rc;

use super::call::{Call, CallKind};
use super::flow::Action;
use crate::syntax::words::Block;

/// A program that runs.
#[derive(Debug, Default)]
pub(super) struct Level {
    pub(super) program: usize,
    /// Its part of the file.
    pub(super) part: usize,
    /// The block to execute next.
    pub(super) next: usize,
    /// The call chain that led here.
    pub(super) calls: u32,
    /// The block that it begins with.
    pub(super) start: usize,
    /// How it was called; `None` for the main program.
    pub(super) call: Option<Rc<Call>>,
    /// How many runs of this program are left, this one included.
    pub(super) repeats: u32,
    /// The modal call whose program this is or belongs to: motions here trigger only those before it.
    pub(super) modal: Option<usize>,
    /// Whether a mapped code called this program, or one that led here.
    pub(super) is_of_code: bool,
    /// What a block still does behind the modal call that it triggered.
    pub(super) pending: Option<Box<(Action, Block)>>,
}

impl Level {
    pub(super) fn new(program: usize, part: usize, next: usize, calls: u32) -> Self {
        Level { program, part, next, calls, start: next, repeats: 1, ..Level::default() }
    }

    /// Whether it is a subroutine of O-words.
    pub(super) fn is_sub(&self) -> bool {
        self.call.as_ref().is_some_and(|call| call.kind == CallKind::Sub)
    }
}
