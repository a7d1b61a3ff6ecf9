//! Axis names in addition to the letters: `name = "X1"` in `[axis.X]`.

use super::section::Section;
use super::{AxisData, Machine};
use ncfix_base::diagnostic::Code;
use ncfix_base::geometry::{AXIS_COUNT, Axis};

/// Maximum length of a name in a control.
const LONGEST: usize = 31;

/// Reads the name of an axis, upper case.
pub(super) fn read(axis: Axis, section: &mut Section<'_>) -> Option<String> {
    let name = section.text("name")?.to_ascii_uppercase();
    let bytes = name.as_bytes();
    let is_name = (2..=LONGEST).contains(&bytes.len())
        && bytes.iter().all(|byte| byte.is_ascii_alphanumeric() || *byte == b'_')
        && bytes.first().is_some_and(u8::is_ascii_alphabetic);
    // Such a word is an orientation, a parameter or a spindle word.
    let is_taken = matches!(bytes, [b'A' | b'B' | b'C', b'2' | b'3'])
        || matches!(bytes, [b'R' | b'S' | b'M' | b'H' | b'G' | b'T' | b'D' | b'N' | b'L' | b'I' | b'J' | b'K', rest @ ..] if rest.iter().all(u8::is_ascii_digit));
    if is_name && !is_taken {
        return Some(name);
    }
    let message = format!("\"{name}\" is not a valid axis name");
    let help = format!("write the name that programs use, for example `name = \"{axis}1\"`, or remove the line");
    section.report(Code::BAD_VALUE, section.place_of("name"), message, &help);
    None
}

/// Reports a name that two axes share.
pub(super) fn check(axes: &[Option<AxisData>; AXIS_COUNT], section: &mut Section<'_>) {
    let named: Vec<(Axis, &str)> =
        axes.iter().flatten().filter_map(|data| Some((data.axis, data.name.as_deref()?))).collect();
    for (index, (axis, name)) in named.iter().enumerate() {
        if let Some((first, _)) = named.iter().take(index).find(|(_, other)| other == name) {
            let message = format!("{first} and {axis} have the name \"{name}\"");
            section.report(
                Code::BAD_VALUE,
                section.place_of(&axis.to_string()),
                message,
                "give each axis its own name",
            );
        }
    }
}

impl Machine {
    /// Returns the axis with this name from `[axis.…] name`, upper case.
    #[must_use]
    pub fn axis_named(&self, name: &str) -> Option<Axis> {
        let mut named = self.axes.iter().flatten().filter(|data| data.name.as_deref() == Some(name));
        named.next().map(|data| data.axis)
    }

    /// Returns the axis names for the output, by slot. X, Y and Z are written by their letters, which every control knows.
    #[must_use]
    pub fn written_names(&self) -> [Option<String>; AXIS_COUNT] {
        let mut names = [const { None }; AXIS_COUNT];
        for data in self.axes.iter().flatten().filter(|data| !matches!(data.axis, Axis::X | Axis::Y | Axis::Z)) {
            if let Some(place) = names.get_mut(data.axis.slot()) {
                place.clone_from(&data.name);
            }
        }
        names
    }
}
