//! Data derived once from a file when it is loaded.

use std::collections::HashMap;

use super::names::{self, Meaning};
use super::place::Place;
use crate::exec::core::program::{LoadedFile, ProgramText, Statement};
use crate::syntax::sinumerik::{Block, Body, Parameter, Program};
use ncfix_base::source::{Source, Span};
use ncfix_machine::machine::Control;
use ncfix_machine::snc::BlockNumber;

/// Data derived from a file.
pub(super) struct Lookups {
    /// Meanings of its names.
    pub(super) meanings: Vec<Meaning>,
    /// Targets of its jumps, as far as already searched.
    pub(super) targets: Vec<Option<usize>>,
    /// Blocks of its jumps with computed targets, as far as already searched.
    pub(super) computed: HashMap<(usize, Place), usize>,
    /// Blocks of its repetitions, as far as already searched.
    pub(super) parts: Vec<Option<(usize, usize)>>,
    /// By section: first parameter and number of parameters of its PROC block, and `true` if it has SAVE.
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

    /// `true` if a section's program has SAVE.
    pub(super) fn has_save(&self, section: usize) -> bool {
        self.procs.get(section).is_some_and(|&(_, _, save)| save)
    }
}

/// A file, ready for execution.
pub(super) fn load(program: Program, control: &Control) -> LoadedFile<Program, Lookups> {
    let prepared = Lookups::of(&program, control);
    LoadedFile::with(program, prepared)
}

impl LoadedFile<Program, Lookups> {
    /// Marks it as a cycle of the control: its comments are dropped, and SETAL in it is an error.
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

    /// The comment of a block at its first execution: a loop does not repeat its comments.
    pub(super) fn take_comment(&mut self, index: usize, block: &Block) -> Option<Vec<u8>> {
        if block.comment.start == block.comment.end || !self.takes_comments_of(index) {
            return None;
        }
        Some(self.program.source.slice(block.comment).to_vec())
    }
}

/// The data of the PROC block, which precedes all executed blocks.
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

    fn is_note(&self, block: &Block) -> bool {
        matches!(block.body, Body::Empty) && block.label.is_none() && block.comment.start < block.comment.end
    }
}
