//! Settings of the control for custom macros.

use std::collections::BTreeMap;

use ncfix_base::diagnostic::Code;

use super::section::Section;

/// Settings of custom macros.
#[derive(Clone, Debug, PartialEq)]
pub struct MacroControl {
    /// Programs that codes call as macros, by code: `G100`, `M50`, `T` (Fanuc parameters 6050 to 6059, 6080 to 6089, 6001 bit 5).
    pub codes: BTreeMap<String, u32>,
    /// True if I, J and K of a macro call may repeat (Fanuc parameter 6008, bit 7, disables it).
    pub arguments_two: bool,
    /// True if ATAN and ASIN return angles from −180° to 180°, else from 0° to 360° (Fanuc parameter 6004, bit 0).
    pub signed_angles: bool,
}

impl Default for MacroControl {
    fn default() -> Self {
        MacroControl { codes: BTreeMap::new(), arguments_two: true, signed_angles: false }
    }
}

/// Reads the settings.
pub(super) fn read(section: &mut Section<'_>, macros: &mut MacroControl) {
    if let Some(value) = section.boolean("arguments_two") {
        macros.arguments_two = value;
    }
    if let Some(value) = section.boolean("signed_angles") {
        macros.signed_angles = value;
    }
    let Some(mut codes) = section.section("macro_codes") else { return };
    let keys: Vec<&str> = codes.keys().collect();
    for key in keys {
        let program = codes.integer(key);
        match (code_of(key), program) {
            (Some(code), Some(program)) => {
                macros.codes.insert(code, program);
            }
            (None, _) => {
                let help = "write the code and its program number, for example G100 = 9010, M50 = 9020, T = 9000";
                codes.report(
                    Code::BAD_VALUE,
                    codes.place_of_key(key),
                    format!("{key} is not a code that can call a program"),
                    help,
                );
            }
            (Some(_), None) => {}
        }
    }
    let mut findings = Vec::new();
    codes.finish(&mut findings);
    section.add(findings);
}

/// Normalizes a code to the form in which the execution looks it up, without leading zeros: `G5`, `G54.4`, `T`.
fn code_of(key: &str) -> Option<String> {
    let key = key.to_ascii_uppercase();
    if key == "T" {
        return Some(key);
    }
    let letter = key.chars().next().filter(|letter| matches!(letter, 'G' | 'M'))?;
    let number: f64 = key.get(1..)?.parse().ok().filter(|number| (0.0..1e5).contains(number))?;
    Some(format!("{letter}{number}"))
}
