//! Tables of the control: tool memory, zero offsets, parameters and points, in the transfer of the program or in separate files.
//!
//! Each line holds one entry as words: `T5 L120.5 R6 L4=0 R4=-0.02`, `G54 X100 Y50 Z0` or `G54 I3 …` or `N54 …`, `E10=5`, `P1 X20 Y30`.
//! Words that do not concern positions are skipped. Lengths are mm.

use super::expression::Parameters;
use super::frames::entry_name;
use super::modal::Modal;
use super::modal::Point;
use super::tool::place;
use crate::exec::core::tool::{ToolSize, ToolTable};
use crate::syntax::words::{self, Address, Block, PartKind, Program, Value};
use ncfix_base::diagnostic::{Code, Diagnostic, Place};
use ncfix_base::geometry::{Axis, AxisSet, AxisVector, FrameParts};
use ncfix_base::source::Source;
use ncfix_base::source::Span;
use ncfix_machine::machine::zero_offset::{foreign_axis, lacking_axes};
use ncfix_machine::machine::{Machine, Tool};

/// Axes of entries.
const AXES: [Axis; 6] = [Axis::X, Axis::Y, Axis::Z, Axis::A, Axis::B, Axis::C];

/// Content of the tables of a file.
#[derive(Debug, Default)]
pub(super) struct Tables {
    pub(super) offsets: Vec<TableOffset>,
    pub(super) tools: Vec<Tool>,
    /// Radius wear by number and edge, mm.
    pub(super) radius_wear: Vec<((u32, u32), f64)>,
    pub(super) parameters: Vec<(usize, f64)>,
    pub(super) points: Vec<(u32, Point)>,
    /// Lines without recognized content.
    pub(super) unread: Vec<Block>,
}

/// A zero offset with the axes that its line names.
#[derive(Debug)]
pub(super) struct TableOffset {
    name: String,
    parts: FrameParts,
    named: AxisSet,
    span: Span,
}

/// Words of a line with their values.
struct Line(Vec<(u8, Option<u16>, f64)>);

impl Line {
    fn of(program: &Program, block: &Block) -> Line {
        let word = |word: &words::Word| {
            let (letter, index) = match word.address {
                Address::Letter(letter) => (letter, None),
                Address::Indexed(letter, index) => (letter, Some(index)),
                _ => return None,
            };
            match word.value {
                Value::Number { value, .. } => Some((letter, index, value)),
                _ => None,
            }
        };
        Line(program.words_of(block).iter().filter_map(word).collect())
    }

    fn get(&self, letter: u8, index: Option<u16>) -> Option<f64> {
        self.0.iter().find(|word| (word.0, word.1) == (letter, index)).map(|word| word.2)
    }

    /// Axis words, mm and rad.
    fn position(&self) -> (AxisVector, AxisSet) {
        let (mut values, mut named) = (AxisVector::ZERO, AxisSet::EMPTY);
        for axis in AXES {
            if let Some(value) = self.get(axis.letter(), None) {
                values[axis] = if axis.is_rotary() { value.to_radians() } else { value };
                named.insert(axis);
            }
        }
        (values, named)
    }

    fn tool(&self) -> Option<Tool> {
        let number = self.get(b'T', None).filter(|number| (0.0..1e8).contains(number))?;
        let (number, edge) = place(number);
        let sum = |letter: u8| {
            let own = self.get(letter, None)?;
            Some(own + self.get(letter, Some(4)).unwrap_or(0.0))
        };
        let length_mm = [sum(b'L').unwrap_or(0.0), 0.0, 0.0];
        Some(Tool { number, name: None, edge, length_mm, radius_mm: sum(b'R').unwrap_or(0.0) })
    }

    fn offset(&self, block: &Block) -> Option<TableOffset> {
        let entry = self.get(b'G', None).or_else(|| block.number.map(f64::from))?;
        let name = match self.get(b'I', None) {
            Some(index) if entry == 54.0 => format!("G54 I{index}"),
            _ => entry_name(entry)?,
        };
        let (translation, named) = self.position();
        let mut parts = FrameParts::from(translation);
        let angle = self.get(b'B', Some(4));
        if let Some(angle) = angle {
            // About the tool axis of G17.
            parts.rotation[2] = angle.to_radians();
        }
        (!named.is_empty() || angle.is_some()).then_some(TableOffset { name, parts, named, span: block.span })
    }

    fn point(&self) -> Option<(u32, Point)> {
        let number = self.get(b'P', None).filter(|number| (0.0..1e4).contains(number))?;
        let (values, named) = self.position();
        // Within range.
        Some((number as u32, Point { values, named }))
    }
}

/// Reads the tables of a file.
pub(super) fn read(program: &Program) -> Tables {
    let mut tables = Tables::default();
    for part in &program.parts {
        for block in program.blocks.range(part.blocks.clone()) {
            let line = Line::of(program, block);
            let is_read = match part.kind {
                PartKind::Tools => {
                    let tool = line.tool();
                    let wear = |tool: &Tool| ((tool.number, tool.edge), line.get(b'R', Some(4)).unwrap_or(0.0));
                    tables.radius_wear.extend(tool.as_ref().map(wear));
                    tool.map(|tool| tables.tools.push(tool)).is_some()
                }
                PartKind::ZeroOffsets => line.offset(block).map(|offset| tables.offsets.push(offset)).is_some(),
                PartKind::Points => line.point().map(|point| tables.points.push(point)).is_some(),
                PartKind::Parameters => {
                    let found = line.0.iter().filter_map(|&(letter, index, value)| {
                        let index = index.filter(|_| letter == b'E')?;
                        Some((usize::from(index), value))
                    });
                    let before = tables.parameters.len();
                    tables.parameters.extend(found);
                    tables.parameters.len() > before
                }
                _ => true,
            };
            let has_words = !program.words_of(block).is_empty();
            if !is_read && has_words {
                tables.unread.push(*block);
            }
        }
    }
    tables
}

/// Applies the tables of a control file to the machine, and reports unrecognized content.
pub(in crate::exec) fn apply(
    source: &Source,
    dialect: &'static ncfix_dialect::Dialect,
    machine: &mut Machine,
) -> Vec<Diagnostic> {
    let (program, mut findings) = words::parse(source, dialect);
    let tables = read(&program);
    for block in &tables.unread {
        findings.push(Diagnostic::at(
            Code::UNEXPECTED,
            Place { file: source.id(), span: block.span },
            "this table line has no known entry",
            "entries are T5 L… R…, G54 X… Y… Z…, E10=…",
        ));
    }
    let foreign = tables.offsets.iter().find_map(|offset| foreign_axis(&offset.name, &offset.parts, machine));
    if let Some(found) = foreign {
        findings.push(found);
        return findings;
    }
    machine.set_tools(tables.tools);
    machine.radius_wear_mm.extend(tables.radius_wear);
    for TableOffset { name, parts, named, span } in tables.offsets {
        if let Some((lacking, message)) = lacking_axes(&name, machine.axis_set(), false, |axis| named.contains(axis)) {
            let letters: Vec<String> = lacking.iter().map(ToString::to_string).collect();
            let help = format!("add {} with the value on the control, even if it is 0", letters.join(" and "));
            findings.push(Diagnostic::at(Code::PARTIAL_OFFSET, Place { file: source.id(), span }, message, help));
        }
        machine.set_zero_offset(name, parts);
    }
    for (number, value) in tables.parameters {
        if let Ok(number) = i64::try_from(number) {
            machine.parameters.insert(number, value);
        }
    }
    findings
}

/// Applies control tables that accompany the program.
pub(super) fn take_tables(
    modal: &mut Modal,
    tools: &mut ToolTable<ToolSize>,
    parameters: &mut Parameters,
    tables: Tables,
) {
    modal.frames.table.extend(tables.offsets.into_iter().map(|offset| (offset.name, offset.parts)));
    for (tool, (_, radius_wear_mm)) in tables.tools.into_iter().zip(tables.radius_wear) {
        let Tool { number, edge, length_mm, radius_mm, .. } = tool;
        tools.write(number, edge, ToolSize { length_mm, radius_mm, radius_wear_mm });
    }
    for (number, value) in tables.parameters {
        // An invalid number is reported where the program uses it.
        let _ = parameters.set(number, value, Span::default());
    }
    modal.points.extend(tables.points);
}
