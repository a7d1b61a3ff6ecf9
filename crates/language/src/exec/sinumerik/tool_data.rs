//! Tool data that a program reads and writes: `$TC_DPn[t,d]` over the tools of the machine file.

use super::modal::Modal;
use ncfix_machine::machine::{Machine, Tool};
use ncfix_machine::snc::WordValue;

/// Edges that a run may write.
const MAX_EDGES: usize = 10_000;
/// Parameters of an edge: `$TC_DP1` to `$TC_DP35`.
const PARAMETERS: usize = 36;

/// `$TC_DP15`.
const RADIUS_WEAR: usize = 15;

/// An edge whose data the run has written.
#[derive(Clone, Debug)]
struct Edge {
    tool: Tool,
    /// By number; `None` where neither file nor program gives a value.
    parameters: [Option<f64>; PARAMETERS],
}

/// Tool data that the run has written.
#[derive(Clone, Debug, Default)]
pub(super) struct ToolData {
    edges: Vec<Edge>,
    names: Vec<(u32, String)>,
}

/// The parameters that a tool of the machine file gives; wear and base of its lengths are in them.
fn parameters_of(tool: &Tool, machine: &Machine) -> [Option<f64>; PARAMETERS] {
    let mut out = [None; PARAMETERS];
    let [first, second, third] = tool.length_mm;
    let wear = machine.radius_wear_mm.get(&(tool.number, tool.edge)).copied().unwrap_or(0.0);
    let radius = if wear == 0.0 { tool.radius_mm } else { ((tool.radius_mm - wear) * 1e9).round() / 1e9 };
    let known = [(3, first), (4, second), (5, third), (6, radius), (RADIUS_WEAR, wear)];
    let zero = [12, 13, 14, 21, 22, 23].map(|number| (number, 0.0));
    for (number, value) in known.into_iter().chain(zero) {
        out[number] = Some(value);
    }
    out
}

impl Edge {
    /// Lengths are geometry, wear and base together, the radius geometry and wear.
    fn refresh(&mut self) {
        let sum = |numbers: &[usize]| numbers.iter().filter_map(|&number| self.parameters[number]).sum::<f64>();
        self.tool.length_mm = [sum(&[3, 12, 21]), sum(&[4, 13, 22]), sum(&[5, 14, 23])];
        self.tool.radius_mm = sum(&[6, 15]);
    }
}

impl ToolData {
    /// The tool of a number or name, as the run has left it.
    pub(super) fn find<'m>(&'m self, machine: &'m Machine, tool: &WordValue, edge: u32) -> Option<&'m Tool> {
        match tool {
            WordValue::Number(number) => self.edge(machine, *number as u32, edge),
            WordValue::Name(name) => self.edge(machine, self.number_of(machine, name)?, edge),
        }
    }

    fn edge<'m>(&'m self, machine: &'m Machine, number: u32, edge: u32) -> Option<&'m Tool> {
        self.written(number, edge).map(|edge| &edge.tool).or_else(|| machine.tool(number, edge))
    }

    fn written(&self, number: u32, edge: u32) -> Option<&Edge> {
        self.edges.iter().find(|known| (known.tool.number, known.tool.edge) == (number, edge))
    }

    /// The number of a tool by its name.
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

    /// Whether a tool of this number is known.
    pub(super) fn exists(&self, machine: &Machine, number: u32) -> bool {
        self.edges.iter().map(|edge| &edge.tool).chain(&machine.tools).any(|tool| tool.number == number)
    }

    /// `$TC_DPn[t,d]`; `None` where nothing gives it a value.
    pub(super) fn parameter(&self, machine: &Machine, number: usize, tool: u32, edge: u32) -> Option<f64> {
        match self.written(tool, edge) {
            Some(known) => known.parameters.get(number).copied().flatten(),
            None => parameters_of(machine.tool(tool, edge)?, machine).get(number).copied().flatten(),
        }
    }

    /// Sets `$TC_DPn[t,d]`; false where there is no such parameter or no room.
    pub(super) fn set_parameter(&mut self, machine: &Machine, number: usize, tool: u32, edge: u32, value: f64) -> bool {
        let place = self.edges.iter().position(|known| (known.tool.number, known.tool.edge) == (tool, edge));
        let place = match place {
            Some(place) => place,
            None if self.edges.len() >= MAX_EDGES => return false,
            None => {
                let known = machine.tool(tool, edge).cloned();
                let parameters = known.as_ref().map_or([None; PARAMETERS], |tool| parameters_of(tool, machine));
                let empty = Tool { number: tool, name: None, edge, length_mm: [0.0; 3], radius_mm: 0.0 };
                self.edges.push(Edge { tool: known.unwrap_or(empty), parameters });
                self.edges.len() - 1
            }
        };
        let Some(known) = self.edges.get_mut(place) else { return false };
        let Some(parameter) = known.parameters.get_mut(number) else { return false };
        *parameter = Some(value);
        known.refresh();
        true
    }

    /// All edges that were written, named.
    pub(super) fn tools(&self) -> impl Iterator<Item = Tool> + '_ {
        self.edges.iter().map(|edge| {
            let mut tool = edge.tool.clone();
            if let Some((_, name)) = self.names.iter().find(|(number, _)| *number == tool.number) {
                tool.name = Some(name.clone());
            }
            tool
        })
    }

    /// Wear in the radii of the edges that were written, mm.
    pub(super) fn radius_wear(&self) -> impl Iterator<Item = ((u32, u32), f64)> + '_ {
        let of = |edge: &Edge| ((edge.tool.number, edge.tool.edge), edge.parameters[RADIUS_WEAR].unwrap_or(0.0));
        self.edges.iter().map(of)
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
    /// The edge in force, as machine file and run give it.
    pub(super) fn tool_in<'m>(&self, tools: &'m ToolData, machine: &'m Machine) -> Option<&'m Tool> {
        tools.find(machine, self.active.as_ref()?, self.edge)
    }
}
