//! Fast state of a machine on which the error model may depend.

use std::str::FromStr;

use ncfix_base::geometry::{AXES, AXIS_COUNT, Axis, AxisSet, AxisVector};

/// State of the machine at one instant.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct State {
    /// Direction of the last motion of each axis: −1, 0 (none yet) or 1.
    pub direction: [i8; AXIS_COUNT],
    /// Acceleration of each axis, mm/s² or rad/s²; zero if it is not known.
    pub acceleration: AxisVector,
    /// Jerk of each axis, mm/s³ or rad/s³; zero if it is not known.
    pub jerk: AxisVector,
}

impl State {
    /// Returns the direction of the last motion of an axis: −1, 0 or 1.
    #[must_use]
    pub fn direction(&self, axis: Axis) -> i8 {
        self.direction[axis.slot()]
    }

    /// Notes a motion of which only the axes in `stated` have a known start. The direction of the others becomes unknown if their position changes.
    pub fn note_stated(&mut self, stated: AxisSet, from: &AxisVector, to: &AxisVector) {
        self.note_motion(from, to);
        for axis in AXES.into_iter().filter(|&axis| !stated.contains(axis) && from[axis] != to[axis]) {
            self.direction[axis.slot()] = 0;
        }
    }

    /// Sets the direction of the axes to unknown.
    pub fn forget(&mut self, axes: AxisSet) {
        axes.iter().for_each(|axis| self.direction[axis.slot()] = 0);
    }

    /// Notes a motion; axes at rest keep the direction of their last motion.
    pub fn note_motion(&mut self, from: &AxisVector, to: &AxisVector) {
        for slot in 0..AXIS_COUNT {
            let step = to.0[slot] - from.0[slot];
            if step > 0.0 {
                self.direction[slot] = 1;
            } else if step < 0.0 {
                self.direction[slot] = -1;
            }
        }
    }
}

impl FromStr for State {
    type Err = String;

    /// Reads `X+,Y-`: direction of the last motion of axes.
    fn from_str(text: &str) -> Result<State, String> {
        let mut state = State::default();
        for part in text.split(',').map(str::trim) {
            let wrong = || format!("'{part}' is not a direction of motion; write for example X+,Y-");
            let (axis, sense) = match *part.as_bytes() {
                [letter, b'+'] => (Axis::from_letter(letter.to_ascii_uppercase()), 1),
                [letter, b'-'] => (Axis::from_letter(letter.to_ascii_uppercase()), -1),
                _ => (None, 0),
            };
            state.direction[axis.ok_or_else(wrong)?.slot()] = sense;
        }
        Ok(state)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_direction_follows_its_axis() {
        assert_eq!("X+,c-".parse::<State>().unwrap().direction, [1, 0, 0, 0, 0, 0, 0, 0, -1]);
        assert!("X".parse::<State>().is_err());
    }
}
