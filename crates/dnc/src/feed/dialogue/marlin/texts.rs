//! Marlin: known unsolicited texts and their meaning.
//!
//! Firmware of this family continues after many texts which mean that a line was not executed, or not as written. So only texts that are known to be
//! harmless count as harmless. Any other text may have had that meaning.

use std::sync::LazyLock;

use ncfix_base::pattern::{RegexSet, patterns};

/// Meaning of a text that is not an answer to a line.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum MarlinText {
    /// Does not concern the motion.
    Harmless,
    /// The firmware asks the sender to pause (`true`) or to resume.
    Pause(bool),
    /// The job ends, for this reason.
    Ends(&'static str),
    /// Meaning not known.
    Unknown,
}

/// Patterns of texts and their meaning; the first match counts.
const TEXTS: &[(&str, MarlinText)] = &[
    (r"^(?:!!$|error$|error:)", MarlinText::Ends("the control has halted")),
    // `Home X First`, in older versions `Home X/Y before Z`; the settings printed at startup contain `Home offset`.
    ("home.*(?:first|before)|(?:first|before).*home", MarlinText::Ends("an axis is not homed, so moves are skipped")),
    // Nothing may follow these texts.
    ("endstops hit", MarlinText::Ends("an axis hit its limit switch")),
    (r"printer stopped|printer halted|kill\(|killed", MarlinText::Ends("the control has halted")),
    ("//action:cancel", MarlinText::Ends("the job was canceled at the control")),
    ("//action:poweroff", MarlinText::Ends("the control switches off its power")),
    ("//action:disconnect", MarlinText::Ends("the control asks the host to disconnect")),
    ("cold extrusion", MarlinText::Ends("the control skips moves")),
    ("clamped", MarlinText::Ends("the control has changed a move")),
    ("^(?:wait|echo:)?$", MarlinText::Harmless),
    ("^//action:paused?$", MarlinText::Pause(true)),
    ("^//action:resumed?$", MarlinText::Pause(false)),
    // Temperatures: `T:20.0 /0.0 B:21.3`, `T0:20.0 /0.0`, `TargetExtr0:0`.
    ("^(?:t[0-9]*:|[bcw]:|targetextr|targetbed)", MarlinText::Harmless),
    // Capabilities, insertion and removal of memory cards, the selected tool, screen notices.
    ("^(?:cap:|firmware_name:)", MarlinText::Harmless),
    ("^echo:(?:sd card|sd init fail|no sd card|active extruder)", MarlinText::Harmless),
    ("^//action:(?:notification|prompt_)", MarlinText::Harmless),
    // A position: `X:1.00 Y:2.00 Z:3.00 E:0.00 Count X:80 Y:160 Z:1200`.
    ("^x:.*(?: y:.* z:| z:.* y:)", MarlinText::Harmless),
];

static PATTERNS: LazyLock<RegexSet> = LazyLock::new(|| patterns(TEXTS.iter().map(|(pattern, _)| *pattern)));

/// Returns the meaning of a text.
pub(super) fn meaning(text: &str) -> MarlinText {
    let first = PATTERNS.matches(text.trim().as_bytes()).iter().next();
    first.and_then(|place| TEXTS.get(place)).map_or(MarlinText::Unknown, |&(_, meaning)| meaning)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_what_is_known_to_be_harmless_is() {
        for text in [
            "",
            "wait",
            " T:20.0 /0.0 B:21.3 /0.0 @:0 B@:0",
            "T0:20.0 /0.0",
            "X:1.00 Y:2.00 Z:3.00 E:0.00 Count X:80 Y:160 Z:1200",
            "Cap:EEPROM:1",
            "echo:SD card ok",
            "echo:Active Extruder: 0",
            "//action:notification Ready",
        ] {
            assert_eq!(meaning(text), MarlinText::Harmless, "{text}");
        }
        for (text, is_paused) in [
            ("//action:pause", true),
            ("//action:paused", true),
            ("//action:resume", false),
            ("//action:resumed", false),
        ] {
            assert_eq!(meaning(text), MarlinText::Pause(is_paused), "{text}");
        }
        for text in [
            "echo:Home Z First",
            "echo:Home X/Y before Z",
            "echo:endstops hit:  X:12.00",
            "Printer stopped due to errors. Fix the error and use M999 to restart. (Temperature is reset. Set it after restarting)",
            "Error:Printer halted. kill() called!",
            "Error",
            "error",
            "Error:Probing failed",
            "!!",
            "//action:cancel",
            "//action:poweroff",
            "echo:Cold extrusion prevented",
            "echo:Soft limit: X clamped",
        ] {
            assert!(matches!(meaning(text), MarlinText::Ends(_)), "{text}");
        }
        for text in [
            "echo:; Home offset:",
            "garbage ###",
            "echo:enqueueing \"G28\"",
            "Not SD printing",
            "//action:start",
            "//action:out_of_filament",
            "DEBUG:INFO",
            "x",
            "T",
            "X:1",
        ] {
            assert_eq!(meaning(text), MarlinText::Unknown, "{text}");
        }
    }
}
