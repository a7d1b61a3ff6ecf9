//! The loops of a file: their start, end and exits.

use std::collections::HashMap;

use crate::exec::core::run_state::RunState;
use crate::syntax::words::{Block, Body, Program};
use ncfix_dialect::Language;

/// The loops of a file.
pub(super) struct Loops {
    /// First and last blocks of the loops into which a jump could lead.
    pub(super) spans: Vec<(usize, usize)>,
    /// The last `break` of each loop that has one, by the first block of the loop.
    breaks: HashMap<usize, usize>,
}

impl Loops {
    pub(super) fn of(program: &Program, ledger: &RunState) -> Self {
        Loops { spans: loops_of(program), breaks: breaks_of(program, ledger) }
    }

    /// `true` if the loop that begins at `start` has a `break` after a block.
    pub(super) fn has_break_behind(&self, start: usize, index: usize) -> bool {
        self.breaks.get(&start).is_some_and(|&last| last > index)
    }
}

/// First and last blocks of the loops into which a jump could lead.
fn loops_of(program: &Program) -> Vec<(usize, usize)> {
    if program.dialect.language != Language::Fanuc {
        return Vec::new();
    }
    let is_loop = |(start, block): (usize, &Block)| match block.body {
        Body::While(_) => block.partner().map(|end| (start, end)),
        _ => None,
    };
    program.blocks.iter().enumerate().filter_map(is_loop).collect()
}

/// The last `break` of each loop that is not skipped, by the first block of the loop.
fn breaks_of(program: &Program, ledger: &RunState) -> HashMap<usize, usize> {
    let is_left_out = |block: &Block| block.skip.is_some_and(|level| ledger.leaves_out(level));
    let breaks =
        program.blocks.iter().enumerate().filter(|(_, block)| block.body == Body::Break && !is_left_out(block));
    breaks.filter_map(|(index, block)| Some((block.partner()?, index))).collect()
}
