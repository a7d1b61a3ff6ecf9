//! Marlin: what it says of its own accord, as far as that is known.
//!
//! Firmware of this family goes on behind many texts that say that a line was not carried out, or not as it was written. So only those count as harmless
//! that are known to be: what is none of them may have been such a text.

/// What a text means that is no answer to a line.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum MarlinText {
    /// It says nothing of the motion.
    Harmless,
    /// The firmware asks the sender to pause, or to go on.
    Pause(bool),
    /// The job ends: why.
    Ends(&'static str),
    /// Nobody knows.
    Unknown,
}

/// What begins texts that say nothing of the motion, in small letters: temperatures, capabilities, memory cards that come and go, notices for a screen,
/// the tool that was selected.
const HARMLESS: &[&str] = &[
    "t:",
    "b:",
    "c:",
    "w:",
    "targetextr",
    "targetbed",
    "cap:",
    "firmware_name:",
    "echo:sd card",
    "echo:sd init fail",
    "echo:no sd card",
    "echo:active extruder",
    "//action:notification",
    "//action:prompt_",
];
/// Parts of texts behind which nothing may follow, in small letters, and why.
const ENDS: &[(&str, &str)] = &[
    ("endstops hit", "an axis ran into its end switch"),
    ("printer stopped", "the control has stopped itself"),
    ("printer halted", "the control has stopped itself"),
    ("kill(", "the control has stopped itself"),
    ("killed", "the control has stopped itself"),
    ("//action:cancel", "a person has cancelled the job at the control"),
    ("//action:poweroff", "the control switches its power off"),
    ("//action:disconnect", "the control asks to be left"),
    ("cold extrusion", "the control leaves moves out"),
    ("clamped", "the control has changed a move"),
];

/// What a text means.
pub(super) fn meaning(text: &str) -> MarlinText {
    let low = text.to_ascii_lowercase();
    let low = low.trim();
    if low == "!!" || low == "error" || low.starts_with("error:") {
        return MarlinText::Ends("the control has stopped itself");
    }
    // `Home X First`, of older ones `Home X/Y before Z`; the settings that it starts with have a `Home offset`.
    if low.contains("home") && (low.contains("first") || low.contains("before")) {
        return MarlinText::Ends("an axis is not homed, so that moves are left out");
    }
    if let Some((_, why)) = ENDS.iter().find(|(part, _)| low.contains(part)) {
        return MarlinText::Ends(why);
    }
    match low {
        "" | "wait" | "echo:" => return MarlinText::Harmless,
        "//action:pause" | "//action:paused" => return MarlinText::Pause(true),
        "//action:resume" | "//action:resumed" => return MarlinText::Pause(false),
        _ => {}
    }
    if HARMLESS.iter().any(|begin| low.starts_with(begin)) || is_tool_temperature(low) || is_position(low) {
        return MarlinText::Harmless;
    }
    MarlinText::Unknown
}

/// `T0:20.0 /0.0`.
fn is_tool_temperature(low: &str) -> bool {
    let Some((tool, _)) = low.split_once(':') else { return false };
    tool.strip_prefix('t').is_some_and(|number| !number.is_empty() && number.bytes().all(|byte| byte.is_ascii_digit()))
}

/// `X:1.00 Y:2.00 Z:3.00 E:0.00 Count X:80 Y:160 Z:1200`.
fn is_position(low: &str) -> bool {
    low.starts_with("x:") && low.contains(" y:") && low.contains(" z:")
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
