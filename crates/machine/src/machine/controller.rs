//! Names of controls in `machine.controller`: those of the languages of ncfix, and those by which people know their control.

/// Meaning of a name.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ControllerMeaning {
    /// The control reads this language of ncfix.
    Language(&'static str),
    /// A Haas: the language of a Fanuc, with other meanings of some words.
    Haas,
    /// The control reads a language that resembles one of ncfix, with differences; the text says what to write and when.
    Differs(&'static str),
    /// The control reads a language that ncfix does not read; the text says which programs it can read.
    Unread(&'static str),
}

/// A name and its meaning.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ControllerName {
    /// Name, in lower case, without blanks, `-` and `_`.
    pub name: &'static str,
    /// Meaning of the name.
    pub meaning: ControllerMeaning,
}

const SINUMERIK: ControllerMeaning = ControllerMeaning::Language("sinumerik");
const FANUC: ControllerMeaning = ControllerMeaning::Language("fanuc");
const RS274: ControllerMeaning = ControllerMeaning::Language("rs274");
const GRUNDIG: ControllerMeaning = ControllerMeaning::Language("grundig");
const LIKE_RS274: ControllerMeaning = ControllerMeaning::Differs(
    "write controller = \"rs274\" if your programs come from a post-processor for LinuxCNC or Grbl, with relative arc centers (G91.1)",
);
const LIKE_FANUC: ControllerMeaning =
    ControllerMeaning::Differs("write controller = \"fanuc\" if your programs are in the ISO mode of the control");
const TO_ISO: ControllerMeaning = ControllerMeaning::Unread(
    "ncfix reads no programs of this control in its own language; write controller = \"fanuc\" if it runs programs in its ISO mode",
);

const KLARTEXT: ControllerMeaning = ControllerMeaning::Unread(
    "ncfix reads no programs of this control, neither Klartext nor DIN/ISO; to make its compensation tables, leave out controller and use ncfix tables --format heidenhain",
);

/// Names of controls. The first name of a language is its own.
pub const CONTROLLERS: &[ControllerName] = &[
    ControllerName { name: "sinumerik", meaning: SINUMERIK },
    ControllerName { name: "siemens", meaning: SINUMERIK },
    ControllerName { name: "840d", meaning: SINUMERIK },
    ControllerName { name: "840dsl", meaning: SINUMERIK },
    ControllerName { name: "840di", meaning: SINUMERIK },
    ControllerName { name: "828d", meaning: SINUMERIK },
    ControllerName { name: "808d", meaning: SINUMERIK },
    ControllerName { name: "810d", meaning: SINUMERIK },
    ControllerName { name: "802d", meaning: SINUMERIK },
    ControllerName { name: "sinumerikone", meaning: SINUMERIK },
    ControllerName { name: "sinumerik840d", meaning: SINUMERIK },
    ControllerName { name: "sinumerik840dsl", meaning: SINUMERIK },
    ControllerName { name: "sinumerik828d", meaning: SINUMERIK },
    ControllerName { name: "fanuc", meaning: FANUC },
    ControllerName { name: "fanuc0i", meaning: FANUC },
    ControllerName { name: "fanuc30i", meaning: FANUC },
    ControllerName { name: "fanuc31i", meaning: FANUC },
    ControllerName { name: "0i", meaning: FANUC },
    ControllerName { name: "30i", meaning: FANUC },
    ControllerName { name: "31i", meaning: FANUC },
    ControllerName { name: "haas", meaning: ControllerMeaning::Haas },
    ControllerName { name: "haasngc", meaning: ControllerMeaning::Haas },
    ControllerName { name: "rs274", meaning: RS274 },
    ControllerName { name: "rs274ngc", meaning: RS274 },
    ControllerName { name: "linuxcnc", meaning: RS274 },
    ControllerName { name: "emc2", meaning: RS274 },
    ControllerName { name: "grbl", meaning: RS274 },
    ControllerName { name: "grblhal", meaning: RS274 },
    ControllerName { name: "fluidnc", meaning: RS274 },
    ControllerName { name: "grundig", meaning: GRUNDIG },
    ControllerName { name: "millplus", meaning: GRUNDIG },
    ControllerName { name: "philips", meaning: GRUNDIG },
    ControllerName { name: "maho", meaning: GRUNDIG },
    ControllerName { name: "mach3", meaning: LIKE_RS274 },
    ControllerName { name: "mach4", meaning: LIKE_RS274 },
    ControllerName { name: "uccnc", meaning: LIKE_RS274 },
    ControllerName { name: "marlin", meaning: LIKE_RS274 },
    ControllerName { name: "smoothieware", meaning: LIKE_RS274 },
    ControllerName { name: "mitsubishi", meaning: LIKE_FANUC },
    ControllerName { name: "brother", meaning: LIKE_FANUC },
    ControllerName { name: "syntec", meaning: LIKE_FANUC },
    ControllerName { name: "heidenhain", meaning: KLARTEXT },
    ControllerName { name: "tnc640", meaning: KLARTEXT },
    ControllerName { name: "itnc530", meaning: KLARTEXT },
    ControllerName { name: "mazak", meaning: TO_ISO },
    ControllerName { name: "mazatrol", meaning: TO_ISO },
    ControllerName { name: "okuma", meaning: TO_ISO },
    ControllerName { name: "fagor", meaning: TO_ISO },
];

/// Returns the entry of a name, in any case, with or without blanks, `-` and `_`; `None` if it is not known.
#[must_use]
pub fn controller(name: &str) -> Option<&'static ControllerName> {
    let plain = |letter: &char| !matches!(letter, ' ' | '-' | '_' | '/');
    let plain: String = name.chars().filter(plain).map(|letter| letter.to_ascii_lowercase()).collect();
    CONTROLLERS.iter().find(|row| row.name == plain)
}

/// Controls with RS274/NGC that start with G98, other than LinuxCNC (grblHAL, gcode.c: the retraction mode is G98 by default).
const START_WITH_G98: [&str; 1] = ["grblhal"];

/// True if drilling cycles of a control end at the initial level until a program says otherwise.
pub(super) fn starts_with_g98(name: &str) -> bool {
    controller(name).is_some_and(|row| START_WITH_G98.contains(&row.name))
}

/// True if words at the start state whether a drilling cycle ends at the initial level or at R.
pub(super) fn states_retraction(words: &str) -> bool {
    let plain: String =
        words.chars().filter(|letter| !letter.is_whitespace()).map(|letter| letter.to_ascii_uppercase()).collect();
    plain.contains("G98") || plain.contains("G99")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_found_in_any_spelling() {
        for (name, expected) in [("840D sl", SINUMERIK), ("Grbl", RS274), ("grblHAL", RS274), ("MillPlus", GRUNDIG)] {
            assert_eq!(controller(name).map(|row| row.meaning), Some(expected), "{name}");
        }
        assert!(matches!(controller("Mach3").map(|row| row.meaning), Some(ControllerMeaning::Differs(_))));
        assert_eq!(controller("latin"), None);
    }
}
