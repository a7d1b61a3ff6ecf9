//! Program levels: which program runs, and where it is.

/// A program that runs.
#[derive(Debug)]
pub(super) struct Level {
    pub(super) program: usize,
    /// Its part of the file.
    pub(super) part: usize,
    /// The block to execute next.
    pub(super) next: usize,
    /// The call chain that led here.
    pub(super) calls: u32,
}

impl Level {
    pub(super) fn new(program: usize, part: usize, next: usize, calls: u32) -> Self {
        Level { program, part, next, calls }
    }
}
