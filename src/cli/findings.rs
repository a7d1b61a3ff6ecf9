//! Diagnostics of a command: printed on standard error, and turned into the exit status.

use super::exit_code::ExitCode;
use super::{progress, verbosity};
pub(super) use crate::diagnostics::Diagnostics as Findings;
use ncfix_report::terminal::Colors;

impl Findings {
    /// Exit status of a run with these diagnostics.
    pub(super) fn exit_code(&self) -> ExitCode {
        if self.has_language_errors() {
            ExitCode::NotUnderstood
        } else if self.has_errors() {
            ExitCode::Refused
        } else {
            ExitCode::Done
        }
    }

    /// Prints the first diagnostics on standard error, errors before warnings.
    pub(super) fn draw(&self) {
        progress::end();
        super::say(&self.drawing(Colors::Ansi, !verbosity::is_quiet()));
    }
}
