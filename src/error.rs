//! Errors of the library: a message, with diagnostics if a text, a machine file or data are wrong.

use std::fmt;
use std::io;
use std::path::Path;

use crate::diagnostics::{Diagnostics, Located};
use ncfix_base::diagnostic::{Code, Diagnostic};

/// The reason why a function of the library has no result.
///
/// It displays as one line for each diagnostic: `part.mpf:2:4: error[E0302]: …`.
///
/// ```
/// use ncfix::prelude::*;
///
/// let error = Program::parse("part.mpf", "N10 G1 X=(\n", DialectChoice::Sinumerik).unwrap_err();
/// let first = error.diagnostics().iter().next().unwrap();
/// assert_eq!((first.file(), first.line()), (Some("part.mpf"), Some(1)));
/// assert!(error.code().unwrap().as_str().starts_with("E01"));
/// assert!(!first.help().is_empty());
/// ```
#[derive(Clone, Debug)]
pub struct Error {
    message: String,
    diagnostics: Box<Diagnostics>,
    /// True if the only cause is that the reader of standard output closed it.
    is_reader_gone: bool,
}

impl Error {
    /// An error in arguments or files, as a sentence.
    pub(crate) fn usage(message: String) -> Error {
        Error { message, diagnostics: Box::default(), is_reader_gone: false }
    }

    /// A file that cannot be read or written: `cannot read part.mpf: there is no such file or folder`.
    pub(crate) fn file(doing: &str, path: &Path, error: &io::Error) -> Error {
        Error::usage(format!("cannot {doing} {}: {}", path.display(), reason(error)))
    }

    /// A text that cannot be written.
    pub(crate) fn sink(error: &io::Error) -> Error {
        Error::usage(format!("the text cannot be written: {}", reason(error)))
    }

    /// Diagnostics, at least one of which is an error.
    pub(crate) fn found(diagnostics: Diagnostics) -> Error {
        let message = diagnostics.errors().next().map_or_else(String::new, |first| first.to_string());
        Error { message, diagnostics: Box::new(diagnostics), is_reader_gone: false }
    }

    /// One diagnostic without a position.
    pub(crate) fn one(diagnostic: Diagnostic) -> Error {
        let mut diagnostics = Diagnostics::default();
        diagnostics.add(diagnostic, &[]);
        Error::found(diagnostics)
    }

    /// Standard output that cannot be written.
    pub(crate) fn output(error: &io::Error) -> Error {
        let is_reader_gone = error.kind() == io::ErrorKind::BrokenPipe;
        Error { is_reader_gone, ..Error::usage(format!("cannot write to standard output: {error}")) }
    }

    /// True if the only cause is that the reader of standard output closed it.
    pub(crate) fn is_reader_gone(&self) -> bool {
        self.is_reader_gone
    }

    /// One sentence: the file that cannot be read, the failed operation, or the first diagnostic that is an error.
    ///
    /// ```
    /// # use ncfix::prelude::*;
    /// let error = Machine::from_file("none.toml").unwrap_err();
    /// assert_eq!(error.message(), "cannot read none.toml: there is no such file or folder");
    /// ```
    #[must_use]
    pub fn message(&self) -> &str {
        &self.message
    }

    /// The code of the first diagnostic that is an error; `None` if a file cannot be read or an argument is wrong.
    ///
    /// ```
    /// # use ncfix::prelude::*;
    /// let error = Program::parse("part.mpf", "N10 G1 X=(\n", DialectChoice::Sinumerik).unwrap_err();
    /// assert!(error.code().unwrap().as_str().starts_with("E01"));
    /// assert!(Machine::from_file("none.toml").unwrap_err().code().is_none());
    /// ```
    #[must_use]
    pub fn code(&self) -> Option<Code> {
        self.diagnostics.errors().next().map(|one| one.code())
    }

    /// The diagnostics, including warnings; empty if a file cannot be read or an argument is wrong.
    ///
    /// ```
    /// # use ncfix::prelude::*;
    /// let error = Program::parse("part.mpf", "N10 G1 X=(\n", DialectChoice::Sinumerik).unwrap_err();
    /// assert!(error.diagnostics().drawn().contains("1 | N10 G1 X=("));
    /// ```
    #[must_use]
    pub fn diagnostics(&self) -> &Diagnostics {
        &self.diagnostics
    }
}

impl fmt::Display for Error {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.diagnostics.is_empty() {
            return out.write_str(&self.message);
        }
        let lines: Vec<String> = self.diagnostics.errors().map(|one: Located<'_>| one.to_string()).collect();
        out.write_str(&lines.join("\n"))
    }
}

impl std::error::Error for Error {}

impl From<String> for Error {
    /// The sentence for a value that cannot be parsed.
    fn from(sentence: String) -> Error {
        Error::usage(sentence)
    }
}

/// The reason why a file cannot be read or written, as text.
pub(crate) fn reason(error: &io::Error) -> String {
    match error.kind() {
        io::ErrorKind::NotFound => "there is no such file or folder".into(),
        io::ErrorKind::PermissionDenied => "permission denied".into(),
        io::ErrorKind::IsADirectory => "it is a folder".into(),
        _ => error.to_string(),
    }
}
