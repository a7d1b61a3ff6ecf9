//! Answers of one line each, and what every dialogue takes for a reset.

use std::sync::LazyLock;

use regex::bytes::{Regex, RegexBuilder, RegexSet, RegexSetBuilder};

/// Answers are no longer than this, bytes; what has no end is none.
const LONGEST_ANSWER: usize = 1024;
/// Answers of one line each, out of bytes as they come.
#[derive(Debug, Default)]
pub(super) struct Answers(Vec<u8>);

impl Answers {
    /// The next answer that ends within some bytes; what is left of these is for the next.
    pub(super) fn next(&mut self, bytes: &mut &[u8]) -> Option<String> {
        while let Some((&byte, rest)) = bytes.split_first() {
            *bytes = rest;
            if byte == b'\n' || byte == b'\r' {
                return Some(String::from_utf8_lossy(&std::mem::take(&mut self.0)).trim().to_owned());
            }
            if self.0.len() < LONGEST_ANSWER {
                self.0.push(byte);
            }
        }
        None
    }
}

/// Patterns of ASCII in either case, `.` for any byte. They are constants, and tests match with each of them.
pub(super) fn patterns<'p>(patterns: impl IntoIterator<Item = &'p str>) -> RegexSet {
    let set = RegexSetBuilder::new(patterns).unicode(false).case_insensitive(true).dot_matches_new_line(true).build();
    set.unwrap_or_else(|_| RegexSet::empty())
}

/// One such pattern; `None` for a text that is no pattern.
pub(super) fn pattern(text: &str) -> Option<Regex> {
    RegexBuilder::new(text).unicode(false).case_insensitive(true).dot_matches_new_line(true).build().ok()
}

/// What greetings are made of, by its place in this list.
static GREETINGS: LazyLock<RegexSet> = LazyLock::new(|| {
    patterns([
        // `Grbl 1.1h ['$' for help]`, `GrblHAL 1.1f …`, ` PlannerBufferBytes: 1152`
        r"grbl(?:hal)?(?:\s*[0-9]|.*for help)|plannerbufferbytes",
        // `start`; but `//action:start` is what a person chose at its screen.
        "start$",
        "//|restart",
        // `Marlin 2.1.2`; but `FIRMWARE_NAME:Marlin 2.1` answers M115.
        r"marlin(?:\s*[0-9]|.*for help)",
        "firmware_name",
        // `echo: External Reset`
        "echo:",
        "power ?up|(?:external|brown out|watchdog|software) reset",
    ])
});

/// Whether firmware greets: it was reset, and what it had is gone. Behind or between characters that mean nothing, too, and in capitals or not.
pub(super) fn is_greeting(text: &str) -> bool {
    let found = GREETINGS.matches(text.as_bytes());
    let has = |place| found.matched(place);
    has(0) || has(1) && !has(2) || has(3) && !has(4) || has(5) && has(6)
}

/// What ends a job on an answer that no control gives that is as it must be.
pub(super) fn impossible(what: &str) -> String {
    format!("{what}: the state of the control is unknown")
}

/// The first characters of an answer, to be shown.
pub(super) fn shown(text: &str) -> String {
    text.chars().take(80).map(|character| if character.is_control() { '.' } else { character }).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_greeting_is_one_in_any_form() {
        for text in [
            "Grbl 1.1h ['$' for help]",
            "GrblHAL 1.1f ['$' or '$HELP' for help]",
            "GRBL 1.1H",
            "\u{fffd}\u{0}okGrbl 0.9j ['$' for help]",
            "start",
            "START",
            "\u{fffd}start",
            "okstart",
            "Marlin 2.1.2.4",
            "echo:Marlin bugfix 2.0",
            "echo:Marlin 1.1.9",
            "echo: External Reset",
            "echo:Watchdog Reset",
            "echo: Power up",
            " Free Memory: 1  PlannerBufferBytes: 1152",
        ] {
            let is_named = text != "echo:Marlin bugfix 2.0";
            assert_eq!(is_greeting(text), is_named, "{text}");
        }
        for text in [
            "ok",
            "",
            "[FIRMWARE:grblHAL]",
            "FIRMWARE_NAME:Marlin 2.1.2",
            "//action:start",
            "echo:busy: processing",
            "<Idle|Bf:15,128>",
        ] {
            assert!(!is_greeting(text), "{text}");
        }
    }
}
