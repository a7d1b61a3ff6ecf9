//! Program levels: which program runs, where it is, what it repeats, and what a block does to the order of execution.

use std::fmt::Debug;

use super::family::{BlockOf, Family};

/// What comes after a block.
#[derive(Debug)]
pub(in crate::exec) enum AfterBlock<F: Family> {
    /// The next block.
    Next,
    /// This block, around the blocks of a control structure.
    Jump(usize),
    /// This block, where the program jumps to it.
    Goto(usize),
    /// A section, so many times, and then the next block.
    Repeat(RepeatedSection<F::Pass>),
    /// A program, and then the next block.
    Call(F::Call),
    /// Back to a caller.
    Return(F::Return),
    /// The program has ended.
    End(F::End),
}

impl<F: Family> AfterBlock<F> {
    /// Whether the order of the blocks is that of the text.
    pub(in crate::exec) fn is_next(&self) -> bool {
        matches!(self, AfterBlock::Next)
    }
}

/// Blocks of a program that are to be repeated.
#[derive(Clone, Copy, Debug)]
pub(in crate::exec) struct RepeatedSection<P> {
    /// Its first and last block.
    pub(in crate::exec) first: usize,
    pub(in crate::exec) last: usize,
    /// How many passes it has.
    pub(in crate::exec) passes: u64,
    /// What happens with each pass.
    pub(in crate::exec) pass: P,
}

/// A section that is being repeated.
#[derive(Clone, Copy, Debug)]
struct Repetition<P> {
    first: usize,
    last: usize,
    /// How many passes are still to come.
    left: u64,
    /// Where it goes on behind the last pass.
    resume: usize,
    pass: P,
}

/// A program that runs.
pub(in crate::exec) struct ProgramLevel<F: Family> {
    /// Its file.
    pub(in crate::exec) program: usize,
    /// Its part of the file.
    pub(in crate::exec) part: usize,
    /// The block to execute next.
    pub(in crate::exec) next: usize,
    /// The call chain that led here.
    pub(in crate::exec) calls: u32,
    /// How many runs of this program are left, this one included.
    pub(in crate::exec) repeats: u32,
    /// What a block still does behind the modal call that it triggered.
    pub(in crate::exec) pending: Option<Box<(AfterBlock<F>, BlockOf<F>)>>,
    /// What its family keeps.
    pub(in crate::exec) own: F::Level,
    /// Sections that are being repeated, the innermost last.
    repetitions: Vec<Repetition<F::Pass>>,
}

impl<F: Family> ProgramLevel<F> {
    pub(in crate::exec) fn new(program: usize, part: usize, next: usize, calls: u32, own: F::Level) -> Self {
        ProgramLevel { program, part, next, calls, repeats: 1, pending: None, own, repetitions: Vec::new() }
    }

    /// Sections within one another that are being repeated.
    pub(in crate::exec) fn repetitions(&self) -> usize {
        self.repetitions.len()
    }

    /// Begins to repeat a section, and goes on at `resume` behind it. Whether it has a pass.
    pub(in crate::exec) fn repeat(&mut self, section: RepeatedSection<F::Pass>, resume: usize) -> bool {
        let RepeatedSection { first, last, passes, pass } = section;
        let Some(left) = passes.checked_sub(1) else { return false };
        self.repetitions.push(Repetition { first, last, left, resume, pass });
        self.next = first;
        true
    }

    /// At the end of a repeated section: back to its start, or on behind it. What happens with the pass that begins.
    pub(in crate::exec) fn end_sections(&mut self) -> Option<F::Pass> {
        while let Some(section) = self.repetitions.last_mut().filter(|section| self.next == section.last + 1) {
            if section.left > 0 {
                section.left -= 1;
                self.next = section.first;
                return Some(section.pass);
            }
            self.next = section.resume;
            self.repetitions.pop();
        }
        None
    }

    /// Goes to a block; a section that is left by this is not repeated further. A jump of the program to the block behind the section
    /// leaves it too, the way around a branch does not.
    pub(in crate::exec) fn go_to(&mut self, target: usize, is_jump: bool) {
        self.next = target;
        while let Some(section) = self.repetitions.last() {
            let end = if is_jump { section.last } else { section.last + 1 };
            if (section.first..=end).contains(&target) {
                return;
            }
            self.repetitions.pop();
        }
    }
}
