//! One progress line on the terminal for long runs.
//!
//! The process has one such line: a command that knows its progress shows the fraction done ([`Progress`]), any other shows the elapsed
//! time ([`begin`]). All other output removes the line first ([`end`]). The caller decides with [`allow`] if there is a line at all. Own code: `indicatif` draws bars of a known length, and a line that
//! appears only after half a second would need this clock and lock as well.

use std::io::Write as _;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use crate::number::grouped;

/// Shorter runs show nothing.
const SILENT: Duration = Duration::from_millis(500);

/// Time between two updates.
const REFRESH: Duration = Duration::from_millis(200);

/// Time after which the elapsed time replaces a fraction.
const SHARES_LAST: Duration = Duration::from_secs(2);

/// Notes between two readings of the clock: one per block would cost more than the block.
const NOTES_PER_LOOK: u32 = 4096;

/// State of the line on the terminal.
struct Line {
    is_shown: bool,
    /// Time of the last fraction shown: while fractions are shown, the elapsed time is not.
    shared: Option<Instant>,
    /// Start of the work of the command, until its results are printed.
    at_work: Option<Instant>,
}

static LINE: Mutex<Line> = Mutex::new(Line { is_shown: false, shared: None, at_work: None });

impl Line {
    /// The line; a thread that panicked while writing does no harm.
    fn lock() -> MutexGuard<'static, Line> {
        LINE.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn draw(&mut self, text: &str) {
        self.is_shown = true;
        let _ = write!(std::io::stderr(), "\r{text} \u{1b}[K");
    }

    /// Shows the elapsed time of a command; true if it is still at work.
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

/// True if the line is shown to a user.
static IS_ALLOWED: AtomicBool = AtomicBool::new(false);

/// Allows the line: standard error is a terminal, and the user did not ask for silence.
pub fn allow(is_allowed: bool) {
    IS_ALLOWED.store(is_allowed, Ordering::Relaxed);
}

fn is_wanted() -> bool {
    IS_ALLOWED.load(Ordering::Relaxed)
}

/// Removes the line before other output.
pub fn clear() {
    Line::lock().clear();
}

/// Progress of a run.
#[derive(Debug)]
pub struct Progress {
    is_wanted: bool,
    notes: u32,
    offset: u32,
    next: Instant,
}

impl Progress {
    /// A progress that is not shown yet.
    #[must_use]
    pub fn new() -> Progress {
        Progress { is_wanted: is_wanted(), notes: 0, offset: 0, next: Instant::now() + SILENT }
    }

    /// Notes that `blocks` were executed and that the current one starts at byte `offset` of the `length` of the main program;
    /// it is in a subprogram if there is no offset.
    pub fn note(&mut self, blocks: u64, offset: Option<u32>, length: usize) {
        // A loop goes back in the program; the line does not.
        self.offset = self.offset.max(offset.unwrap_or(0));
        self.notes = self.notes.wrapping_add(1);
        if self.is_wanted && self.notes.is_multiple_of(NOTES_PER_LOOK) && Instant::now() >= self.next {
            let percent = 100.0 * f64::from(self.offset) / length.max(1) as f64;
            self.draw(&format!("{} blocks, {percent:.0} % of the original", grouped(blocks)));
        }
    }

    /// Notes that a fraction (0 … 1) of `what` is done.
    pub fn share(&mut self, what: &str, share: f64) {
        // The clock is cheap compared with the work of callers between two notes.
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

    /// Removes the line.
    pub fn clear(&mut self) {
        if self.is_wanted {
            clear();
        }
    }
}

impl Default for Progress {
    fn default() -> Progress {
        Progress::new()
    }
}

impl Drop for Progress {
    fn drop(&mut self) {
        self.clear();
    }
}

/// Shows the elapsed time of a command that does not report its progress, until the first result is printed ([`end`]): a separate thread
/// reads the clock five times a second.
pub fn begin(name: &'static str) {
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
    // If no thread can be started, the run continues without the line.
    drop(ticker);
}

/// Removes the line permanently before results are printed.
pub fn end() {
    let mut line = Line::lock();
    line.at_work = None;
    line.clear();
}
