//! Early end of a command, other than by diagnostics.

use std::fmt;
use std::io;
use std::path::Path;

use super::exit_code::ExitCode;
use crate::error::Error;
use ncfix_base::diagnostic::Diagnostic;

/// Ends a command at once.
#[derive(Debug)]
pub(super) enum Stop {
    /// The reader of standard output went away; this is not an error.
    ReaderGone,
    /// A sentence for the user; exit status 2.
    Usage(String),
    /// A sentence for the user; the exit status is given.
    Ended(ExitCode, String),
    /// A diagnostic that is found only at the end.
    Found(Box<Diagnostic>),
}

impl Stop {
    /// A file that cannot be read or written: `cannot read part.mpf: no such file`.
    pub(super) fn file(doing: &str, path: &Path, error: &io::Error) -> Stop {
        Error::file(doing, path, error).into()
    }

    /// Standard output that cannot be written.
    pub(super) fn output(error: &io::Error) -> Stop {
        Error::output(error).into()
    }
}

impl From<Error> for Stop {
    fn from(error: Error) -> Stop {
        match error.diagnostics().first() {
            _ if error.is_reader_gone() => Stop::ReaderGone,
            Some(found) => Stop::Found(Box::new(found.clone())),
            None => Stop::Usage(error.message().to_owned()),
        }
    }
}

impl fmt::Display for Stop {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Stop::ReaderGone => f.write_str("the reader of standard output was closed"),
            Stop::Usage(sentence) | Stop::Ended(_, sentence) => f.write_str(sentence),
            Stop::Found(diagnostic) => f.write_str(&diagnostic.message),
        }
    }
}
