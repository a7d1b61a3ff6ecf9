//! Splits bytes into one-line answers, and recognizes greetings, which every dialogue treats as a reset.

use std::sync::LazyLock;

use ncfix_base::pattern::{RegexSet, patterns};

/// Longest answer, bytes; the rest of a longer one is dropped.
const LONGEST_ANSWER: usize = 1024;
/// Collects one-line answers from bytes as they arrive.
#[derive(Debug, Default)]
pub(super) struct Answers(Vec<u8>);

impl Answers {
    /// Returns the next answer that ends within these bytes. The bytes after it stay for the next call.
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

/// Parts of greetings, addressed by their position in this list.
static GREETINGS: LazyLock<RegexSet> = LazyLock::new(|| {
    patterns([
        // `Grbl 1.1h ['$' for help]`, `GrblHAL 1.1f …`, ` PlannerBufferBytes: 1152`
        r"grbl(?:hal)?(?:\s*[0-9]|.*for help)|plannerbufferbytes",
        // `start`; but `//action:start` means that a person has started something at the screen.
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

/// True if the text is a greeting of the firmware: it was reset and has lost its state. Case, and meaningless characters around or inside, do not matter.
pub(super) fn is_greeting(text: &str) -> bool {
    let found = GREETINGS.matches(text.as_bytes());
    let has = |place| found.matched(place);
    has(0) || has(1) && !has(2) || has(3) && !has(4) || has(5) && has(6)
}

/// Returns the reason that ends a job after an answer that a correct control never gives.
pub(super) fn impossible(what: &str) -> String {
    format!("{what}: the state of the control is unknown")
}

/// Writes a count with its noun: `1 line`, `5 lines`.
pub(super) fn counted(count: usize, noun: &str) -> String {
    format!("{count} {noun}{}", if count == 1 { "" } else { "s" })
}

/// Returns the first 80 characters of an answer for display; control characters become dots.
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
