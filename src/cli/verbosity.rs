//! Verbosity on standard error, and the notes of `--verbose`.
//!
//! All commands share it, as they share standard error; what goes to standard output does not depend on it.

use std::collections::BTreeSet;
use std::sync::atomic::{AtomicU8, Ordering};
use std::sync::{Mutex, PoisonError};

/// Verbosity.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) enum Verbosity {
    /// `--quiet`: errors only.
    Quiet,
    /// Diagnostics, tables and sentences about the results.
    #[default]
    Usual,
    /// `--verbose`: also notes on the files read and the choices made.
    Verbose,
}

/// Verbosity of this process.
static CHOSEN: AtomicU8 = AtomicU8::new(Verbosity::Usual as u8);

/// Sets the verbosity.
pub(super) fn choose(voice: Verbosity) {
    CHOSEN.store(voice as u8, Ordering::Relaxed);
    // A second run in one process has the same logger.
    let _ = log::set_logger(&Notes);
    log::set_max_level(match voice {
        Verbosity::Quiet => log::LevelFilter::Off,
        Verbosity::Usual => log::LevelFilter::Warn,
        Verbosity::Verbose => log::LevelFilter::Info,
    });
}

/// True if only errors are printed.
pub(super) fn is_quiet() -> bool {
    CHOSEN.load(Ordering::Relaxed) == Verbosity::Quiet as u8
}

/// Notes already printed: a file that is read again is not reported twice.
static SAID: Mutex<BTreeSet<String>> = Mutex::new(BTreeSet::new());

/// Prints the log of the library, not that of its dependencies.
struct Notes;

impl log::Log for Notes {
    fn enabled(&self, of: &log::Metadata<'_>) -> bool {
        of.level() <= log::Level::Info && of.target().starts_with("ncfix")
    }

    fn log(&self, record: &log::Record<'_>) {
        if self.enabled(record.metadata()) {
            let text = record.args().to_string();
            let line = format!("note: {}\n", ncfix_base::source::shown(&text));
            if SAID.lock().unwrap_or_else(PoisonError::into_inner).insert(text) {
                super::say(&line);
            }
        }
    }

    fn flush(&self) {}
}

/// Version and build.
pub(super) fn version() -> String {
    let features = [
        ("modbus", cfg!(feature = "modbus")),
        ("mqtt", cfg!(feature = "mqtt")),
        ("mtconnect", cfg!(feature = "mtconnect")),
        ("opcua", cfg!(feature = "opcua")),
    ];
    let built_in: Vec<&str> = features.into_iter().filter(|(_, is_in)| *is_in).map(|(name, _)| name).collect();
    let profile = if cfg!(debug_assertions) { "debug" } else { "release" };
    format!(
        "ncfix {}, {profile} build for {} on {}, features: {}",
        env!("CARGO_PKG_VERSION"),
        std::env::consts::OS,
        std::env::consts::ARCH,
        if built_in.is_empty() { "none".to_owned() } else { built_in.join(", ") }
    )
}
