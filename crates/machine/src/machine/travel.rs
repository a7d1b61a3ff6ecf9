//! The travel of an axis: two ends that increase, as far apart as those of machines are.

use super::section::Section;
use ncfix_base::diagnostic::Code;
use ncfix_base::geometry::Axis;

/// Shortest travel, mm or degrees: paths are sampled in parts of it.
const SHORTEST_TRAVEL: f64 = 0.001;
/// Ends of travels beyond this are none, mm or degrees; no position of a program is farther either.
const FARTHEST: f64 = 1e9;

/// The ends, in the unit of the key.
pub(super) fn read(axis: Axis, key: &str, section: &mut Section<'_>) -> Option<[f64; 2]> {
    let travel = section.numbers(key)?;
    let (message, help) = match *travel.as_slice() {
        [low, high] if low < high => {
            if high - low >= SHORTEST_TRAVEL && low.abs().max(high.abs()) <= FARTHEST {
                return Some([low, high]);
            }
            let help =
                format!("travels are {SHORTEST_TRAVEL} long at least and end before {FARTHEST:e}; check the numbers");
            (format!("{key} of axis {axis} is no travel of a machine"), help)
        }
        _ => {
            let help = format!("write two numbers that increase, for example `{key} = [0, 500]`");
            (format!("{key} of axis {axis} must be the lowest and the highest position"), help)
        }
    };
    section.report(Code::BAD_VALUE, section.place_of(key), message, help);
    None
}
