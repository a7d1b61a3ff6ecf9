//! The data of the control that a guard at the start of the output compares.

use std::collections::BTreeSet;

use ncfix_base::geometry::{Axis, Vector};
use ncfix_dialect::Language;
use ncfix_language::exec;
use ncfix_machine::machine::Tool;
use ncfix_machine::snc::{Kind, WordValue};
use ncfix_path::emit::{self, GuardLines, GuardedData, GuardedTool, GuardedZero};

use super::writing::Writing;
use crate::diagnostics::Diagnostics;
use crate::error::Error;
use crate::machine::Machine;
use crate::program::Program;

/// Lengths closer than this are of one tool, mm.
const SAME_LENGTH_MM: f64 = 1e-9;

/// Executes a program once, and returns the guard for the zero offsets in which it moves and the tools with which it moves.
///
/// # Errors
/// If its language has no words for it.
pub(super) fn of_program(program: &Program, chosen: &Machine, writing: &Writing) -> Result<GuardLines, Error> {
    let dialect = writing.dialect;
    let Some(words) = emit::entry(dialect).and_then(|entry| entry.guard) else {
        return Err(Error::usage(format!(
            "a program in the dialect '{dialect}' cannot compare its zero offsets and tools; do not use --guard"
        )));
    };
    if chosen.machine.control.firmware.is_some() {
        return Err(Error::usage(
            "Grbl and its relatives have no conditions, so a program cannot compare its zero offsets there; do not use --guard, and compare the answer to $# by hand"
                .to_owned(),
        ));
    }
    // Diagnostics are those of the correction itself.
    let mut found = Diagnostics::default();
    let machine = &chosen.machine;
    let Some(opened) = program.open(Some(chosen), &mut found)? else { return Ok(GuardLines::default()) };
    let has_offsets = opened.dialect.language != Language::Sinumerik;
    let mut running = program.start_as(opened, machine, exec::Options { strict: true, ..exec::Options::default() });
    let mut named = NamedTools { has_offsets, ..NamedTools::default() };
    let mut tool_mm = Vector::zeros();
    let mut lengths_mm: Vec<f64> = Vec::new();
    for element in running.by_ref().filter_map(Result::ok) {
        named.see(&element.kind);
        match &element.kind {
            Kind::Setup(setup) => tool_mm = setup.tool_mm,
            Kind::Move(_) if !lengths_mm.contains(&tool_mm.norm()) => lengths_mm.push(tool_mm.norm()),
            _ => {}
        }
    }
    let mut left = Vec::new();
    let unit_mm = writing.writer.increments.unit_mm;
    let mut data =
        GuardedData { unit_mm, is_haas: machine.control.iso.is_haas(), zeros: Vec::new(), tools: Vec::new() };
    for &index in running.extent().zeros() {
        let Some((name, parts)) = machine.zero_offsets.iter().nth(usize::from(index)) else { continue };
        if parts.scale != [1.0; 3] || parts.mirror != [false; 3] {
            left.push(machine.shown_offset(name));
            continue;
        }
        let order = [Axis::X, Axis::Y, Axis::Z, Axis::A, Axis::B, Axis::C, Axis::U, Axis::V, Axis::W];
        let has = machine.axis_set();
        let axes = order.into_iter().filter(|&axis| has.contains(axis)).collect();
        data.zeros.push(GuardedZero { name: name.clone(), axes, shift: parts.shift(), rotation: parts.rotation });
    }
    for tool in &machine.tools {
        let length_mm = Vector::from(tool.length_mm).norm();
        let cuts = lengths_mm.iter().any(|used_mm| (used_mm - length_mm).abs() < SAME_LENGTH_MM);
        if cuts && named.numbers.contains(&tool.number) {
            data.tools.push(GuardedTool { number: tool.number, edge: tool.edge, length_mm: tool.length_mm[0] });
        } else if cuts && named.has(tool) {
            left.push(tool.name.clone().unwrap_or_default());
        }
    }
    let mut guard = words(&data);
    guard.left.extend(left);
    Ok(guard)
}

/// Tools and offsets that a program names.
#[derive(Debug, Default)]
struct NamedTools {
    /// True if H is the number of a length offset.
    has_offsets: bool,
    numbers: BTreeSet<u32>,
    names: BTreeSet<Vec<u8>>,
}

impl NamedTools {
    fn see(&mut self, kind: &Kind) {
        match kind {
            Kind::Tool(WordValue::Number(number)) => {
                self.numbers.insert(*number as u32);
            }
            Kind::Tool(WordValue::Name(name)) => {
                self.names.insert(name.clone());
            }
            // G43 H2 of a Fanuc, in the flat stream a word of its own.
            Kind::Before(words) | Kind::After(words) if self.has_offsets => {
                let offsets = words.iter().filter(|word| word.letter == b'H').filter_map(|word| match word.value {
                    WordValue::Number(number) => Some(number as u32),
                    _ => None,
                });
                self.numbers.extend(offsets);
            }
            Kind::Verbatim(text) => {
                let words = text.split(|&byte| byte == b' ');
                let offset =
                    words.filter_map(|word| std::str::from_utf8(word.strip_prefix(b"H")?).ok()?.parse::<u32>().ok());
                self.numbers.extend(offset);
            }
            _ => {}
        }
    }

    fn has(&self, tool: &Tool) -> bool {
        tool.name.as_ref().is_some_and(|name| self.names.contains(name.as_bytes()))
    }
}
