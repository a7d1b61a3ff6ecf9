//! Programs that are loaded.

use super::flow::loops_of;
use crate::exec::flags::Flags;
use crate::syntax::words::{Block, Program};

/// A program file, ready to run.
pub(super) struct Loaded {
    pub(super) program: Program,
    /// Blocks whose comments were passed on already.
    commented: Flags,
    /// First and last blocks of the loops that a jump could lead into.
    pub(super) loops: Vec<(usize, usize)>,
}

impl Loaded {
    pub(super) fn new(program: Program) -> Self {
        let commented = Flags::new(program.blocks.len());
        let loops = loops_of(&program);
        Loaded { program, commented, loops }
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
