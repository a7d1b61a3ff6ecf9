//! Loaded program files.

use super::flags::Flags;
use crate::syntax::words;
use ncfix_base::source::{Source, Span};
use ncfix_machine::snc::BlockNumber;

/// A block as used by the core.
pub(in crate::exec) trait Statement: Copy {
    /// The line without its line end.
    fn span(&self) -> Span;

    /// Line number, from 1.
    fn line(&self) -> u32;

    /// Level of a `/` at its start.
    fn skip(&self) -> Option<u8>;

    /// Its number.
    fn number(&self) -> Option<BlockNumber>;
}

/// A file as parsed by a grammar.
pub(in crate::exec) trait ProgramText {
    /// Its blocks.
    type Block: Statement;

    /// The bytes that all spans refer to.
    fn source(&self) -> &Source;

    /// Number of its blocks.
    fn block_count(&self) -> usize;

    /// Loads a block with everything that belongs to it.
    fn ensure(&mut self, block: usize);

    /// A loaded block.
    fn block(&self, block: usize) -> Option<&Self::Block>;
}

/// A file, ready for execution.
pub(in crate::exec) struct LoadedFile<P, T> {
    pub(in crate::exec) program: P,
    /// Data that its family has derived from it.
    pub(in crate::exec) own: T,
    /// Blocks whose comments were already passed on.
    commented: Flags,
}

impl<P: ProgramText, T> LoadedFile<P, T> {
    /// Creates it from a file and the derived data.
    pub(in crate::exec) fn with(program: P, own: T) -> Self {
        let commented = Flags::new(program.block_count());
        LoadedFile { program, own, commented }
    }

    /// `true` if the comments of a block are to be passed on: only at its first execution, as a loop does not repeat them.
    pub(in crate::exec) fn takes_comments_of(&mut self, block: usize) -> bool {
        self.commented.note(block) == Some(false)
    }

    /// Drops all comments.
    pub(in crate::exec) fn drop_comments(&mut self) {
        self.commented.note_all();
    }
}

impl Statement for words::Block {
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
        self.number.map(|number| BlockNumber { main: false, number })
    }
}

impl ProgramText for words::Program {
    type Block = words::Block;

    fn source(&self) -> &Source {
        &self.source
    }

    fn block_count(&self) -> usize {
        self.blocks.len()
    }

    fn ensure(&mut self, block: usize) {
        self.ensure(block);
    }

    fn block(&self, block: usize) -> Option<&words::Block> {
        self.blocks.get(block)
    }
}
