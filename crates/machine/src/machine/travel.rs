//! Travel of an axis: two increasing limits at a plausible distance.

use super::section::Section;
use ncfix_base::diagnostic::Code;
use ncfix_base::geometry::Axis;

/// Shortest travel, mm or degrees: paths are sampled in fractions of it.
const SHORTEST_TRAVEL: f64 = 0.001;
/// Limits beyond this are not valid, mm or degrees; no program position is farther away either.
const FARTHEST: f64 = 1e9;

/// Reads the limits, in the unit of the key.
pub(super) fn read(axis: Axis, key: &str, section: &mut Section<'_>) -> Option<[f64; 2]> {
    let travel = section.numbers(key)?;
    let (message, help) = match *travel.as_slice() {
        [low, high] if low < high => {
            if high - low >= SHORTEST_TRAVEL && low.abs().max(high.abs()) <= FARTHEST {
                return Some([low, high]);
            }
            let help =
                format!("a travel is at least {SHORTEST_TRAVEL} long and ends before {FARTHEST:e}; check the numbers");
            (format!("{key} of axis {axis} is not a plausible travel"), help)
        }
        _ => {
            let help = format!("write two numbers that increase, for example `{key} = [0, 500]`");
            (format!("{key} of axis {axis} must be the lowest and the highest position"), help)
        }
    };
    section.report(Code::BAD_VALUE, section.place_of(key), message, help);
    None
}
