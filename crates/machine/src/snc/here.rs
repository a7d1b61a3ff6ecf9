//! Statements by which a control computes data from the place where it stands: `G10 L20`, and `G10 L10` and `L11` of RS274/NGC.

use ncfix_base::geometry::{AxisSet, AxisVector, Frame};

/// Statement that gives values to the current position, so that the control computes the data itself.
///
/// The output stands beside the place of the program, by its correction. There it needs other values, so that the same data result. Data that the
/// control computes do not depend on the zero offsets of the machine file, which may be estimates.
#[derive(Clone, Debug, PartialEq)]
pub struct HereStatement {
    /// Words before the values: `G10 L20 P1`.
    pub words: String,
    /// Words after the values, with a blank before each: ` R1.5`.
    pub after: String,
    /// Axis commands of the place where the values count: mm, rad.
    pub command: AxisVector,
    /// From the coordinates of the values to the directions of the axes.
    pub frame: Frame,
    /// Values for this place: mm, rad.
    pub values: AxisVector,
    /// Axes with a value.
    pub named: AxisSet,
    /// Length unit of the output, mm.
    pub unit_mm: f64,
    /// Data that result at the control, as far as the zero offsets of the machine file are right: mm, rad.
    pub data: AxisVector,
}

impl HereStatement {
    /// Changes the values to those of another place, so that the same data result there.
    pub fn stand_at(&mut self, command: AxisVector) {
        self.values = self.values + (self.frame.unapply(&command) - self.frame.unapply(&self.command));
        self.command = command;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use ncfix_base::geometry::{Axis, Matrix};

    fn statement(frame: Frame) -> HereStatement {
        let axes = [Axis::X, Axis::Y].into_iter().collect();
        let command = AxisVector::ZERO;
        let (words, after) = ("G10 L20 P1".to_owned(), String::new());
        HereStatement { words, after, command, frame, values: command, named: axes, unit_mm: 1.0, data: command }
    }

    #[test]
    fn the_values_move_with_the_place() {
        let mut place = AxisVector::ZERO;
        place[Axis::X] = 0.03;
        place[Axis::Y] = -0.01;
        let mut plain = statement(Frame::translation(AxisVector::ZERO));
        plain.values[Axis::X] = 5.0;
        plain.stand_at(place);
        assert!((plain.values[Axis::X] - 5.03).abs() < 1e-12 && (plain.values[Axis::Y] + 0.01).abs() < 1e-12);
        // A quarter turn: X of the coordinates points along Y of the machine, Y against X.
        let mut turned = statement(Frame::rotation(Matrix::new(0.0, -1.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0)));
        turned.stand_at(place);
        assert!((turned.values[Axis::X] + 0.01).abs() < 1e-12 && (turned.values[Axis::Y] + 0.03).abs() < 1e-12);
    }
}
