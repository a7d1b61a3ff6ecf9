//! Exit statuses: what a script can rely on.

use ncfix_base::diagnostic::Diagnostic;

/// How a run ended. The order is that of weight: where several apply, [`ExitCode::of`] takes the first that matters.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ExitCode {
    /// Done; there may be warnings. Also when the reader of standard output went away.
    Done = 0,
    /// Two programs differ, and that was the question.
    Different = 1,
    /// Wrong usage: options that contradict each other, a file that cannot be read or written.
    Usage = 2,
    /// The program was not understood: a fault in its text, or something that is not supported yet. Nothing was written.
    NotUnderstood = 3,
    /// Understood but refused: any other finding with an E code. Nothing was written.
    Refused = 4,
    /// A link that cannot be opened or is gone.
    Link = 5,
    /// The control has refused a line, was reset or stands in an alarm.
    Control = 6,
    /// Sensors of temperature stayed bad, and the file says that the transfer ends then.
    Sensor = 7,
    /// A person stopped it.
    Interrupted = 130,
}

/// The statuses of every command, with what a script may take from them.
const OF_ALL: &[(ExitCode, &str)] = &[
    (ExitCode::Done, "done (there may be warnings)"),
    (ExitCode::Usage, "wrong usage, or a file that cannot be read or written"),
    (ExitCode::NotUnderstood, "the program was not understood; nothing was written"),
    (ExitCode::Refused, "refused, for any other error; nothing was written"),
];

/// The statuses of `ncfix diff`, whose results are statuses too.
const OF_DIFF: &[(ExitCode, &str)] = &[
    (ExitCode::Done, "the same, or nothing above --fail-above"),
    (ExitCode::Different, "different, with or without something that speaks against running it"),
    (ExitCode::Usage, "wrong usage, or a file that cannot be read"),
    (ExitCode::NotUnderstood, "a program was not understood"),
    (
        ExitCode::Refused,
        "with --fail-above, a change above it or something that is no correction; or the one program does not follow the other",
    ),
];

/// Those of commands that talk to a control.
const OF_LINK: &[(ExitCode, &str)] = &[
    (ExitCode::Link, "the link cannot be opened, or is gone"),
    (ExitCode::Control, "the control has refused a line, was reset or stands in an alarm"),
    (ExitCode::Sensor, "sensors of temperature stayed bad"),
];

/// Those of commands that run until somebody ends them.
const OF_LONG: &[(ExitCode, &str)] = &[(ExitCode::Interrupted, "stopped by a person")];

impl ExitCode {
    /// The statuses with which a command may end, and what each means, by weight.
    pub(super) fn of_command(name: &str) -> impl Iterator<Item = (ExitCode, &'static str)> {
        let talks = matches!(name, "feed" | "resume");
        let further = if talks { OF_LINK } else { &[] };
        let last = if talks || name == "realtime" { OF_LONG } else { &[] };
        let own = if name == "diff" { OF_DIFF } else { OF_ALL };
        own.iter().chain(further).chain(last).copied()
    }

    /// The status that follows from findings.
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
