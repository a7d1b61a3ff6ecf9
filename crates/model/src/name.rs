//! Names of error components: `EXX`, `EAY`, `EC0Y`, `EX0S` (ISO 230-1, ISO 230-7).
//!
//! A name is `E`, the direction of the deviation, and the axis that has it. A `0` before the axis marks a location error: it does not depend on the position
//! of the axis.

use std::fmt;
use std::str::FromStr;

use ncfix_base::geometry::Axis;

/// Direction of a deviation: along or about an axis of F at the zero pose.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
#[repr(u8)]
#[expect(missing_docs, reason = "X Y Z are displacements along, A B C rotations about the axes of F")]
pub enum Direction {
    X,
    Y,
    Z,
    A,
    B,
    C,
}

/// Directions in order of their index: three displacements, three rotations.
pub const DIRECTIONS: [Direction; 6] =
    [Direction::X, Direction::Y, Direction::Z, Direction::A, Direction::B, Direction::C];

/// Body that deviates.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Carrier {
    /// The body that an axis moves.
    Axis(Axis),
    /// The spindle.
    Spindle,
}

/// Kind of an error: dependent on the position of its axis or not.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum ErrorKind {
    /// Independent of the position: location of the axis in the machine (`EC0Y`).
    Location,
    /// Dependent on the position: motion of the axis (`EXX`).
    Motion,
}

/// Name of an error component.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct ErrorName {
    /// Direction of the deviation.
    pub direction: Direction,
    /// Body that deviates.
    pub carrier: Carrier,
    /// Location or motion error.
    pub kind: ErrorKind,
}

impl Direction {
    /// Returns the index, 0 … 5.
    #[must_use]
    pub fn index(self) -> usize {
        self as usize
    }

    /// True for a rotation (rad), false for a displacement (mm).
    #[must_use]
    pub fn is_rotation(self) -> bool {
        self >= Direction::A
    }

    /// Returns its letter.
    #[must_use]
    pub fn letter(self) -> char {
        ['X', 'Y', 'Z', 'A', 'B', 'C'][self.index()]
    }
}

impl ErrorName {
    /// Returns the name of a motion error of an axis.
    #[must_use]
    pub fn motion(direction: Direction, axis: Axis) -> ErrorName {
        ErrorName { direction, carrier: Carrier::Axis(axis), kind: ErrorKind::Motion }
    }

    /// Returns the name of a location error of an axis.
    #[must_use]
    pub fn location(direction: Direction, axis: Axis) -> ErrorName {
        ErrorName { direction, carrier: Carrier::Axis(axis), kind: ErrorKind::Location }
    }

    /// Returns the name of a location error of the spindle.
    #[must_use]
    pub fn spindle(direction: Direction) -> ErrorName {
        ErrorName { direction, carrier: Carrier::Spindle, kind: ErrorKind::Location }
    }

    /// True for an error that does not depend on the position of its axis.
    #[must_use]
    pub fn is_location(&self) -> bool {
        self.kind == ErrorKind::Location
    }

    /// Returns the axis that has the error; `None` for the spindle.
    #[must_use]
    pub fn axis(&self) -> Option<Axis> {
        match self.carrier {
            Carrier::Axis(axis) => Some(axis),
            Carrier::Spindle => None,
        }
    }
}

impl ErrorName {
    /// Returns what the component is, in words: `squareness X–Y`, `straightness of X in Y`, `tilt of C about X`.
    #[must_use]
    pub fn spelled_out(&self) -> String {
        let letter = self.direction.letter();
        // The linear direction along or about which it deviates.
        let about = ['X', 'Y', 'Z'][self.direction.index() % 3];
        let Some(axis) = self.axis() else {
            let what =
                if self.direction.is_rotation() { "tilt of the spindle about" } else { "offset of the spindle in" };
            return format!("{what} {about}");
        };
        let name = axis.to_string();
        let own = if axis.is_rotary() { char::from(b'A' + (about as u8 - b'X')) } else { about };
        let is_own = name == own.to_string();
        match (self.kind, axis.is_rotary(), self.direction.is_rotation()) {
            (ErrorKind::Location, _, false) => format!("offset of {name} in {letter}"),
            (ErrorKind::Location, true, true) if is_own => format!("zero of {name}"),
            (ErrorKind::Location, false, true) if is_own => format!("roll of {name}"),
            (ErrorKind::Location, false, true) if matches!(axis, Axis::X | Axis::Y | Axis::Z) => {
                let other = ['X', 'Y', 'Z'].into_iter().find(|other| *other != about && name != other.to_string());
                format!("squareness {name}–{}", other.unwrap_or(about))
            }
            (ErrorKind::Location, _, true) => format!("tilt of {name} about {about}"),
            (ErrorKind::Motion, true, true) | (ErrorKind::Motion, false, false) if is_own => {
                format!("positioning of {name}")
            }
            (ErrorKind::Motion, false, false) => format!("straightness of {name} in {letter}"),
            (ErrorKind::Motion, false, true) if is_own => format!("roll of {name}"),
            (ErrorKind::Motion, false, true) => format!("angular error of {name} about {about}"),
            (ErrorKind::Motion, true, true) => format!("tilt of {name} about {about}"),
            (ErrorKind::Motion, true, false) if is_own => format!("axial error of {name}"),
            (ErrorKind::Motion, true, false) => format!("radial error of {name} in {letter}"),
        }
    }
}

impl fmt::Display for ErrorName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "E{}", self.direction.letter())?;
        if self.kind == ErrorKind::Location {
            f.write_str("0")?;
        }
        match self.carrier {
            Carrier::Axis(axis) => write!(f, "{axis}"),
            Carrier::Spindle => f.write_str("S"),
        }
    }
}

/// Error for a text that is not a component name.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct NoSuchComponent;

impl fmt::Display for NoSuchComponent {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(
            "a component is E, a direction X Y Z A B C, 0 for a location error, and an axis (or S): EXX, EC0Y, EX0S",
        )
    }
}

impl std::error::Error for NoSuchComponent {}

impl FromStr for ErrorName {
    type Err = NoSuchComponent;

    fn from_str(text: &str) -> Result<Self, NoSuchComponent> {
        let (kind, letter, body) = match *text.as_bytes() {
            [b'E', letter, b'0', body] => (ErrorKind::Location, letter, body),
            [b'E', letter, body] => (ErrorKind::Motion, letter, body),
            _ => return Err(NoSuchComponent),
        };
        let direction =
            DIRECTIONS.into_iter().find(|direction| direction.letter() == char::from(letter)).ok_or(NoSuchComponent)?;
        let carrier = match (body, kind) {
            // A spindle has no position.
            (b'S', ErrorKind::Location) => Carrier::Spindle,
            (b'A'..=b'Z', _) => Carrier::Axis(Axis::from_letter(body).ok_or(NoSuchComponent)?),
            _ => return Err(NoSuchComponent),
        };
        Ok(ErrorName { direction, carrier, kind })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_spelled_out() {
        for (name, words) in [
            ("EC0X", "squareness X–Y"),
            ("EB0Z", "squareness Z–X"),
            ("EA0X", "roll of X"),
            ("EX0C", "offset of C in X"),
            ("EA0C", "tilt of C about X"),
            ("EC0C", "zero of C"),
            ("EC0U", "tilt of U about Z"),
            ("EX0S", "offset of the spindle in X"),
            ("EB0S", "tilt of the spindle about Y"),
            ("EXX", "positioning of X"),
            ("EYX", "straightness of X in Y"),
            ("EAX", "roll of X"),
            ("ECX", "angular error of X about Z"),
            ("ECC", "positioning of C"),
            ("EAC", "tilt of C about X"),
            ("EZC", "axial error of C"),
            ("EXC", "radial error of C in X"),
        ] {
            assert_eq!(name.parse::<ErrorName>().unwrap().spelled_out(), words, "{name}");
        }
    }

    #[test]
    fn names_read_back_as_written() {
        for text in ["EXX", "EAY", "EC0Y", "EX0C", "EX0S", "EB0S", "EC0S", "ECC", "EZW", "EY0U"] {
            assert_eq!(text.parse::<ErrorName>().unwrap().to_string(), text);
        }
        assert_eq!("EC0Y".parse(), Ok(ErrorName::location(Direction::C, Axis::Y)));
        assert_eq!("EXS".parse::<ErrorName>(), Err(NoSuchComponent), "the spindle has location errors only");
        for text in ["", "E", "EX", "exx", "EDX", "EXQ", "EX1S", "ECS", "EXXX", "C0Y", "EX0", "EX00", "E0XX", "EXx"] {
            assert_eq!(text.parse::<ErrorName>(), Err(NoSuchComponent), "{text}");
        }
    }
}
