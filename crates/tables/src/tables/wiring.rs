//! Assignment of a control's axis names to the axes of the machine: `AX1`, `X1`, `X`.

use ncfix_base::geometry::{AXES, Axis};
use ncfix_machine::machine::Machine;

/// The machine axes of a control in the order of their numbers.
#[derive(Clone, Debug, PartialEq)]
pub struct Wiring {
    axes: Vec<Named>,
    /// True if the names are numbers in an order that nobody stated.
    is_assumed: bool,
}

/// An axis and its names.
#[derive(Clone, Debug, PartialEq)]
struct Named {
    axis: Axis,
    /// Its name in tables of the control.
    name: String,
    /// Its name in programs, besides its letter.
    other: Option<String>,
    /// True if an option states the name.
    is_stated: bool,
}

/// The default order of axis numbers: linear axes first.
const USUAL: [Axis; 6] = [Axis::X, Axis::Y, Axis::Z, Axis::A, Axis::B, Axis::C];

impl Wiring {
    /// The axes of a machine, numbered in the order of its file, otherwise X Y Z, U V W, A B C as available: `AX1`, `AX2` …
    #[must_use]
    pub fn of(machine: &Machine) -> Wiring {
        let is_left = |axis: &Axis| machine.axis(*axis).is_some() && !machine.axis_order.contains(&Some(*axis));
        let axes = machine.axis_order.iter().copied().chain(AXES.into_iter().filter(is_left).map(Some));
        // An axis of the order that the machine lacks still occupies its number.
        let named = axes.enumerate().filter_map(|(index, axis)| {
            let axis = axis?;
            let data = machine.axis(axis)?;
            Some(Named { axis, name: format!("AX{}", index + 1), other: data.name.clone(), is_stated: false })
        });
        Wiring { axes: named.collect(), is_assumed: machine.axis_order.is_empty() }
    }

    /// The default order, for files that are read without a machine.
    #[must_use]
    pub fn usual() -> Wiring {
        let named = USUAL.into_iter().enumerate();
        Wiring {
            axes: named
                .map(|(index, axis)| Named { axis, name: format!("AX{}", index + 1), other: None, is_stated: false })
                .collect(),
            is_assumed: true,
        }
    }

    /// Renames an axis; another axis with this name loses it.
    pub fn rename(&mut self, axis: Axis, name: &str) {
        self.axes.retain(|named| named.axis == axis || !named.name.eq_ignore_ascii_case(name));
        match self.axes.iter_mut().find(|named| named.axis == axis) {
            Some(named) => (named.name, named.is_stated) = (name.to_owned(), true),
            None => self.axes.push(Named { axis, name: name.to_owned(), other: None, is_stated: true }),
        }
    }

    /// True if one of these axes has a number above 3 that nobody stated. X, Y and Z are nearly always the first three; a spindle can have the number 4.
    #[must_use]
    pub fn assumes(&self, axes: &[Axis]) -> bool {
        let is_late = |(index, named): (usize, &Named)| index >= 3 && axes.contains(&named.axis) && !named.is_stated;
        self.is_assumed && self.axes.iter().enumerate().any(is_late)
    }

    /// The axes with their names, for a remark: `X AX1, Y AX2`.
    #[must_use]
    pub fn listed(&self, axes: &[Axis]) -> String {
        axes.iter().map(|axis| format!("{axis} {}", self.name(*axis))).collect::<Vec<_>>().join(", ")
    }

    /// The axes in order.
    pub fn axes(&self) -> impl Iterator<Item = Axis> {
        self.axes.iter().map(|named| named.axis)
    }

    /// The control's name of an axis.
    #[must_use]
    pub fn name(&self, axis: Axis) -> String {
        let named = self.axes.iter().find(|named| named.axis == axis);
        named.map_or_else(|| axis.to_string(), |named| named.name.clone())
    }

    /// The axis of a name; quotation marks, brackets and blanks around it are ignored.
    #[must_use]
    pub fn axis(&self, text: &str) -> Option<Axis> {
        let bare = text.trim_matches(|c: char| c.is_whitespace() || matches!(c, '(' | ')' | '"' | '\''));
        let is = |name: &str| name.eq_ignore_ascii_case(bare);
        let known = self.axes.iter().find(|named| is(&named.name) || named.other.as_deref().is_some_and(is));
        known.map(|named| named.axis).or_else(|| match bare.as_bytes() {
            [letter] => Axis::from_letter(*letter),
            // X1, Y1 …: the common names of machine axes.
            [letter, b'1'] => Axis::from_letter(*letter),
            _ => None,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_read_with_and_without_marks() {
        let mut wiring = Wiring::usual();
        for (text, axis) in
            [("(AX2)", Axis::Y), ("AX2", Axis::Y), ("\"ax5\"", Axis::B), ("X1", Axis::X), ("C", Axis::C)]
        {
            assert_eq!(wiring.axis(text), Some(axis), "{text}");
        }
        assert_eq!(wiring.axis("AX17"), None);
        wiring.rename(Axis::C, "AX5");
        assert_eq!((wiring.axis("AX5"), wiring.name(Axis::C)), (Some(Axis::C), "AX5".to_owned()));
    }
}
