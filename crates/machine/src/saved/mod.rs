//! Files in which controls save zero offsets and tools: one reader for each format, found by the content of the file.
//!
//! The saved data of a Sinumerik and the tables of Grundig, Philips and `MillPlus` are not here: the executors of their languages read them.

mod fanuc;
mod grbl;
mod haas;
mod heidenhain;
mod lines;
mod linuxcnc_tools;
mod linuxcnc_variables;
pub mod zero_shift;

use std::collections::BTreeMap;

use crate::machine::zero_offset::foreign_axis;
use crate::machine::{Machine, Setting, Tool};
use ncfix_base::diagnostic::Diagnostic;
use ncfix_base::geometry::FrameParts;
use ncfix_base::source::Source;

use lines::{SavedLine, SavedUnit, lines};

/// Format of a file that a control saves.
#[derive(Clone, Copy, Debug)]
pub struct SavedFormat {
    /// Name in messages: `LinuxCNC tool table`.
    pub name: &'static str,
    /// Language of the control; empty if the file suits any.
    pub language: &'static str,
    /// True if the lines have the marks of the format.
    is: fn(&[SavedLine<'_>]) -> bool,
    /// Reads the lines.
    read: fn(&[SavedLine<'_>], &Machine) -> Result<SavedValues, Diagnostic>,
}

/// Formats, in the order in which their marks are searched.
pub const FORMATS: &[SavedFormat] = &[
    heidenhain::FORMAT,
    grbl::FORMAT,
    linuxcnc_variables::FORMAT,
    linuxcnc_tools::FORMAT,
    haas::FORMAT,
    fanuc::FORMAT,
];

/// Values of a file.
#[derive(Debug, Default)]
struct SavedValues {
    offsets: Vec<(String, FrameParts)>,
    /// Offsets without a shift of X, Y and Z.
    partial_offsets: Vec<(String, FrameParts)>,
    tools: Vec<Tool>,
    /// Radius wear by tool number, mm.
    wear_mm: Vec<(u32, f64)>,
    system: Vec<(String, f64)>,
    warnings: Vec<Diagnostic>,
}

impl SavedValues {
    /// The name of an offset or a tool that the file has twice, with different values: the control has only one of them.
    fn contradiction(&self) -> Option<String> {
        let mut offsets: BTreeMap<&str, &FrameParts> = BTreeMap::new();
        for (name, parts) in &self.offsets {
            if offsets.insert(name, parts).is_some_and(|other| other != parts) {
                return Some(name.clone());
            }
        }
        let mut tools: BTreeMap<(u32, u32), &Tool> = BTreeMap::new();
        let differs = |one: &Tool, other: &Tool| (one.length_mm, one.radius_mm) != (other.length_mm, other.radius_mm);
        for tool in &self.tools {
            if tools.insert((tool.number, tool.edge), tool).is_some_and(|other| differs(tool, other)) {
                return Some(format!("tool {}", tool.number));
            }
        }
        None
    }
}

/// Returns the format of a file; `None` if no row of [`FORMATS`] fits.
#[must_use]
pub fn recognized(source: &Source) -> Option<&'static SavedFormat> {
    let lines = lines(source);
    FORMATS.iter().find(|format| (format.is)(&lines))
}

/// Applies a file to a machine: its offsets and tools replace those of the same name or number. The machine stays unchanged on an error, whose message names
/// the format.
#[must_use]
pub fn apply_saved(format: &SavedFormat, source: &Source, machine: &mut Machine) -> Vec<Diagnostic> {
    let lines = lines(source);
    let named = |mut found: Diagnostic| {
        found.message = format!("{}: {}", format.name, found.message);
        vec![found]
    };
    if !format.language.is_empty() && !format.language.eq_ignore_ascii_case(&machine.controller) {
        let message = format!("this file is not for a control with controller = \"{}\"", machine.controller);
        let help =
            format!("give a file of this control, or correct controller = \"{}\" in the machine file", format.language);
        let fault = lines.first().map_or_else(
            || Diagnostic::nowhere(ncfix_base::diagnostic::Code::BAD_VALUE, message.clone(), help.clone()),
            |line| line.fault(message.clone(), help.clone()),
        );
        return named(fault);
    }
    let values = match (format.read)(&lines, machine) {
        Ok(values) => values,
        Err(found) => return named(found),
    };
    if let (Some(twice), Some(first)) = (values.contradiction(), lines.first()) {
        let help = "remove the line that is not in force, or save the file again";
        return named(first.fault(format!("the file has two different values of {twice}"), help));
    }
    let mut offsets = values.offsets.iter().chain(&values.partial_offsets);
    if let Some(found) = offsets.find_map(|(name, parts)| foreign_axis(name, parts, machine)) {
        return named(found);
    }
    for (name, parts) in values.offsets {
        machine.set_zero_offset(name, parts);
    }
    machine.partial_offsets.extend(values.partial_offsets);
    machine.set_tools(values.tools);
    machine.radius_wear_mm.extend(values.wear_mm.into_iter().map(|(number, wear_mm)| ((number, 1), wear_mm)));
    machine.system.extend(values.system.into_iter().map(|(name, value)| (name, Setting::Number(value))));
    values.warnings.into_iter().flat_map(named).collect()
}
