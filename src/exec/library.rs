//! Programs that are loaded, and where further ones come from.

use super::names::{self, Meaning};
use crate::machine::Control;
use crate::syntax::{Block, Program};

/// Finds subprograms that are not in the file of the main program.
pub trait Library {
    /// The file of the subprogram `name` (upper case, without ending): the name to show, and its bytes.
    fn load(&mut self, name: &str) -> Option<(String, Vec<u8>)>;
}

/// A library without programs.
#[derive(Clone, Copy, Debug, Default)]
pub struct NoLibrary;

impl Library for NoLibrary {
    fn load(&mut self, _name: &str) -> Option<(String, Vec<u8>)> {
        None
    }
}

/// A program file, ready to run.
pub(super) struct Loaded {
    pub(super) program: Program,
    pub(super) meanings: Vec<Meaning>,
    /// Targets of its jumps, where they were looked up already.
    pub(super) targets: Vec<Option<usize>>,
    /// Blocks whose comments were passed on already.
    commented: Vec<bool>,
}

impl Loaded {
    pub(super) fn new(program: Program, control: &Control) -> Self {
        let meanings = names::resolve(&program, program.dialect, control);
        let targets = vec![None; program.jumps.len()];
        let commented = vec![false; program.blocks.len()];
        Loaded { program, meanings, targets, commented }
    }

    /// The comment of a block the first time it is executed: a loop does not repeat its comments.
    pub(super) fn take_comment(&mut self, index: usize, block: &Block) -> Option<Vec<u8>> {
        if block.comment.start == block.comment.end || std::mem::replace(&mut self.commented[index], true) {
            return None;
        }
        Some(self.program.source.slice(block.comment).to_vec())
    }
}

/// The section of a program that has this name.
pub(super) fn section_of(program: &Program, name: &str) -> Option<usize> {
    program.sections.iter().position(|section| section.name == name)
}
