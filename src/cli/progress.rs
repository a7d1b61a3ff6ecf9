//! One line on the terminal that says how far a long run is. Nothing where standard error is no terminal, or with `--quiet`.
//!
//! There is one such line for the process: a command that knows how far it is writes its share ([`Progress`]), a command that does not,
//! or a part of it, shows the time that it has taken ([`begin`]). Whatever else is printed takes the line away first ([`end`]). Own code: `indicatif` draws bars
//! of a length that is known, and a line that comes only after half a second would need this clock and lock beside it.

use std::io::{IsTerminal as _, Write as _};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use super::voice;
use crate::run::Watch;
use ncfix_report::number::grouped;

/// A run shorter than this shows nothing.
const SILENT: Duration = Duration::from_millis(500);

/// Time between two lines: fast enough to look alive.
const REFRESH: Duration = Duration::from_millis(200);

/// A share stands so long before the time takes its place.
const SHARES_LAST: Duration = Duration::from_secs(2);

/// Notes between two looks at the clock: a look at every block would cost more than the block.
const NOTES_PER_LOOK: u32 = 4096;

/// What stands on the terminal.
struct Line {
    is_shown: bool,
    /// When a share was shown last: while shares come, the time is not shown.
    shared: Option<Instant>,
    /// Since when the command is at work, until its results are printed.
    at_work: Option<Instant>,
}

static LINE: Mutex<Line> = Mutex::new(Line { is_shown: false, shared: None, at_work: None });

impl Line {
    /// The line; a thread that died while it wrote leaves nothing that matters.
    fn lock() -> MutexGuard<'static, Line> {
        LINE.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn draw(&mut self, text: &str) {
        self.is_shown = true;
        let _ = write!(std::io::stderr(), "\r{text} \u{1b}[K");
    }

    /// Shows the time that a command has taken; whether it is still at work.
    fn tick(&mut self, name: &str, started: Instant) -> bool {
        let is_at_work = self.at_work == Some(started);
        if is_at_work && self.shared.is_none_or(|shared| shared.elapsed() > SHARES_LAST) {
            self.draw(&format!("{name}: {:.1} s", started.elapsed().as_secs_f64()));
        }
        is_at_work
    }

    fn clear(&mut self) {
        if std::mem::take(&mut self.is_shown) {
            let _ = write!(std::io::stderr(), "\r\u{1b}[K");
        }
    }
}

/// Whether anybody sees the line.
fn is_wanted() -> bool {
    !voice::is_quiet() && std::io::stderr().is_terminal()
}

/// Takes the line away before anything else is printed.
pub(super) fn clear() {
    Line::lock().clear();
}

/// How far a run is.
pub(super) struct Progress {
    is_wanted: bool,
    notes: u32,
    offset: u32,
    next: Instant,
}

impl Progress {
    /// One that is not shown yet.
    pub(super) fn new() -> Progress {
        Progress { is_wanted: is_wanted(), notes: 0, offset: 0, next: Instant::now() + SILENT }
    }

    /// Notes that `blocks` were executed and that the current one starts at byte `offset` of the `length` of the main program;
    /// without an offset it is in a subprogram.
    pub(super) fn note(&mut self, blocks: u64, offset: Option<u32>, length: usize) {
        // A loop goes back in the program; the line does not.
        self.offset = self.offset.max(offset.unwrap_or(0));
        self.notes = self.notes.wrapping_add(1);
        if self.is_wanted && self.notes.is_multiple_of(NOTES_PER_LOOK) && Instant::now() >= self.next {
            let percent = 100.0 * f64::from(self.offset) / length.max(1) as f64;
            self.draw(&format!("{} blocks, {percent:.0} % of the source", grouped(blocks)));
        }
    }

    /// Notes that a share (0 … 1) of `what` is done.
    pub(super) fn share(&mut self, what: &str, share: f64) {
        // The clock is cheap beside what callers do between two notes.
        if self.is_wanted && Instant::now() >= self.next {
            self.draw(&format!("{what}: {:.0} %", 100.0 * share));
        }
    }

    fn draw(&mut self, text: &str) {
        let now = Instant::now();
        self.next = now + REFRESH;
        let mut line = Line::lock();
        line.shared = Some(now);
        line.draw(text);
    }

    /// Takes the line away.
    pub(super) fn clear(&mut self) {
        if self.is_wanted {
            clear();
        }
    }
}

impl Watch for Progress {
    fn note(&mut self, blocks: u64, offset: Option<u32>, length: usize) {
        Progress::note(self, blocks, offset, length);
    }

    // Whatever is printed behind the end shall not stand behind the progress line.
    fn end(&mut self) {
        self.clear();
    }
}

/// Shows how far a program is.
pub(super) fn watch() -> Box<dyn Watch> {
    Box::new(Progress::new())
}

impl Drop for Progress {
    fn drop(&mut self) {
        self.clear();
    }
}

/// Shows how long a command has been at work wherever it does not say how far it is, until the first result is printed ([`end`]): a
/// thread of its own, which looks at the clock five times a second.
pub(super) fn begin(name: &'static str) {
    if !is_wanted() {
        return;
    }
    let started = Instant::now();
    Line::lock().at_work = Some(started);
    let ticker = std::thread::Builder::new().name("progress".into()).spawn(move || {
        std::thread::sleep(SILENT);
        while Line::lock().tick(name, started) {
            std::thread::sleep(REFRESH);
        }
    });
    // Where there is no thread to be had the run goes on without the line.
    drop(ticker);
}

/// Takes the line away for good: results are about to be printed.
pub(super) fn end() {
    let mut line = Line::lock();
    line.at_work = None;
    line.clear();
}
