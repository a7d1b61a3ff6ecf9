//! Exit statuses.

use ncfix_base::diagnostic::Diagnostic;

/// Result of a run. If several apply, [`ExitCode::of`] takes the weightiest.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ExitCode {
    /// Done; there may be warnings. Also when the reader of standard output went away.
    Done = 0,
    /// Two programs differ, as asked by the command; a correction with a review is written and should not run; or an import wrote all but files that it could
    /// not read.
    Different = 1,
    /// Usage error: contradicting options, or a file that cannot be read or written.
    Usage = 2,
    /// The program was not understood: an error in its text, or a feature that is not supported yet. Nothing was written.
    NotUnderstood = 3,
    /// Understood but refused: any other E code. Nothing was written.
    Refused = 4,
    /// The link cannot be opened or was lost.
    Link = 5,
    /// The control refused a line, was reset, is in an alarm state, reports another position, or does not answer.
    Control = 6,
    /// Temperature sensors were bad before the start, or remained bad and their file ends the transfer in that case.
    Sensor = 7,
    /// Stopped by the user.
    Interrupted = 130,
}

/// Meaning of status 3.
const NOT_UNDERSTOOD: &str = "the program, or control data given with --setup, has a syntax error or a statement that ncfix cannot execute; no result file was written";
/// Meaning of status 3 of commands that read no program.
const BAD_SETUP: &str = "control data given with --setup has a syntax error or a statement that ncfix cannot execute; no result file was written";
/// Meaning of status 3 of commands that write no program.
const NOT_COMPARED: &str =
    "a program, or control data given with --setup, has a syntax error or a statement that ncfix cannot execute";

const SUCCESS: (ExitCode, &str) = (ExitCode::Done, "success (possibly with warnings)");
const USAGE: (ExitCode, &str) = (ExitCode::Usage, "usage error, or a file cannot be read or written");
const REFUSED: (ExitCode, &str) = (ExitCode::Refused, "refused because of another error; no result file was written");

/// Exit statuses of most commands, with their meaning for a script.
const OF_ALL: &[(ExitCode, &str)] = &[SUCCESS, USAGE, (ExitCode::NotUnderstood, NOT_UNDERSTOOD), REFUSED];

/// Exit statuses of commands that read no program, and no control data.
const OF_DATA: &[(ExitCode, &str)] = &[SUCCESS, USAGE, REFUSED];

/// Exit statuses of commands that read no program.
const OF_READINGS: &[(ExitCode, &str)] = &[SUCCESS, USAGE, (ExitCode::NotUnderstood, BAD_SETUP), REFUSED];

/// Exit statuses of `ncfix fix`.
const OF_FIX: &[(ExitCode, &str)] = &[
    SUCCESS,
    (ExitCode::Different, "with --review: written, but the verdict is that the corrected program should not run"),
    USAGE,
    (ExitCode::NotUnderstood, NOT_UNDERSTOOD),
    REFUSED,
];

/// Exit statuses of `ncfix import`, which may write a part of a folder.
const OF_IMPORT: &[(ExitCode, &str)] = &[
    SUCCESS,
    (ExitCode::Different, "a file of a folder, which may have readings, was not read; the others are written"),
    USAGE,
    (ExitCode::NotUnderstood, BAD_SETUP),
    REFUSED,
];

/// Exit statuses of commands that read neither a program nor a machine file.
const OF_TEXTS: &[(ExitCode, &str)] =
    &[(ExitCode::Done, "success"), (ExitCode::Usage, "usage error, or a file cannot be read or written")];

/// Exit statuses of `ncfix verify`.
const OF_VERIFY: &[(ExitCode, &str)] = &[
    (ExitCode::Done, "nothing against running the corrected program, or warnings that a person should read"),
    (ExitCode::Usage, "usage error, or a file cannot be read"),
    (ExitCode::NotUnderstood, NOT_COMPARED),
    (ExitCode::Refused, "the corrected program should not run"),
];

/// Exit statuses of `ncfix diff`, whose results are statuses too.
const OF_DIFF: &[(ExitCode, &str)] = &[
    (ExitCode::Done, "no difference, or none above --fail-above"),
    (ExitCode::Different, "the programs differ, as after each correction; this is not the verdict"),
    (ExitCode::Usage, "usage error, or a file cannot be read"),
    (ExitCode::NotUnderstood, NOT_COMPARED),
    (
        ExitCode::Refused,
        "with --fail-above: a change above it, or one that is not a correction; or the corrected program does not follow the original",
    ),
];

/// Additional statuses of commands that talk to a control.
const OF_LINK: &[(ExitCode, &str)] = &[
    (ExitCode::Link, "the link cannot be opened or was lost"),
    (
        ExitCode::Control,
        "the control refused a line, was reset, is in an alarm state, reports another position than the lines command, or does not answer",
    ),
    (ExitCode::Sensor, "sensors were bad before the start, or remained bad and `action` ends the transfer"),
];

/// Additional status of commands that run until they are stopped.
const OF_LONG: &[(ExitCode, &str)] = &[(ExitCode::Interrupted, "stopped by the user")];

impl ExitCode {
    /// Exit statuses of a command with their meanings.
    pub(super) fn of_command(name: &str) -> impl Iterator<Item = (ExitCode, &'static str)> {
        let (own, further) = match name {
            "diff" => (OF_DIFF, None),
            "fix" => (OF_FIX, None),
            "verify" => (OF_VERIFY, None),
            "explain" | "completions" | "man" => (OF_TEXTS, None),
            "calibrate" => (OF_DATA, None),
            "import" => (OF_IMPORT, None),
            "diagnose" | "iso230" | "simulate" | "square" => (OF_READINGS, None),
            "feed" | "resume" => (OF_ALL, Some((OF_LINK, OF_LONG))),
            "realtime" => (OF_ALL, Some((&[][..], OF_LONG))),
            _ => (OF_ALL, None),
        };
        let (further, last) = further.unwrap_or_default();
        own.iter().chain(further).chain(last).copied()
    }

    /// Exit status of a run with these diagnostics.
    pub fn of<'a>(diagnostics: impl IntoIterator<Item = &'a Diagnostic>) -> ExitCode {
        diagnostics.into_iter().filter(|diagnostic| diagnostic.is_error()).fold(ExitCode::Done, |code, diagnostic| {
            if diagnostic.code.is_language() || code == ExitCode::NotUnderstood {
                ExitCode::NotUnderstood
            } else {
                ExitCode::Refused
            }
        })
    }
}

impl From<ExitCode> for std::process::ExitCode {
    fn from(code: ExitCode) -> Self {
        std::process::ExitCode::from(code as u8)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use ncfix_base::diagnostic::Code;

    #[test]
    fn a_program_not_understood_weighs_most() {
        let found = |code| Diagnostic::nowhere(code, "", "");
        assert_eq!(ExitCode::of(&[]), ExitCode::Done);
        assert_eq!(ExitCode::of(&[found(Code::NO_MACHINE)]), ExitCode::Done);
        assert_eq!(ExitCode::of(&[found(Code::NO_MACHINE), found(Code::NO_TOOL)]), ExitCode::Refused);
        assert_eq!(ExitCode::of(&[found(Code::NOT_SUPPORTED), found(Code::NO_TOOL)]), ExitCode::NotUnderstood);
        assert_eq!(ExitCode::of(&[found(Code::NO_TOOL), found(Code::UNEXPECTED)]), ExitCode::NotUnderstood);
    }
}
