//! Tools: the selected one, the one in the spindle, the active data, and data written by a run in addition to the machine file.

use std::collections::BTreeMap;

use super::fault::{Fault, fault};
use super::radius::Radius;
use ncfix_base::diagnostic::Code;
use ncfix_base::source::Span;
use ncfix_machine::machine::{Machine, Tool};

/// The tool of a channel. `T` identifies a tool; `L` is the active length in the form of the control.
#[derive(Clone, Debug)]
pub(in crate::exec) struct ToolState<T, L> {
    /// The selected tool, before the change.
    pub(in crate::exec) selected: Option<T>,
    /// The tool in the spindle.
    pub(in crate::exec) active: Option<T>,
    /// Active length, mm.
    pub(in crate::exec) length_mm: L,
    /// Active radius, mm.
    pub(in crate::exec) radius_mm: f64,
    /// `true` if the active data have no value in the machine file.
    pub(in crate::exec) assumed: bool,
    /// Index of the head in which it is.
    pub(in crate::exec) head: u16,
}

impl<T, L: Default> Default for ToolState<T, L> {
    fn default() -> Self {
        ToolState { selected: None, active: None, length_mm: L::default(), radius_mm: 0.0, assumed: false, head: 0 }
    }
}

impl<T: Clone, L: Default> ToolState<T, L> {
    /// Puts the selected tool into the spindle; without a selection, the current one stays.
    pub(in crate::exec) fn change(&mut self) {
        if self.selected.is_some() {
            self.active.clone_from(&self.selected);
        }
    }

    /// Activates length and radius; `None` is an unknown tool, for which 0 is used.
    pub(in crate::exec) fn put_size(&mut self, size: Option<(L, f64)>) {
        self.assumed = size.is_none();
        (self.length_mm, self.radius_mm) = size.unwrap_or_default();
    }
}

/// Reports a tool or offset without value in the machine file: an error if nothing may be assumed, otherwise a warning that `used` is used.
pub(in crate::exec) fn without_value(
    requires_values: bool,
    warnings: &mut Vec<Fault>,
    span: Span,
    message: &str,
    used: &str,
    help: &str,
) -> Result<(), Fault> {
    if requires_values {
        return Err(fault(Code::NO_TOOL, span, message, help));
    }
    warnings.push(fault(Code::TOOL_ASSUMED, span, format!("{message}; {used} is used"), help));
    Ok(())
}

/// Length and radius of a cutting edge.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(in crate::exec) struct ToolSize {
    /// L1, L2, L3, mm.
    pub(in crate::exec) length_mm: [f64; 3],
    /// Radius including wear, mm.
    pub(in crate::exec) radius_mm: f64,
    /// The included wear, mm.
    pub(in crate::exec) radius_wear_mm: f64,
}

impl ToolSize {
    /// The data of a tool in the machine file.
    pub(in crate::exec) fn of(tool: &Tool, machine: &Machine) -> Self {
        let wear = machine.radius_wear_mm.get(&(tool.number, tool.edge)).copied().unwrap_or(0.0);
        ToolSize { length_mm: tool.length_mm, radius_mm: tool.radius_mm, radius_wear_mm: wear }
    }

    /// The radius used by compensation, mm.
    pub(in crate::exec) fn compensated_mm(&self, radius: Radius) -> f64 {
        radius.of(self.radius_mm, self.radius_wear_mm)
    }
}

/// Data of a cutting edge in a control.
pub(in crate::exec) trait ToolEntry: Clone + Default {
    /// The data of a tool in the machine file.
    fn of(tool: &Tool, machine: &Machine) -> Self;

    /// Length and radius.
    fn size(&self) -> ToolSize;
}

impl ToolEntry for ToolSize {
    fn of(tool: &Tool, machine: &Machine) -> Self {
        ToolSize::of(tool, machine)
    }

    fn size(&self) -> ToolSize {
        *self
    }
}

/// Tool data written by a run, by number and edge, with priority over the machine file.
#[derive(Clone, Debug, Default)]
pub(in crate::exec) struct ToolTable<E> {
    places: BTreeMap<(u32, u32), usize>,
    /// In the order in which they were first written.
    edges: Vec<((u32, u32), E)>,
}

impl<E: ToolEntry> ToolTable<E> {
    /// An edge written by the run.
    pub(in crate::exec) fn written(&self, number: u32, edge: u32) -> Option<&E> {
        let place = self.places.get(&(number, edge))?;
        self.edges.get(*place).map(|(_, edge)| edge)
    }

    /// All edges written by the run, with number and edge.
    pub(in crate::exec) fn all_written(&self) -> impl ExactSizeIterator<Item = ((u32, u32), &E)> {
        self.edges.iter().map(|(place, edge)| (*place, edge))
    }

    /// An edge from run or machine file.
    pub(in crate::exec) fn find(&self, machine: &Machine, number: u32, edge: u32) -> Option<E> {
        let written = self.written(number, edge).cloned();
        written.or_else(|| machine.tool(number, edge).map(|tool| E::of(tool, machine)))
    }

    /// Length and radius of an edge.
    pub(in crate::exec) fn size(&self, machine: &Machine, number: u32, edge: u32) -> Option<ToolSize> {
        match self.written(number, edge) {
            Some(written) => Some(written.size()),
            None => machine.tool(number, edge).map(|tool| E::of(tool, machine).size()),
        }
    }

    /// Writes an edge.
    pub(in crate::exec) fn write(&mut self, number: u32, edge: u32, entry: E) {
        let new = self.edges.len();
        let place = *self.places.entry((number, edge)).or_insert(new);
        match self.edges.get_mut(place) {
            Some((_, known)) => *known = entry,
            None => self.edges.push(((number, edge), entry)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use ncfix_base::source::{FileId, Source};
    use ncfix_machine::machine::file::{DEMO, MachineFile, read_machine};

    fn demo() -> Machine {
        let source = Source::new(FileId(0), "demo", DEMO.as_bytes().to_vec()).unwrap();
        read_machine(&MachineFile::parse(&source).unwrap()).0.unwrap()
    }

    #[test]
    fn a_tool_is_in_force_when_it_is_changed_to() {
        let mut tool: ToolState<u32, f64> = ToolState::default();
        tool.change();
        assert_eq!(tool.active, None);
        tool.selected = Some(5);
        assert_eq!(tool.active, None);
        tool.change();
        tool.put_size(Some((120.0, 6.0)));
        assert_eq!((tool.active, tool.length_mm, tool.radius_mm, tool.assumed), (Some(5), 120.0, 6.0, false));
        tool.put_size(None);
        assert_eq!((tool.length_mm, tool.radius_mm, tool.assumed), (0.0, 0.0, true));
    }

    #[test]
    fn what_a_run_writes_stands_over_what_the_machine_file_says() {
        let mut machine = demo();
        machine.tools = vec![Tool { number: 3, name: None, edge: 1, length_mm: [80.0, 0.0, 0.0], radius_mm: 4.02 }];
        machine.radius_wear_mm.insert((3, 1), 0.02);
        let mut table: ToolTable<ToolSize> = ToolTable::default();
        let known = table.size(&machine, 3, 1).unwrap();
        assert_eq!(known.length_mm[0], 80.0);
        assert!((known.compensated_mm(Radius::Beside(0.0)) - 4.0).abs() < 1e-12);
        assert_eq!((table.size(&machine, 3, 2), table.written(3, 1)), (None, None));
        for radius_mm in [5.0, 6.0] {
            table.write(3, 1, ToolSize { radius_mm, ..known });
            table.write(1, 2, ToolSize::default());
        }
        assert_eq!(table.size(&machine, 3, 1).map(|size| size.radius_mm), Some(6.0));
        let order: Vec<(u32, u32)> = table.all_written().map(|(place, _)| place).collect();
        assert_eq!(order, [(3, 1), (1, 2)]);
    }
}
