//! Programs that are loaded.

use std::collections::HashMap;

use super::flow::{breaks_of, loops_of};
use crate::exec::core::flags::Flags;
use crate::exec::core::ledger::Ledger;
use crate::syntax::words::{Block, Program};

/// A program file, ready to run.
pub(super) struct Loaded {
    pub(super) program: Program,
    /// Blocks whose comments were passed on already.
    commented: Flags,
    /// First and last blocks of the loops that a jump could lead into.
    pub(super) loops: Vec<(usize, usize)>,
    /// The last `break` of the loops that have one, by the block where the loop begins.
    breaks: HashMap<usize, usize>,
}

impl Loaded {
    pub(super) fn new(program: Program, ledger: &Ledger) -> Self {
        let commented = Flags::new(program.blocks.len());
        let loops = loops_of(&program);
        let breaks = breaks_of(&program, ledger);
        Loaded { program, commented, loops, breaks }
    }

    /// Whether a `break` of the loop that begins at `start` stands behind a block of it.
    pub(super) fn has_break_behind(&self, start: usize, index: usize) -> bool {
        self.breaks.get(&start).is_some_and(|&last| last > index)
    }

    /// Whether the comments of a block that only explain the program are to be passed on: the first time it is executed, a loop does
    /// not repeat them.
    pub(super) fn takes_comments(&mut self, index: usize, block: &Block) -> bool {
        if self.program.comments_of(block).is_empty() {
            return false;
        }
        self.commented.note(index) == Some(false)
    }
}
