//! The grid of the control: its least increment, on which words lie, and on which it is decided whether two points are one.

use super::fault::{Fault, fault};
use ncfix_base::diagnostic::Code;
use ncfix_base::source::Span;

/// A value this near to the middle between two increments is in the middle, as a share of one: what the writing of a decimal number as a
/// double adds to it.
const MIDDLE: f64 = 1e-7;
/// Points nearer than this are one whatever the grid, mm: far below every increment, far above what a double loses.
const NOISE_MM: f64 = 1e-9;
/// An arc of LinuxCNC that turns by less than this, rad, is a full circle: `CIRCLE_FUZZ` of its motion control.
const LEAST_ANGLE: f64 = 1e-6;

/// A value on a grid of so many increments in its unit; what lies in the middle goes away from zero.
pub(in crate::exec) fn on_grid(value: f64, per_unit: f64) -> f64 {
    let increments = (value.abs() * per_unit + 0.5 + MIDDLE).floor();
    // A whole number over a power of ten is the double that the decimal number itself would be; zero has no sign.
    if increments == 0.0 { 0.0 } else { (increments / per_unit).copysign(value) }
}

/// Whether two points of the working plane are one for the control.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::exec) enum Meeting {
    /// They are one.
    Same,
    /// They are two.
    Apart,
    /// They lie within one increment on both sides of the middle between two places of the grid.
    Unsure,
}

/// Whether two points are one on a grid of so many increments in a millimeter.
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

/// Whether two points of the working plane are one whatever the grid.
pub(in crate::exec) fn is_one_place(a: [f64; 2], b: [f64; 2]) -> bool {
    (a[0] - b[0]).abs().max((a[1] - b[1]).abs()) < NOISE_MM
}

/// Whether an arc of LinuxCNC about a center ends where it starts: it works in doubles and has no grid.
pub(in crate::exec) fn closes_in_linuxcnc(start: [f64; 2], end: [f64; 2], center: [f64; 2]) -> bool {
    let chord = (start[0] - end[0]).hypot(start[1] - end[1]);
    chord < LEAST_ANGLE * (start[0] - center[0]).hypot(start[1] - center[1])
}

/// An arc of which it is not sure whether it is a full circle or nearly nothing. `setting` says what in the machine file decides it.
pub(in crate::exec) fn unsure(span: Span, start: [f64; 2], end: [f64; 2], setting: &str) -> Fault {
    let apart_um = 1e3 * (start[0] - end[0]).hypot(start[1] - end[1]);
    let message = format!(
        "the end of this arc is {apart_um:.3} µm from its start: by the resolution of the control it is a full circle, or hardly a move"
    );
    let help = format!("program the end exactly at the start for a full circle, or leave the arc out; {setting}");
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
