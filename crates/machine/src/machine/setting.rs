//! Values that only the machine knows: `[system]` for system variables, `[gud]` for global variables.

use std::collections::BTreeMap;

use ncfix_base::diagnostic::{Code, Diagnostic};

use super::document::{TomlItem, TomlValue};
use super::section::Section;

/// Value in such a table.
#[derive(Clone, Debug, PartialEq)]
pub enum Setting {
    /// A whole number.
    Whole(i64),
    /// A number with a fraction.
    Number(f64),
    /// `true`, `false`
    Truth(bool),
    /// A text.
    Text(String),
    /// An array, row by row.
    List(Vec<Setting>),
}

impl Setting {
    fn of(item: &TomlItem) -> Option<Setting> {
        Some(match &item.value {
            TomlValue::Number { value, whole: true } if value.abs() < 9e15 => Setting::Whole(*value as i64),
            TomlValue::Number { value, .. } if value.is_finite() => Setting::Number(*value),
            TomlValue::Boolean(value) => Setting::Truth(*value),
            TomlValue::Text(text) => Setting::Text(text.clone()),
            TomlValue::Items(items) => Setting::List(items.iter().map(Setting::of).collect::<Option<_>>()?),
            _ => return None,
        })
    }
}

/// Normalizes a name to the form in which the execution looks it up: upper case, without blanks.
pub(super) fn normal(key: &str) -> String {
    key.chars().filter(|letter| !letter.is_whitespace()).map(|letter| letter.to_ascii_uppercase()).collect()
}

/// Reads `[system]`, whose keys are system variables or calls of functions, or `[gud]`, whose keys are names.
pub(super) fn read(
    section: Option<Section<'_>>,
    is_system: bool,
    findings: &mut Vec<Diagnostic>,
) -> BTreeMap<String, Setting> {
    let mut out = BTreeMap::new();
    let Some(mut section) = section else { return out };
    let keys: Vec<&str> = section.keys().collect();
    for key in keys {
        let name = normal(key);
        // E5 of a Grundig or MillPlus.
        let is_e = || {
            name.strip_prefix('E')
                .is_some_and(|number| !number.is_empty() && number.bytes().all(|byte| byte.is_ascii_digit()))
        };
        let fits = if is_system {
            name.starts_with(['$', '#']) || name.ends_with([')', ']']) || is_e()
        } else {
            is_name(&name)
        };
        if !fits {
            section.accept(key);
            let help = if is_system {
                "write a system variable with its indices in quotation marks, for example \"$MN_INT_INCR_PER_MM\" = 1000"
            } else {
                "write the name of a variable, for example NAME = 5, or NAME = [1, 2, 3] for an array"
            };
            let place = section.place_of_key(key);
            section.report(Code::UNKNOWN_KEY, place, format!("{key} is not a variable name"), help);
            continue;
        }
        let expected = if is_system {
            "a number, a text, true or false"
        } else {
            "a number, a text, true, false or a list of these"
        };
        let allows = |setting: &Setting| !is_system || !matches!(setting, Setting::List(_));
        if let Some(setting) = section.value(key, expected, |item| Setting::of(item).filter(allows)) {
            out.insert(name, setting);
        }
    }
    section.finish(findings);
    out
}

fn is_name(name: &str) -> bool {
    name.len() >= 2
        && name.bytes().all(|byte| byte.is_ascii_alphanumeric() || byte == b'_')
        && !name.starts_with(|letter: char| letter.is_ascii_digit())
}
