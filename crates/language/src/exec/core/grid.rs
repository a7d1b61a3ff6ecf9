//! The grid of the control: its smallest increment, to which words are rounded, and at which two points are compared.

use super::fault::{Fault, fault};
use ncfix_base::diagnostic::Code;
use ncfix_base::source::Span;

/// Tolerance of the midpoint between two increments, in increments: the representation error of a decimal number as a double.
const MIDDLE: f64 = 1e-7;
/// Distance below which points are equal on any grid, mm: far below every increment, far above double precision.
const NOISE_MM: f64 = 1e-9;
/// Angle below which an arc of LinuxCNC is a full circle, rad: `CIRCLE_FUZZ` of its motion control.
const LEAST_ANGLE: f64 = 1e-6;

/// Rounds a value to a grid of `per_unit` increments per unit; midpoints are rounded away from zero.
pub(in crate::exec) fn on_grid(value: f64, per_unit: f64) -> f64 {
    let increments = (value.abs() * per_unit + 0.5 + MIDDLE).floor();
    // A whole number divided by a power of ten is the double nearest to the decimal number; zero has no sign.
    if increments == 0.0 { 0.0 } else { (increments / per_unit).copysign(value) }
}

/// Comparison of two points of the working plane at the control's resolution.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::exec) enum Meeting {
    /// The points are equal.
    Same,
    /// The points are different.
    Apart,
    /// They are within one increment on both sides of a rounding midpoint.
    Unsure,
}

/// Compares two points on a grid of `per_mm` increments per millimeter.
pub(in crate::exec) fn meeting(a: [f64; 2], b: [f64; 2], per_mm: f64) -> Meeting {
    let apart = (a[0] - b[0]).abs().max((a[1] - b[1]).abs());
    if is_one_place(a, b) {
        Meeting::Same
    } else if apart > (1.0 - 1e-6) / per_mm {
        Meeting::Apart
    } else if a.map(|place| on_grid(place, per_mm)) == b.map(|place| on_grid(place, per_mm)) {
        Meeting::Same
    } else {
        Meeting::Unsure
    }
}

/// `true` if two points of the working plane are equal on any grid.
pub(in crate::exec) fn is_one_place(a: [f64; 2], b: [f64; 2]) -> bool {
    (a[0] - b[0]).abs().max((a[1] - b[1]).abs()) < NOISE_MM
}

/// `true` if an arc of LinuxCNC about a center ends at its start: it works in doubles without a grid.
pub(in crate::exec) fn closes_in_linuxcnc(start: [f64; 2], end: [f64; 2], center: [f64; 2]) -> bool {
    let chord = (start[0] - end[0]).hypot(start[1] - end[1]);
    chord < LEAST_ANGLE * (start[0] - center[0]).hypot(start[1] - center[1])
}

/// The fault for an arc that may be a full circle or almost nothing. `setting` names the machine file setting that decides it.
pub(in crate::exec) fn unsure(span: Span, start: [f64; 2], end: [f64; 2], setting: &str) -> Fault {
    let apart_um = 1e3 * (start[0] - end[0]).hypot(start[1] - end[1]);
    let message = format!(
        "the end of this arc is {apart_um:.3} µm from its start: depending on the resolution of the control it is a full circle or a very short arc"
    );
    let help = format!("for a full circle program the end exactly at the start, or omit the arc; {setting}");
    fault(Code::FULL_CIRCLE_UNSURE, span, message, help)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_go_to_the_nearest_increment_and_halves_away_from_zero() {
        for (value, expected) in [
            (0.84375, 0.844),
            (10.0 / 3.0, 3.333),
            (1.0005, 1.001),
            (-1.0005, -1.001),
            (2.0015, 2.002),
            (0.000_49, 0.0),
            (-0.0004, 0.0),
            (123_456.789, 123_456.789),
        ] {
            assert_eq!(on_grid(value, 1e3), expected, "{value}");
        }
        assert!(on_grid(-0.0004, 1e3).is_sign_positive());
        assert_eq!(on_grid(0.843_75, 1e4), 0.8438);
    }

    #[test]
    fn points_meet_on_the_grid() {
        let of = |a: f64, b: f64| meeting([0.0, a], [0.0, b], 1e3);
        assert_eq!(of(-0.0004, 0.0), Meeting::Same);
        assert_eq!(of(0.0004, -0.0004), Meeting::Same);
        assert_eq!(of(0.001, 0.0), Meeting::Apart);
        assert_eq!(of(0.7, 0.701), Meeting::Apart);
        assert_eq!(of(0.0006, 0.0), Meeting::Unsure);
        assert_eq!(of(0.000_5, 0.000_5 + 1e-12), Meeting::Same);
    }

    #[test]
    fn linuxcnc_turns_fully_below_a_millionth() {
        assert!(closes_in_linuxcnc([0.0, -9e-6], [0.0, 0.0], [10.0, 0.0]));
        assert!(!closes_in_linuxcnc([0.0, -4e-4], [0.0, 0.0], [10.0, 0.0]));
    }
}
