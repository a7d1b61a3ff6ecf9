//! Tool data that a program reads and writes: `$TC_DPn[t,d]`, in addition to the tools of the machine file.

use super::modal::Modal;
use crate::exec::core::tool::{ToolEntry, ToolSize, ToolTable};
use ncfix_machine::machine::{Machine, Tool};
use ncfix_machine::snc::WordValue;

/// Maximum number of edges written by a run.
const MAX_EDGES: usize = 10_000;
/// Parameters of an edge: `$TC_DP1` to `$TC_DP35`.
const PARAMETERS: usize = 36;

/// `$TC_DP15`.
const RADIUS_WEAR: usize = 15;

/// Data of an edge in the control.
#[derive(Clone, Debug)]
pub(super) struct Edge {
    /// Lengths include geometry, wear and base, the radius geometry and wear.
    size: ToolSize,
    /// By number; `None` if neither file nor program gives a value.
    parameters: [Option<f64>; PARAMETERS],
}

impl Default for Edge {
    fn default() -> Self {
        Edge { size: ToolSize::default(), parameters: [None; PARAMETERS] }
    }
}

impl ToolEntry for Edge {
    fn of(tool: &Tool, machine: &Machine) -> Self {
        Edge { size: ToolSize::of(tool, machine), parameters: parameters_of(tool, machine) }
    }

    fn size(&self) -> ToolSize {
        self.size
    }
}

/// Tool data written by the run.
#[derive(Clone, Debug, Default)]
pub(super) struct ToolData {
    edges: ToolTable<Edge>,
    names: Vec<(u32, String)>,
}

/// The parameters from a tool of the machine file; its lengths include wear and base.
fn parameters_of(tool: &Tool, machine: &Machine) -> [Option<f64>; PARAMETERS] {
    let mut out = [None; PARAMETERS];
    let [first, second, third] = tool.length_mm;
    let wear = ToolSize::of(tool, machine).radius_wear_mm;
    let radius = if wear == 0.0 { tool.radius_mm } else { ((tool.radius_mm - wear) * 1e9).round() / 1e9 };
    let known = [(3, first), (4, second), (5, third), (6, radius), (RADIUS_WEAR, wear)];
    let zero = [12, 13, 14, 21, 22, 23].map(|number| (number, 0.0));
    for (number, value) in known.into_iter().chain(zero) {
        out[number] = Some(value);
    }
    out
}

impl Edge {
    fn refresh(&mut self) {
        let sum = |numbers: &[usize]| numbers.iter().filter_map(|&number| self.parameters[number]).sum::<f64>();
        self.size = ToolSize {
            length_mm: [sum(&[3, 12, 21]), sum(&[4, 13, 22]), sum(&[5, 14, 23])],
            radius_mm: sum(&[6, RADIUS_WEAR]),
            radius_wear_mm: self.parameters[RADIUS_WEAR].unwrap_or(0.0),
        };
    }
}

impl ToolData {
    /// Length and radius of a tool by number or name, with changes by the run.
    pub(super) fn size(&self, machine: &Machine, tool: &WordValue, edge: u32) -> Option<ToolSize> {
        let number = match tool {
            WordValue::Number(number) => *number as u32,
            WordValue::Name(name) => self.number_of(machine, name)?,
        };
        self.edges.size(machine, number, edge)
    }

    /// The number of a tool by name.
    pub(super) fn number_of(&self, machine: &Machine, name: &[u8]) -> Option<u32> {
        let written = self.names.iter().find(|(_, known)| known.as_bytes().eq_ignore_ascii_case(name));
        written.map(|&(number, _)| number).or_else(|| {
            let known = |tool: &&Tool| tool.name.as_deref().unwrap_or_default().as_bytes().eq_ignore_ascii_case(name);
            machine.tools.iter().find(known).map(|tool| tool.number)
        })
    }

    /// The name of a tool.
    pub(super) fn name_of<'m>(&'m self, machine: &'m Machine, number: u32) -> Option<&'m str> {
        let written = self.names.iter().find(|(known, _)| *known == number).map(|(_, name)| name.as_str());
        written.or_else(|| machine.tools.iter().find(|tool| tool.number == number)?.name.as_deref())
    }

    /// `true` if a tool of this number is known.
    pub(super) fn exists(&self, machine: &Machine, number: u32) -> bool {
        let written = self.edges.all_written().map(|((tool, _), _)| tool);
        written.chain(machine.tools.iter().map(|tool| tool.number)).any(|known| known == number)
    }

    /// `$TC_DPn[t,d]`; `None` if it has no value.
    pub(super) fn parameter(&self, machine: &Machine, number: usize, tool: u32, edge: u32) -> Option<f64> {
        self.edges.find(machine, tool, edge)?.parameters.get(number).copied().flatten()
    }

    /// True if the program has set tool data.
    pub(super) fn has_written(&self) -> bool {
        self.edges.all_written().len() > 0
    }

    /// Sets `$TC_DPn[t,d]`; `false` if the parameter does not exist or there is no room.
    pub(super) fn set_parameter(&mut self, machine: &Machine, number: usize, tool: u32, edge: u32, value: f64) -> bool {
        if self.edges.written(tool, edge).is_none() && self.edges.all_written().len() >= MAX_EDGES {
            return false;
        }
        let mut entry = self.edges.find(machine, tool, edge).unwrap_or_default();
        let Some(parameter) = entry.parameters.get_mut(number) else { return false };
        *parameter = Some(value);
        entry.refresh();
        self.edges.write(tool, edge, entry);
        true
    }

    /// All written edges, as tools with names.
    pub(super) fn tools<'m>(&'m self, machine: &'m Machine) -> impl Iterator<Item = Tool> + 'm {
        self.edges.all_written().map(|((number, edge), entry)| {
            let written = self.names.iter().find(|(known, _)| *known == number).map(|(_, name)| name.clone());
            let name = written.or_else(|| machine.tool(number, edge)?.name.clone());
            let ToolSize { length_mm, radius_mm, .. } = entry.size;
            Tool { number, name, edge, length_mm, radius_mm }
        })
    }

    /// Wear in the radii of the written edges, mm.
    pub(super) fn radius_wear(&self) -> impl Iterator<Item = ((u32, u32), f64)> + '_ {
        self.edges.all_written().map(|(place, entry)| (place, entry.size.radius_wear_mm))
    }

    /// Sets `$TC_TP2[t]`.
    pub(super) fn set_name(&mut self, tool: u32, name: String) {
        self.names.retain(|(known, _)| *known != tool);
        if self.names.len() < MAX_EDGES {
            self.names.push((tool, name));
        }
    }
}

impl Modal {
    /// Length and radius of the active edge, from machine file and run.
    pub(super) fn size_in(&self, tools: &ToolData, machine: &Machine) -> Option<ToolSize> {
        tools.size(machine, self.tool.active.as_ref()?, self.edge)
    }
}
