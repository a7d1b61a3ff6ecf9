//! Loaded program files.

use std::ops::Range;

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

    /// `true` if a block contains nothing but a comment, which needs no value of the run.
    fn is_note(&self, block: &Self::Block) -> bool;
}

/// A file, ready for execution.
pub(in crate::exec) struct LoadedFile<P, T> {
    pub(in crate::exec) program: P,
    /// Data that its family has derived from it.
    pub(in crate::exec) own: T,
    /// Blocks whose comments were already passed on.
    commented: Flags,
    /// Blocks with only a comment that a jump has left out, and whose comment was passed on there.
    left_out: Flags,
    /// Number of blocks that may still be examined behind jumps: this bounds the time of a program that jumps over most of its text again and again.
    examinable: usize,
}

/// Number of times that each block may be examined behind jumps, on average.
const LOOKS_PER_BLOCK: usize = 8;

impl<P: ProgramText, T> LoadedFile<P, T> {
    /// Creates it from a file and the derived data.
    pub(in crate::exec) fn with(program: P, own: T) -> Self {
        let count = program.block_count();
        let [commented, left_out] = [Flags::new(count), Flags::new(count)];
        LoadedFile { program, own, commented, left_out, examinable: count.saturating_mul(LOOKS_PER_BLOCK) }
    }

    /// The next block of a range with only a comment that was not passed on yet. It stays open: if the program comes to it later, it is passed on there.
    pub(in crate::exec) fn next_left_out(&mut self, blocks: &mut Range<usize>) -> Option<(usize, P::Block)> {
        for index in blocks {
            self.examinable = self.examinable.checked_sub(1)?;
            self.program.ensure(index);
            let block = *self.program.block(index)?;
            let is_open = self.program.is_note(&block) && !self.commented.holds(index);
            if is_open && self.left_out.note(index) == Some(false) {
                return Some((index, block));
            }
        }
        None
    }

    /// Forgets that the comments of a block were passed on.
    pub(in crate::exec) fn reopen(&mut self, block: usize) {
        self.commented.clear(block);
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

    fn is_note(&self, block: &words::Block) -> bool {
        let comments = self.comments_of(block);
        matches!(block.body, words::Body::Empty | words::Body::Words)
            && block.label.is_none()
            && self.words_of(block).is_empty()
            && !comments.is_empty()
            && comments.iter().all(|comment| comment.kind == words::CommentKind::Plain)
    }
}
