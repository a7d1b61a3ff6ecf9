//! Where the execution is: the program, the next block, the sections that are being repeated.

use crate::exec::core::fault::{Fault, fault};
use ncfix_base::diagnostic::Code;
use ncfix_base::source::Span;

/// Repetitions within one another.
const MOST_REPEATS: usize = 16;

/// What a level runs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum LevelKind {
    /// The main program.
    Main,
    /// A program that G23 has called.
    Program,
    /// A macro that G22 has called.
    Macro,
}

/// A section that G14 repeats.
#[derive(Clone, Copy, Debug)]
pub(super) struct Repeat {
    /// Its first and last block.
    pub(super) first: usize,
    pub(super) last: usize,
    /// How many passes are still to come.
    pub(super) left: u64,
    /// The block behind the G14.
    pub(super) resume: usize,
    /// The parameter that counts, and by how much it falls with each pass.
    pub(super) counter: Option<(usize, f64)>,
}

/// A program that is being executed.
#[derive(Debug)]
pub(super) struct Level {
    pub(super) kind: LevelKind,
    pub(super) program: usize,
    pub(super) part: usize,
    pub(super) next: usize,
    pub(super) calls: u32,
    pub(super) repeats: Vec<Repeat>,
}

impl Level {
    pub(super) fn new(kind: LevelKind, program: usize, part: usize, next: usize, calls: u32) -> Level {
        Level { kind, program, part, next, calls, repeats: Vec::new() }
    }

    /// Begins to repeat a section.
    pub(super) fn begin(&mut self, repeat: Repeat, span: Span) -> Result<(), Fault> {
        if self.repeats.len() >= MOST_REPEATS {
            let message = "repetitions (G14) are nested too deeply";
            return Err(fault(Code::TOO_MANY_CALLS, span, message, "write some of the repetitions out"));
        }
        self.next = repeat.first;
        self.repeats.push(repeat);
        Ok(())
    }

    /// Goes on at another block; sections that it leaves are not repeated any more.
    pub(super) fn jump(&mut self, target: usize) {
        while self.repeats.last().is_some_and(|repeat| !(repeat.first..=repeat.last).contains(&target)) {
            self.repeats.pop();
        }
        self.next = target;
    }
}
