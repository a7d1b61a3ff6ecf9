//! Program levels: which program runs, where it is, and what its caller gets back.

use std::collections::{HashMap, HashSet};

use super::cycles::Cycle;
use super::flow::Action;
use super::modal::Modal;
use super::parameters::Argument;
use super::part::Part;
use super::variables::Locals;
use crate::syntax::sinumerik::{Block, NameId};
use ncfix_base::source::Span;

/// A program level: a program that runs, and where it is.
pub(super) struct Level {
    pub(super) program: usize,
    pub(super) section: usize,
    /// The block to execute next.
    pub(super) next: usize,
    /// The call chain that led here.
    pub(super) calls: u32,
    /// How many runs of this program are left, this one included.
    pub(super) repeats: u32,
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
    pub(super) part: Option<(usize, usize)>,
    /// For a text of EXECSTRING: variables that it has from its caller, their names there and here.
    pub(super) lent: Option<Vec<(NameId, NameId)>>,
    /// Program parts that are being repeated, the innermost last.
    pub(super) parts: Vec<Part>,
    /// What a block still does behind the modal call that it triggered.
    pub(super) pending: Option<Box<(Action, Block)>>,
    /// End values of FOR loops by the block of the FOR.
    pub(super) for_ends: HashMap<usize, f64>,
    /// DEF blocks that were executed: a jump back over them defines nothing anew.
    pub(super) defined: HashSet<usize>,
}

impl Level {
    pub(super) fn new(program: usize, section: usize, next: usize, calls: u32) -> Self {
        Level {
            program,
            section,
            next,
            calls,
            repeats: 1,
            arguments: Vec::new(),
            callers_variables: Locals::default(),
            saved: None,
            is_modal: false,
            span: Span::default(),
            cycle: None,
            part: None,
            lent: None,
            parts: Vec::new(),
            pending: None,
            for_ends: HashMap::new(),
            defined: HashSet::new(),
        }
    }
}
