//! Tools: their lengths and radii, and their entries in a file.

use super::Machine;
use super::section::Section;
use ncfix_base::diagnostic::{Code, Diagnostic};

/// Cutting edge of a tool.
#[derive(Clone, Debug, PartialEq)]
pub struct Tool {
    /// T number.
    pub number: u32,
    /// T name, if any.
    pub name: Option<String>,
    /// D number.
    pub edge: u32,
    /// Lengths L1, L2, L3 (in G17 along Z, Y, X), including wear and base, mm.
    pub length_mm: [f64; 3],
    /// Radius, mm.
    pub radius_mm: f64,
}

impl Machine {
    /// Returns an edge of a tool.
    #[must_use]
    pub fn tool(&self, number: u32, edge: u32) -> Option<&Tool> {
        self.tools.iter().find(|tool| tool.number == number && tool.edge == edge)
    }

    /// Adds tools and replaces those of the same number and edge.
    pub fn set_tools(&mut self, tools: impl IntoIterator<Item = Tool>) {
        for tool in tools {
            let place = (tool.number, tool.edge);
            self.radius_wear_mm.remove(&place);
            match self.tools.iter_mut().find(|old| (old.number, old.edge) == place) {
                Some(old) => *old = tool,
                None => self.tools.push(tool),
            }
        }
    }
}

/// Reads `[[tool]]` of a machine file or set-up file.
pub(super) fn read(root: &mut Section<'_>, findings: &mut Vec<Diagnostic>) -> Vec<Tool> {
    let mut tools: Vec<Tool> = Vec::new();
    for mut section in root.sections("tool") {
        let number = section.required("number", "1", Section::integer);
        let name = section.text("name").map(str::to_owned);
        let edge = section.integer("edge").unwrap_or(1);
        let length_mm = section.required("length_mm", "120.0", Section::number_or_three);
        let radius_mm = section.number_where("radius_mm", "a number that is not negative", |radius| radius >= 0.0);
        if let (Some(number), Some(length_mm)) = (number, length_mm) {
            if tools.iter().any(|tool| (tool.number, tool.edge) == (number, edge)) {
                let message = format!("tool {number} with edge {edge} is given twice");
                let help = "give the second one another number or edge, or remove it";
                section.report(Code::BAD_VALUE, section.place_of("number"), message, help);
            }
            tools.push(Tool { number, name, edge, length_mm, radius_mm: radius_mm.unwrap_or(0.0) });
        }
        section.finish(findings);
    }
    tools
}
