//! Codes of a Haas that a Fanuc lacks or uses for something else. They are executed if the machine file states the control.

use super::codes::Group;

/// The group of a code of a Haas, in tenths, and the code that is executed; `None` for the codes of a Fanuc.
pub(super) fn code_of(tenths: u16) -> Option<(Group, u16)> {
    Some(match tenths {
        120 | 130 | 700 | 710 | 720 | 2540 | 2550 => (Group::Action, tenths),
        1540 => (Group::Coordinates, tenths),
        1100..=1290 if tenths.is_multiple_of(10) => (Group::Coordinates, tenths),
        1000 => (Group::Mirror, 501),
        1010 => (Group::Mirror, 511),
        2340 => (Group::Length, 434),
        _ => return None,
    })
}

/// Help for a code of a Haas whose motions are not published.
pub(super) fn advice(tenths: u16) -> Option<&'static str> {
    Some(match tenths {
        1500 => "on a Haas this is a pocket whose path only the control knows: program the moves of the pocket",
        470 => "on a Haas this engraves a text whose strokes only the control knows: program the moves of the text",
        350 | 360 | 370 | 1360 => {
            "the measured value changes positions: put the measurement into a program that is not corrected"
        }
        _ => return None,
    })
}

/// The number of an additional work offset: G110 is G154 P1, and so on.
pub(super) fn system_of(code: u16) -> Option<u16> {
    (1100..=1290).contains(&code).then(|| (code - 1100) / 10 + 1)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn systems_of_a_haas_have_two_names() {
        assert_eq!(system_of(1100), Some(1));
        assert_eq!(system_of(1290), Some(20));
        assert_eq!(system_of(1540), None);
        assert_eq!(code_of(1105), None);
    }
}
