//! Answers of one line each, and what every dialogue takes for a reset.

/// Answers are no longer than this, bytes; what has no end is none.
const LONGEST_ANSWER: usize = 1024;
/// What firmware says of why it starts.
const CAUSES: &[&str] =
    &["power up", "powerup", "external reset", "brown out reset", "watchdog reset", "software reset"];

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

/// Whether firmware greets: it was reset, and what it had is gone. Behind or between characters that mean nothing, too, and in capitals or not.
///
/// Known are `Grbl 1.1h ['$' for help]`, `GrblHAL 1.1f …`, and of Marlin `start`, `Marlin 2.1.2`, `echo: External Reset`, ` PlannerBufferBytes: 1152`.
pub(super) fn is_greeting(text: &str) -> bool {
    let text = text.to_ascii_lowercase();
    let has_version = |name: &str| {
        text.match_indices(name).any(|(at, name)| {
            let behind = text.get(at + name.len()..).unwrap_or_default().trim_start();
            behind.starts_with(|character: char| character.is_ascii_digit()) || behind.contains("for help")
        })
    };
    // `FIRMWARE_NAME:Marlin 2.1` answers M115; `//action:start` is what a person chose at its screen.
    let is_start = text.ends_with("start") && !text.contains("//") && !text.contains("restart");
    let is_marlin = has_version("marlin") && !text.contains("firmware_name");
    let is_cause = text.contains("echo:") && CAUSES.iter().any(|cause| text.contains(cause));
    has_version("grbl")
        || has_version("grblhal")
        || is_start
        || is_marlin
        || is_cause
        || text.contains("plannerbufferbytes")
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
