//! M codes that clamp an axis: it must not move until its clamp is released.
//!
//! ISO 6983-1 assigns M10 and M11 to clamping. Builders of ISO mills use M12 and M13 for the brake of a second rotary axis. On a Sinumerik or a Grundig the
//! builder decides, so no codes are assumed there.

use ncfix_base::diagnostic::Code;
use ncfix_base::geometry::Axis;

use super::section::Section;

/// Largest M code number that a control accepts.
const LAST_CODE: f64 = 99_999_999.0;

/// Clamp of an axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Clamp {
    /// M code that closes it.
    pub close: u32,
    /// M code that opens it.
    pub open: u32,
}

/// Default clamps if the machine file states none.
const ISO: [Clamp; 2] = [Clamp { close: 10, open: 11 }, Clamp { close: 12, open: 13 }];

/// Reads `clamp_codes` and `unclamp_codes` of an axis section.
pub(super) fn read(axis: Axis, controller: &str, section: &mut Section<'_>) -> Vec<Clamp> {
    let is_iso = ["fanuc", "rs274"].iter().any(|name| controller.eq_ignore_ascii_case(name));
    let assumed = if axis.is_rotary() && is_iso { ISO.to_vec() } else { Vec::new() };
    let [close, open] = ["clamp_codes", "unclamp_codes"].map(|key| codes(section, key));
    match (close, open) {
        (None, None) => assumed,
        (Some(close), Some(open)) if close.len() == open.len() => {
            close.into_iter().zip(open).map(|(close, open)| Clamp { close, open }).collect()
        }
        _ => {
            let key = if section.has("clamp_codes") { "clamp_codes" } else { "unclamp_codes" };
            let message = format!("axis {axis}: clamp_codes and unclamp_codes do not match");
            let help = "write the M codes that clamp the axis and, in the same order, those that release it: \
                        clamp_codes = [10], unclamp_codes = [11]";
            section.report(Code::BAD_VALUE, section.place_of(key), message, help);
            assumed
        }
    }
}

/// Reads the whole numbers of a key; `None` if it is absent or invalid.
fn codes(section: &mut Section<'_>, key: &str) -> Option<Vec<u32>> {
    let is_code = |value: &f64| (0.0..=LAST_CODE).contains(value) && value.fract() == 0.0;
    let numbers = section.numbers(key)?;
    if !numbers.iter().all(is_code) {
        let message = format!("{key} must be M code numbers, whole numbers from 0 to {LAST_CODE}");
        section.report(Code::BAD_VALUE, section.place_of(key), message, format!("write for example {key} = [10]"));
        return None;
    }
    // Exact: whole numbers below 10⁸.
    Some(numbers.into_iter().map(|value| value as u32).collect())
}
