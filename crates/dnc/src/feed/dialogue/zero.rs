//! Zero offsets for which a program was corrected. A correction depends on the position in the machine, so a control with another offset would get that of
//! another place.

/// Places of [`ZeroValues`]: the axes as controls list them, then the rotation about Z.
pub const ZERO_LETTERS: &[u8; 10] = b"XYZABCUVWR";
/// Values of an offset by [`ZERO_LETTERS`]: mm for linear axes, degrees for rotary axes and for the rotation.
pub type ZeroValues = [f64; 10];

/// Zero offsets that a control should have, and those that it stated when an interrupted job began.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ExpectedZero {
    /// Letters of the axes of the machine; other axes of the control are not compared. Empty: X, Y and Z.
    pub axes: Vec<u8>,
    /// Values by the code of the offset in tenths (G54 is 540): program position plus this is the machine position.
    pub offsets: Vec<(u32, ZeroValues)>,
    /// Codes of the offsets that the program names, in tenths; empty if it names none, so that the one in force counts.
    pub named: Vec<u32>,
    /// True if the program itself may change an offset, for example with G10 or G92: it then differs from an earlier one without a fault.
    pub is_changed_by_program: bool,
    /// True if the program states a tool length or cancels it, so that the one in force at the start does not matter.
    pub states_length: bool,
    /// Statement of the control when the interrupted job began, from its journal.
    pub earlier: Option<String>,
}

impl ExpectedZero {
    /// Returns the code with which the offsets of a program are compared if it names none: G54.
    pub(super) const FIRST: u32 = 540;

    /// Codes of the offsets that the program uses, as far as its text shows.
    #[must_use]
    pub fn used(&self) -> Vec<u32> {
        if self.named.is_empty() { vec![ExpectedZero::FIRST] } else { self.named.clone() }
    }

    /// Returns the offset with this code.
    #[must_use]
    pub fn of(&self, code: u32) -> Option<ZeroValues> {
        self.offsets.iter().find(|(known, _)| *known == code).map(|(_, values)| *values)
    }

    /// True if the axis in this place of [`ZERO_LETTERS`] is compared; the rotation always is.
    pub(super) fn has(&self, slot: usize) -> bool {
        match ZERO_LETTERS.get(slot) {
            Some(b'R') => true,
            Some(letter) if self.axes.is_empty() => b"XYZ".contains(letter),
            Some(letter) => self.axes.contains(letter),
            None => false,
        }
    }

    /// Writes the values of an offset: `X100.000 Y90.000 Z-60.000 A15.000`. The rotation is written if it is not zero, or must be.
    #[must_use]
    pub fn shown(&self, values: &ZeroValues, has_rotation: bool) -> String {
        let mut out = String::new();
        for (slot, (&letter, value)) in ZERO_LETTERS.iter().zip(values).enumerate() {
            let is_wanted = if letter == b'R' { has_rotation || *value != 0.0 } else { self.has(slot) };
            if is_wanted {
                let blank = if out.is_empty() { "" } else { " " };
                out += &format!("{blank}{}{value:.3}", char::from(letter));
            }
        }
        out
    }

    /// Describes what a person compares at a control that cannot be asked: `G54 X100.000 Y90.000 Z-60.000`.
    #[must_use]
    pub fn by_hand(&self) -> String {
        let used = self.used();
        let known = used.iter().map(|&code| match self.of(code) {
            Some(values) => format!("{} {}", name(code), self.shown(&values, false)),
            None => name(code),
        });
        known.collect::<Vec<_>>().join(", ")
    }
}

/// Returns the name of an offset: 540 is `G54`, 591 is `G59.1`.
pub(super) fn name(code: u32) -> String {
    if code.is_multiple_of(10) { format!("G{}", code / 10) } else { format!("G{}.{}", code / 10, code % 10) }
}

/// True if the value in this place is an angle.
pub(super) fn is_angle(slot: usize) -> bool {
    matches!(ZERO_LETTERS.get(slot), Some(b'A' | b'B' | b'C' | b'R'))
}
