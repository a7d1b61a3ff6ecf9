//! Program levels: the running program, its position, its repetitions, and the effect of a block on the order of execution.

use std::fmt::Debug;

use super::family::{BlockOf, Family};

/// Action after a block.
#[derive(Debug)]
pub(in crate::exec) enum AfterBlock<F: Family> {
    /// The next block.
    Next,
    /// This block, as part of a control structure.
    Jump(usize),
    /// This block, as the target of a program jump.
    Goto(usize),
    /// A section, repeated, and then the next block.
    Repeat(RepeatedSection<F::Pass>),
    /// A program, and then the next block.
    Call(F::Call),
    /// Return to a caller.
    Return(F::Return),
    /// The program has ended.
    End(F::End),
}

impl<F: Family> AfterBlock<F> {
    /// `true` if the next block in the text follows.
    pub(in crate::exec) fn is_next(&self) -> bool {
        matches!(self, AfterBlock::Next)
    }
}

/// A section of blocks to repeat.
#[derive(Clone, Copy, Debug)]
pub(in crate::exec) struct RepeatedSection<P> {
    /// Its first and last block.
    pub(in crate::exec) first: usize,
    pub(in crate::exec) last: usize,
    /// Number of passes.
    pub(in crate::exec) passes: u64,
    /// Action at each pass.
    pub(in crate::exec) pass: P,
}

/// A section under repetition.
#[derive(Clone, Copy, Debug)]
struct Repetition<P> {
    first: usize,
    last: usize,
    /// Number of remaining passes.
    left: u64,
    /// Block after the last pass.
    resume: usize,
    pass: P,
}

/// A running program.
pub(in crate::exec) struct ProgramLevel<F: Family> {
    /// Index of its file.
    pub(in crate::exec) program: usize,
    /// Index of its part of the file.
    pub(in crate::exec) part: usize,
    /// The next block to execute.
    pub(in crate::exec) next: usize,
    /// The call chain of the level.
    pub(in crate::exec) calls: u32,
    /// Remaining runs of this program, including the current one.
    pub(in crate::exec) repeats: u32,
    /// Flow action of a block, postponed until after its modal call.
    pub(in crate::exec) pending: Option<Box<(AfterBlock<F>, BlockOf<F>)>>,
    /// Data of the family.
    pub(in crate::exec) own: F::Level,
    /// Sections under repetition; the innermost is last.
    repetitions: Vec<Repetition<F::Pass>>,
}

impl<F: Family> ProgramLevel<F> {
    pub(in crate::exec) fn new(program: usize, part: usize, next: usize, calls: u32, own: F::Level) -> Self {
        ProgramLevel { program, part, next, calls, repeats: 1, pending: None, own, repetitions: Vec::new() }
    }

    /// Number of nested repetitions.
    pub(in crate::exec) fn repetitions(&self) -> usize {
        self.repetitions.len()
    }

    /// Begins the repetition of a section, and continues at `resume` afterwards. Returns `true` if it has a pass.
    pub(in crate::exec) fn repeat(&mut self, section: RepeatedSection<F::Pass>, resume: usize) -> bool {
        let RepeatedSection { first, last, passes, pass } = section;
        let Some(left) = passes.checked_sub(1) else { return false };
        self.repetitions.push(Repetition { first, last, left, resume, pass });
        self.next = first;
        true
    }

    /// At the end of a repeated section, returns to its start or continues after it. Returns the action of the pass that begins.
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

    /// Moves to a block; sections that this leaves are not repeated further. A program jump to the block after a section leaves the section too, but
    /// a structural jump does not.
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
