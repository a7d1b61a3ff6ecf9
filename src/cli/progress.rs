//! The progress line of this process: none with `--quiet` or if standard error is not a terminal.

use std::io::IsTerminal as _;

use super::verbosity;
use crate::run::Watch;
pub(super) use ncfix_report::progress::{Progress, begin, clear, end};

/// Allows the line if a user can see it.
pub(super) fn allow() {
    ncfix_report::progress::allow(!verbosity::is_quiet() && std::io::stderr().is_terminal());
}

impl Watch for Progress {
    fn note(&mut self, blocks: u64, offset: Option<u32>, length: usize) {
        Progress::note(self, blocks, offset, length);
    }

    // Output after the end must not follow the progress line.
    fn end(&mut self) {
        self.clear();
    }
}

/// Shows the progress through a program.
pub(super) fn watch() -> Box<dyn Watch> {
    Box::new(Progress::new())
}
