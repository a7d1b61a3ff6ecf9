//! What is worked out of a file once, when it is loaded.

use std::collections::HashMap;

use super::names::{self, Meaning};
use super::place::Place;
use crate::exec::core::program::{LoadedFile, ProgramText, Statement};
use crate::syntax::sinumerik::{Block, Body, Parameter, Program};
use ncfix_base::source::{Source, Span};
use ncfix_machine::machine::Control;
use ncfix_machine::snc::BlockNumber;

/// What is worked out of a file.
pub(super) struct Lookups {
    /// What its names mean.
    pub(super) meanings: Vec<Meaning>,
    /// Targets of its jumps, where they were looked up already.
    pub(super) targets: Vec<Option<usize>>,
    /// Blocks of its jumps with computed targets, as far as they were looked up.
    pub(super) computed: HashMap<(usize, Place), usize>,
    /// Blocks of its repetitions, where they were looked up already.
    pub(super) parts: Vec<Option<(usize, usize)>>,
    /// By section: first and number of the parameters of its PROC block, and whether it has SAVE.
    procs: Vec<(u32, u16, bool)>,
    /// The name of a built-in cycle.
    pub(super) built_in: Option<&'static str>,
}

impl Lookups {
    pub(super) fn of(program: &Program, control: &Control) -> Self {
        let meanings = names::resolve(program, program.dialect, control);
        let targets = vec![None; program.jumps.len()];
        let parts = vec![None; program.repetitions.len()];
        let procs =
            program.sections.iter().map(|section| proc_of(program.blocks.there(section.blocks.clone()))).collect();
        Lookups { meanings, targets, computed: HashMap::new(), parts, procs, built_in: None }
    }

    /// Whether a section's program has SAVE.
    pub(super) fn has_save(&self, section: usize) -> bool {
        self.procs.get(section).is_some_and(|&(_, _, save)| save)
    }
}

/// A file, ready to run.
pub(super) fn load(program: Program, control: &Control) -> LoadedFile<Program, Lookups> {
    let prepared = Lookups::of(&program, control);
    LoadedFile::with(program, prepared)
}

impl LoadedFile<Program, Lookups> {
    /// Makes it a cycle of the control: its comments are nobody's, and SETAL in it is a finding.
    pub(super) fn become_built_in(&mut self, name: &'static str) {
        self.own.built_in = Some(name);
        self.drop_comments();
        let names = self.program.names.iter();
        for (meaning, _) in self.own.meanings.iter_mut().zip(names).filter(|(_, name)| *name == "SETAL") {
            *meaning = Meaning::Alarm;
        }
    }

    /// The parameters of a section's program.
    pub(super) fn parameters(&self, section: usize) -> &[Parameter] {
        self.own.procs.get(section).map_or(&[], |&(start, count, _)| self.program.parameters_of(start, count))
    }

    /// The comment of a block the first time it is executed: a loop does not repeat its comments.
    pub(super) fn take_comment(&mut self, index: usize, block: &Block) -> Option<Vec<u8>> {
        if block.comment.start == block.comment.end || !self.takes_comments_of(index) {
            return None;
        }
        Some(self.program.source.slice(block.comment).to_vec())
    }
}

/// What the PROC block says, which stands before all that is executed.
fn proc_of(blocks: &[Block]) -> (u32, u16, bool) {
    let first = blocks.iter().find(|block| !matches!(block.body, Body::Empty | Body::Declaration));
    match first.map(|block| block.body) {
        Some(Body::Proc { start, count, save, .. }) => (start, count, save),
        _ => (0, 0, false),
    }
}

impl Statement for Block {
    fn span(&self) -> Span {
        self.span
    }

    fn line(&self) -> u32 {
        self.line
    }

    fn skip(&self) -> Option<u8> {
        self.skip
    }

    fn number(&self) -> Option<BlockNumber> {
        self.number.map(|written| BlockNumber { main: written.main, number: written.number })
    }
}

impl ProgramText for Program {
    type Block = Block;

    fn source(&self) -> &Source {
        &self.source
    }

    fn block_count(&self) -> usize {
        self.blocks.len()
    }

    fn ensure(&mut self, block: usize) {
        self.ensure(block);
    }

    fn block(&self, block: usize) -> Option<&Block> {
        self.blocks.get(block)
    }
}
