//! One line on the terminal that says how far a long run is. Nothing where standard error is no terminal.

use std::io::{IsTerminal as _, Write as _};
use std::time::{Duration, Instant};

use crate::report::number::grouped;

/// A run shorter than this shows nothing.
const SILENT: Duration = Duration::from_secs(1);

/// Time between two lines: fast enough to look alive.
const REFRESH: Duration = Duration::from_millis(200);

/// Notes between two looks at the clock: a look at every block would cost more than the block.
const NOTES_PER_LOOK: u32 = 4096;

/// The line.
pub(super) struct Progress {
    is_wanted: bool,
    is_shown: bool,
    notes: u32,
    offset: u32,
    next: Instant,
}

impl Progress {
    /// A line that is not shown yet.
    pub(super) fn new() -> Progress {
        let is_wanted = std::io::stderr().is_terminal();
        Progress { is_wanted, is_shown: false, notes: 0, offset: 0, next: Instant::now() + SILENT }
    }

    /// One that never shows.
    pub(super) fn hidden() -> Progress {
        Progress { is_wanted: false, ..Progress::new() }
    }

    /// Notes that `blocks` were executed and that the current one starts at byte `offset` of the `length` of the main program;
    /// without an offset it is in a subprogram.
    pub(super) fn note(&mut self, blocks: u64, offset: Option<u32>, length: usize) {
        // A loop goes back in the program; the line does not.
        self.offset = self.offset.max(offset.unwrap_or(0));
        self.notes = self.notes.wrapping_add(1);
        if self.is_wanted && self.notes.is_multiple_of(NOTES_PER_LOOK) && Instant::now() >= self.next {
            self.next = Instant::now() + REFRESH;
            self.is_shown = true;
            let percent = 100.0 * f64::from(self.offset) / length.max(1) as f64;
            let _ = write!(std::io::stderr(), "\r{} blocks, {percent:.0} % of the source \u{1b}[K", grouped(blocks));
        }
    }

    /// Notes that a share (0 … 1) of `what` is done.
    pub(super) fn share(&mut self, what: &str, share: f64) {
        // The clock is cheap beside what callers do between two notes.
        if self.is_wanted && Instant::now() >= self.next {
            self.next = Instant::now() + REFRESH;
            self.is_shown = true;
            let _ = write!(std::io::stderr(), "\r{what}: {:.0} % \u{1b}[K", 100.0 * share);
        }
    }

    /// Takes the line away before anything else is printed.
    pub(super) fn clear(&mut self) {
        if std::mem::take(&mut self.is_shown) {
            let _ = write!(std::io::stderr(), "\r\u{1b}[K");
        }
    }
}

impl Drop for Progress {
    fn drop(&mut self) {
        self.clear();
    }
}
