//! Nine axis letters of ISO 841 and vectors over them.

use std::fmt;
use std::ops::{Add, Index, IndexMut, Sub};
use std::str::FromStr;

use serde::{Serialize, Serializer};

use super::Vector;
use crate::units::{um_from_mm, urad_from_rad};

/// Machine axis by its ISO 841 letter; the number is its slot in an [`AxisVector`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
#[repr(u8)]
#[expect(missing_docs, reason = "the letters are the documentation")]
pub enum Axis {
    X,
    Y,
    Z,
    U,
    V,
    W,
    A,
    B,
    C,
}

/// Number of slots in an [`AxisVector`].
pub const AXIS_COUNT: usize = 9;
/// All axes in slot order.
pub const AXES: [Axis; AXIS_COUNT] = [Axis::X, Axis::Y, Axis::Z, Axis::U, Axis::V, Axis::W, Axis::A, Axis::B, Axis::C];
/// Linear axes in slot order.
pub const LINEAR_AXES: [Axis; 6] = [Axis::X, Axis::Y, Axis::Z, Axis::U, Axis::V, Axis::W];
/// Rotary axes in slot order.
pub const ROTARY_AXES: [Axis; 3] = [Axis::A, Axis::B, Axis::C];

impl Axis {
    /// Returns the axis of a letter, upper or lower case.
    #[must_use]
    pub fn from_letter(letter: u8) -> Option<Axis> {
        Some(match letter.to_ascii_uppercase() {
            b'X' => Axis::X,
            b'Y' => Axis::Y,
            b'Z' => Axis::Z,
            b'U' => Axis::U,
            b'V' => Axis::V,
            b'W' => Axis::W,
            b'A' => Axis::A,
            b'B' => Axis::B,
            b'C' => Axis::C,
            _ => return None,
        })
    }

    /// Returns its letter, upper case ASCII.
    #[must_use]
    pub fn letter(self) -> u8 {
        b"XYZUVWABC"[self.slot()]
    }

    /// Returns its slot in an [`AxisVector`].
    #[must_use]
    pub fn slot(self) -> usize {
        self as usize
    }

    /// True for A, B, C.
    #[must_use]
    pub fn is_rotary(self) -> bool {
        self >= Axis::A
    }

    /// Returns the spatial direction along which a linear axis moves (X and U: 0, …), or about which a rotary axis rotates.
    #[must_use]
    pub fn dimension(self) -> usize {
        self.slot() % 3
    }
}

impl fmt::Display for Axis {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", char::from(self.letter()))
    }
}

/// Set of axes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct AxisSet(u16);

impl AxisSet {
    /// No axis.
    pub const EMPTY: AxisSet = AxisSet(0);
    /// X, Y and Z.
    pub const XYZ: AxisSet = AxisSet(0b111);
    /// All axes.
    pub const ALL: AxisSet = AxisSet((1 << AXIS_COUNT) - 1);

    /// Adds an axis.
    pub fn insert(&mut self, axis: Axis) {
        self.0 |= 1 << axis.slot();
    }

    /// Removes an axis.
    pub fn remove(&mut self, axis: Axis) {
        self.0 &= !(1 << axis.slot());
    }

    /// True if the axis is in the set.
    #[must_use]
    pub fn contains(self, axis: Axis) -> bool {
        self.0 & (1 << axis.slot()) != 0
    }

    /// True if the set is empty.
    #[must_use]
    pub fn is_empty(self) -> bool {
        self.0 == 0
    }

    /// Returns the axes of both sets together.
    #[must_use]
    pub fn union(self, other: AxisSet) -> AxisSet {
        AxisSet(self.0 | other.0)
    }

    /// Returns the axes that are in both sets.
    #[must_use]
    pub fn intersection(self, other: AxisSet) -> AxisSet {
        AxisSet(self.0 & other.0)
    }

    /// Returns the axes of this set that the other lacks.
    #[must_use]
    pub fn difference(self, other: AxisSet) -> AxisSet {
        AxisSet(self.0 & !other.0)
    }

    /// Returns its axes in slot order.
    pub fn iter(self) -> impl Iterator<Item = Axis> {
        let mut rest = self.0;
        std::iter::from_fn(move || {
            let axis = AXES.get(rest.trailing_zeros() as usize).copied()?;
            rest &= rest - 1;
            Some(axis)
        })
    }
}

impl FromIterator<Axis> for AxisSet {
    fn from_iter<I: IntoIterator<Item = Axis>>(axes: I) -> Self {
        let mut set = AxisSet::EMPTY;
        axes.into_iter().for_each(|axis| set.insert(axis));
        set
    }
}

/// One value per axis: mm for X Y Z U V W, rad for A B C. Axes that a machine lacks are 0.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct AxisVector(pub [f64; AXIS_COUNT]);

impl AxisVector {
    /// All zero.
    pub const ZERO: AxisVector = AxisVector([0.0; AXIS_COUNT]);

    /// Returns the X, Y and Z values as a vector, mm.
    #[must_use]
    pub fn xyz(&self) -> Vector {
        Vector::new(self.0[0], self.0[1], self.0[2])
    }

    /// Replaces the X, Y and Z values, mm.
    pub fn set_xyz(&mut self, xyz: Vector) {
        self.0[..3].copy_from_slice(xyz.as_slice());
    }

    /// Returns the point at `fraction` (0 … 1) of the distance to `end`, every axis linear.
    #[must_use]
    pub fn lerp(&self, end: &AxisVector, fraction: f64) -> AxisVector {
        let mut out = *self;
        for (value, end) in out.0.iter_mut().zip(end.0) {
            *value += (end - *value) * fraction;
        }
        out
    }

    /// Returns the largest magnitude among the given axes.
    #[must_use]
    pub fn max_abs(&self, axes: &[Axis]) -> f64 {
        axes.iter().fold(0.0, |max, &axis| self[axis].abs().max(max))
    }
}

impl FromStr for AxisVector {
    type Err = String;

    /// Reads `X0,Y0,Z100,A90` in mm and degrees and converts it to mm and rad; axes that are not given are zero.
    fn from_str(text: &str) -> Result<AxisVector, String> {
        let mut position = AxisVector::ZERO;
        for part in text.split(',').map(str::trim) {
            let wrong = || format!("'{part}' is not an axis position; write for example X0,Y0,Z100");
            let letter = part.bytes().next().ok_or_else(wrong)?;
            let axis = Axis::from_letter(letter.to_ascii_uppercase()).ok_or_else(wrong)?;
            let number = part.get(1..).map(|number| number.trim_start().trim_start_matches('=').trim());
            let number: f64 = number.and_then(|number| number.parse().ok()).ok_or_else(wrong)?;
            if !number.is_finite() {
                return Err(wrong());
            }
            position[axis] = if axis.is_rotary() { number.to_radians() } else { number };
        }
        Ok(position)
    }
}

impl Index<Axis> for AxisVector {
    type Output = f64;
    fn index(&self, axis: Axis) -> &f64 {
        &self.0[axis.slot()]
    }
}

impl IndexMut<Axis> for AxisVector {
    fn index_mut(&mut self, axis: Axis) -> &mut f64 {
        &mut self.0[axis.slot()]
    }
}

impl Add for AxisVector {
    type Output = AxisVector;
    fn add(mut self, other: AxisVector) -> AxisVector {
        self.0.iter_mut().zip(other.0).for_each(|(a, b)| *a += b);
        self
    }
}

impl Sub for AxisVector {
    type Output = AxisVector;
    fn sub(mut self, other: AxisVector) -> AxisVector {
        self.0.iter_mut().zip(other.0).for_each(|(a, b)| *a -= b);
        self
    }
}

/// The axis and the unit of a value in results: `X_mm` and `C_deg` of positions, `X_um` and `C_urad` of deviations. Keys are in the order of their letters.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct AxisKey {
    letter: char,
    unit: AxisUnit,
}

/// What a value of an axis is in.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum AxisUnit {
    Mm,
    Deg,
    Um,
    Urad,
}

impl AxisKey {
    /// Of a position: mm, or degrees.
    #[must_use]
    pub fn of_position(axis: Axis) -> AxisKey {
        AxisKey::new(axis, [AxisUnit::Mm, AxisUnit::Deg])
    }

    /// Of a deviation or a correction: µm, or µrad.
    #[must_use]
    pub fn of_deviation(axis: Axis) -> AxisKey {
        AxisKey::new(axis, [AxisUnit::Um, AxisUnit::Urad])
    }

    fn new(axis: Axis, [linear, rotary]: [AxisUnit; 2]) -> AxisKey {
        let unit = if axis.is_rotary() { rotary } else { linear };
        AxisKey { letter: char::from(axis.letter()), unit }
    }

    /// The letter of the axis.
    #[must_use]
    pub fn letter(self) -> char {
        self.letter
    }

    /// Whether the value is an angle.
    #[must_use]
    pub fn is_rotary(self) -> bool {
        matches!(self.unit, AxisUnit::Deg | AxisUnit::Urad)
    }

    /// The unit as people write it: `mm`, `°`, `µm`, `µrad`.
    #[must_use]
    pub fn sign(self) -> &'static str {
        match self.unit {
            AxisUnit::Mm => "mm",
            AxisUnit::Deg => "°",
            AxisUnit::Um => "µm",
            AxisUnit::Urad => "µrad",
        }
    }

    /// The unit behind a number in a list of axes, where a length in mm has none: ` µm`, `°`.
    #[must_use]
    pub fn suffix(self) -> &'static str {
        match self.unit {
            AxisUnit::Mm => "",
            AxisUnit::Deg => "°",
            AxisUnit::Um => " µm",
            AxisUnit::Urad => " µrad",
        }
    }

    /// A value in mm or rad in the unit of the key.
    #[must_use]
    pub fn shown(self, value: f64) -> f64 {
        match self.unit {
            AxisUnit::Mm => value,
            AxisUnit::Deg => value.to_degrees(),
            AxisUnit::Um => um_from_mm(value),
            AxisUnit::Urad => urad_from_rad(value),
        }
    }
}

impl fmt::Display for AxisKey {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        let unit = match self.unit {
            AxisUnit::Mm => "mm",
            AxisUnit::Deg => "deg",
            AxisUnit::Um => "um",
            AxisUnit::Urad => "urad",
        };
        write!(out, "{}_{unit}", self.letter)
    }
}

impl Serialize for AxisKey {
    fn serialize<S: Serializer>(&self, out: S) -> Result<S::Ok, S::Error> {
        out.collect_str(self)
    }
}

#[cfg(feature = "schema")]
impl schemars::JsonSchema for AxisKey {
    fn inline_schema() -> bool {
        true
    }

    fn schema_name() -> std::borrow::Cow<'static, str> {
        String::schema_name()
    }

    fn json_schema(generator: &mut schemars::SchemaGenerator) -> schemars::Schema {
        String::json_schema(generator)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_position_names_axes_in_mm_and_degrees() {
        let position: AxisVector = "X-1.5, z100,A90".parse().unwrap();
        assert_eq!((position[Axis::X], position[Axis::Y], position[Axis::Z]), (-1.5, 0.0, 100.0));
        assert!((position[Axis::A] - std::f64::consts::FRAC_PI_2).abs() < 1e-15);
        assert_eq!("X=5".parse::<AxisVector>().unwrap()[Axis::X], 5.0);
        for wrong in ["Q1", "X", "Xinf", "X1,,Y1", "ü1"] {
            assert!(wrong.parse::<AxisVector>().is_err(), "{wrong}");
        }
    }

    #[test]
    fn letters_and_slots_agree() {
        for axis in AXES {
            assert_eq!(Axis::from_letter(axis.letter().to_ascii_lowercase()), Some(axis));
            assert_eq!(axis.is_rotary(), b"ABC".contains(&axis.letter()));
        }
        assert_eq!(Axis::W.dimension(), 2);
        assert_eq!(Axis::B.dimension(), 1);
        assert_eq!(Axis::from_letter(b'S'), None);
    }

    #[test]
    fn a_key_has_the_unit_of_its_axis() {
        let keys = [AxisKey::of_position(Axis::X), AxisKey::of_position(Axis::C), AxisKey::of_deviation(Axis::Z)];
        assert_eq!(keys.map(|key| key.to_string()), ["X_mm", "C_deg", "Z_um"]);
        assert_eq!(keys.map(AxisKey::sign), ["mm", "°", "µm"]);
        let turn = AxisKey::of_deviation(Axis::B);
        assert_eq!((turn.to_string(), turn.sign(), turn.shown(2e-6).round()), ("B_urad".to_owned(), "µrad", 2.0));
    }

    #[test]
    fn keys_are_in_the_order_of_letters() {
        let mut keys = [Axis::X, Axis::C, Axis::A, Axis::Y].map(AxisKey::of_deviation);
        keys.sort();
        assert_eq!(keys.map(AxisKey::letter), ['A', 'C', 'X', 'Y']);
    }
}
