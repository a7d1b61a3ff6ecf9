//! Data that a control saves as assignments: tools (`_TOA`), zero offsets (`_UFR`), R parameters (`_RPA`), global variables (`_GUD`), machine data
//! (`_TEA`, `_INI`). They are read into the machine with the code that executes programs.

use super::startup;
use std::collections::{BTreeMap, BTreeSet};

use super::assign::{assign, assigned};
use super::channel::Channel;
use super::frame_store::{FrameName, settable_code, settable_number};
use super::frame_value::Component;
use super::level::Loaded;
use super::loaded::load;
use super::scope::scope_of;
use super::system_write::{SystemName, assign_system};
use super::value::Value as ExecValue;
use super::variables::List;
use crate::exec::core::fault::{Fault, at};
use crate::exec::core::options::Options;
use crate::syntax::sinumerik::{self, Address, ArgumentRange, Body, ExprId, Node, Section, Value, Word};
use ncfix_base::diagnostic::{Code, Diagnostic};
use ncfix_base::geometry::AxisSet;
use ncfix_base::source::{Source, Span};
use ncfix_machine::describe::contradictions;
use ncfix_machine::machine::zero_offset::lacking_axes;
use ncfix_machine::machine::{Machine, Setting};

/// Archive words without an assignment.
const WITHOUT_EFFECT: &[&str] = &["CHANDATA", "METRIC", "COMPLETE", "NEWCONF", "STOPRE", "RET"];
/// Archive files that are programs and not executed here.
const PROGRAMS: &[&str] = &["MPF", "SPF", "CYC", "COM", "DEF"];
/// Maximum number of elements of one global variable.
const MAX_ELEMENTS: usize = 100_000;

/// Values of a global variable by their indices.
type Elements = BTreeMap<Vec<i64>, Setting>;

/// Applies saved data to a machine. The machine stays unchanged on an error.
#[must_use]
pub(in crate::exec) fn apply_archive(source: &Source, machine: &mut Machine) -> Vec<Diagnostic> {
    let (mut program, mut findings) = sinumerik::parse(source, ncfix_dialect::sinumerik());
    program.keep_whole();
    if findings.iter().any(Diagnostic::is_error) {
        return findings;
    }
    let mut before = machine.clone();
    // Components that an earlier file gave belong to the frame, even if it is not known yet.
    for (name, parts) in &machine.partial_offsets {
        before.zero_offsets.insert(name.clone(), *parts);
    }
    let loaded = load(program, &before.control);
    let mut reader = Reader {
        loaded: &loaded,
        channel: startup::begin(&before, &Options::default(), ncfix_dialect::sinumerik().codes()),
        data: Data::default(),
        unknown: machine.partial_offsets.keys().filter_map(|name| settable_number(name)).collect(),
        by_axis: BTreeMap::new(),
    };
    let is_program = |section: &&Section| PROGRAMS.contains(&section.ending.as_str());
    let sections = &loaded.program.sections;
    if let Some(first) = sections.first().filter(|_| sections.iter().all(|section| is_program(&section))) {
        let span = first.headers.first().copied().unwrap_or_default();
        let message = format!("this header names a program ({}), not saved data: nothing is read", first.ending);
        let help = "save the data at the control as _TOA, _UFR, _RPA, _GUD or _INI, or correct the header";
        findings.push(at(span, Code::UNEXPECTED, message, help).in_file(source.id()));
    }
    let has_words = sections.iter().any(|section| !is_program(&section));
    let mut is_data = false;
    for section in sections {
        if is_program(&section) {
            continue;
        }
        for block in &loaded.program.blocks[section.blocks.clone()] {
            match block.body {
                Body::Words => {
                    for word in loaded.program.words_of(block) {
                        let found = reader.word(word).err().map(|found| fitting(found.in_file(source.id())));
                        // An assignment of a name without a value is an assignment too.
                        let is_assignment = found.as_ref().is_none_or(|found| found.code == Code::UNDEFINED_VARIABLE);
                        is_data |= is_assignment && word.address != Address::Letter(b'M');
                        findings.extend(found);
                    }
                }
                Body::Empty | Body::Faulty | Body::Define { .. } => {}
                _ => {
                    let message = "saved data consist of assignments, but this is a statement";
                    let found = at(
                        block.span,
                        Code::UNEXPECTED,
                        message,
                        "give the program that loads them to ncfix as a program",
                    );
                    findings.push(found.in_file(source.id()));
                }
            }
            reader.channel.outlet.queue.clear();
            reader.channel.outlet.warnings.clear();
        }
    }
    if findings.iter().any(Diagnostic::is_error) {
        // Not one assignment: someone gave the part program, and advice for each of its words would empty it.
        if let Some(first) =
            findings.iter_mut().find(|found| found.code == Code::UNEXPECTED).filter(|_| has_words && !is_data)
        {
            "this file has no assignment: it is a program, not data that the control saved"
                .clone_into(&mut first.message);
            "give it as the program; a set-up is a .toml file, or the saved data of the control"
                .clone_into(&mut first.help);
            return vec![first.clone()];
        }
        return findings;
    }
    let Reader { channel, data, by_axis, .. } = reader;
    let lacking = |(&number, &(axes, span)): (&i64, &(AxisSet, Span))| {
        let name = settable_code(number);
        let (lacking, message) = lacking_axes(&name, before.axis_set(), false, |axis| axes.contains(axis))?;
        let keys: Vec<String> = lacking.iter().map(|axis| format!("$P_UIFR[{number},{axis},TR]")).collect();
        let help = format!("add {} with the value on the control, even if it is 0", keys.join(" and "));
        Some(at(span, Code::PARTIAL_OFFSET, message, &help).in_file(source.id()))
    };
    findings.extend(by_axis.iter().filter_map(lacking));
    findings.extend(contradictions(source.name(), source.bytes(), &before).into_iter().map(|message| {
        let help = "these data have no effect: correct the machine file, or the data on the control";
        Diagnostic::nowhere(Code::CONTRADICTED, message, help)
    }));
    let frames = &channel.system.frames;
    for (number, parts) in frames.written_settable() {
        let name = settable_code(number);
        // The place of the zero does not follow from a fine shift or a rotation alone.
        if by_axis.get(&number).is_some_and(|(axes, _)| axes.intersection(AxisSet::XYZ).is_empty()) {
            machine.partial_offsets.insert(name, parts);
        } else {
            machine.set_zero_offset(name, parts);
        }
    }
    machine.base_frames.extend(frames.written_bases());
    machine.set_tools(channel.system.tools.tools(channel.settings.machine));
    machine.radius_wear_mm.extend(channel.system.tools.radius_wear());
    machine.system.extend(data.system);
    machine.parameters.extend(channel.variables.parameters_in_use());
    machine.gud.extend(data.globals.into_iter().map(|(name, elements)| (name, nested(&elements))));
    findings
}

/// A diagnostic of a word with a help that fits saved data, which have no definitions.
fn fitting(mut found: Diagnostic) -> Diagnostic {
    if found.code == Code::UNDEFINED_VARIABLE {
        "write the number that the control has; names have no value in saved data".clone_into(&mut found.help);
    }
    found
}

/// Data other than frames and tools.
#[derive(Default)]
struct Data {
    system: BTreeMap<String, Setting>,
    globals: BTreeMap<String, Elements>,
}

struct Reader<'a> {
    loaded: &'a Loaded,
    channel: Channel<'a>,
    data: Data,
    /// Settable frames that are not known, although earlier files give components of them.
    unknown: BTreeSet<i64>,
    /// Settable frames of which the file gives components, with the axes that it shifts and the place of the first component.
    by_axis: BTreeMap<i64, (AxisSet, Span)>,
}

impl Reader<'_> {
    fn word(&mut self, word: &Word) -> Result<(), Fault> {
        let program = &self.loaded.program;
        match word.address {
            Address::Letter(b'M') => Ok(()),
            Address::Extended(b'R', index) => {
                let list = assigned(self.loaded, &self.channel, word)?;
                self.channel.variables.set_parameters(i64::from(index), list, word.span)
            }
            Address::Name(name) => {
                let text = program.names.text(name);
                match word.value {
                    _ if text == "INCH" => {
                        let message = "data in inch are not read";
                        Err(at(word.span, Code::NOT_SUPPORTED, message, "save them with the control set to metric"))
                    }
                    Value::None | Value::Arguments(_) if WITHOUT_EFFECT.contains(&text) => Ok(()),
                    Value::Expr(_) | Value::Arguments(_) if text.starts_with('$') => self.system(text, None, word),
                    Value::Expr(_) => self.global(text, None, word),
                    _ => Err(no_assignment(word)),
                }
            }
            Address::Indexed(left) => match program.expr(left).node {
                Node::Indexed(name, range) => {
                    let text = program.names.text(name);
                    if text.starts_with('$') {
                        self.system(text, Some(range), word)
                    } else {
                        self.global(text, Some((range, left)), word)
                    }
                }
                _ => {
                    let list = assigned(self.loaded, &self.channel, word)?;
                    assign(self.loaded, &mut self.channel, left, list, word.span)
                }
            },
            _ => Err(no_assignment(word)),
        }
    }

    fn system(&mut self, name: &str, range: Option<ArgumentRange>, word: &Word) -> Result<(), Fault> {
        let list = assigned(self.loaded, &self.channel, word)?;
        let takes_effect = is_frame_or_tool(name);
        if !takes_effect {
            // Indices may name axes that only the control knows, so they are kept as written.
            let program = &self.loaded.program;
            let mut key = name.to_owned();
            if let Some(range) = range {
                let texts = program.arguments_of(range).iter().map(|slot| match slot {
                    Some(id) => String::from_utf8_lossy(program.source.slice(program.expr(*id).span)).into_owned(),
                    None => String::new(),
                });
                let written = texts.collect::<Vec<_>>().join(",").to_ascii_uppercase();
                key = format!("{name}[{}]", written.replace([' ', '\t', '"'], ""));
            }
            if let List::One(value) = list {
                self.data.system.extend(setting_of(&value).map(|setting| (key, setting)));
            }
            return Ok(());
        }
        let is_nothing = match &list {
            List::One(value) => {
                value.number() == Some(if name_ends_with_scale(self.loaded, range) { 1.0 } else { 0.0 })
            }
            _ => false,
        };
        self.note_axis(name, range, word.span)?;
        let target = SystemName { name, range, span: word.span, step: None };
        match assign_system(self.loaded, &mut self.channel, target, list) {
            // Shift of an axis that is not in the machine file: a spindle, a tool changer.
            Err(found) if is_nothing && matches!(found.code, Code::NO_AXIS | Code::UNDEFINED_VARIABLE) => Ok(()),
            other => other,
        }
    }

    /// Notes the axis of a settable frame that the machine file does not have. A whole frame has all its axes.
    fn note_axis(&mut self, name: &str, range: Option<ArgumentRange>, span: Span) -> Result<(), Fault> {
        let scope = scope_of(self.loaded, &self.channel);
        let Some(FrameName::Settable(number)) = scope.frame_name(name, range, span)? else { return Ok(()) };
        let Ok(component) = range.map(|range| scope.component(range)).transpose() else {
            // An axis that is not in the machine file.
            return Ok(());
        };
        let is_known = self.channel.system.frames.settable(scope.machine, number).is_some();
        let Some((axis, component, _)) = component.flatten() else {
            self.unknown.remove(&number);
            self.by_axis.remove(&number);
            return Ok(());
        };
        if is_known && !self.unknown.contains(&number) && !self.by_axis.contains_key(&number) {
            return Ok(());
        }
        let (axes, _) = self.by_axis.entry(number).or_insert((AxisSet::EMPTY, span));
        if component == Component::Translation {
            axes.insert(axis);
        }
        Ok(())
    }

    fn global(&mut self, name: &str, index: Option<(ArgumentRange, ExprId)>, word: &Word) -> Result<(), Fault> {
        let scope = scope_of(self.loaded, &self.channel);
        let indices = index.map(|(range, left)| scope.indices(range, left)).transpose()?.unwrap_or_default();
        let values = match assigned(self.loaded, &self.channel, word)? {
            List::One(value) => vec![Some(value)],
            List::Set(values) => values,
            List::Repeat(..) => return Err(no_assignment(word)),
        };
        let help = "write one value for each index";
        let elements = self.data.globals.entry(name.to_owned()).or_default();
        for (offset, value) in (0..).zip(values) {
            let Some(value) = value else { continue };
            let mut place = indices.clone();
            if let Some(last) = place.last_mut() {
                *last = last.saturating_add(offset);
            } else if offset > 0 || elements.len() > 1 {
                return Err(at(
                    word.span,
                    Code::BAD_INDEX,
                    format!("{name} is given as a list without an index"),
                    help,
                ));
            }
            let Some(setting) = setting_of(&value) else {
                let message = format!("{name} is a frame; frames are not read");
                return Err(at(word.span, Code::NOT_SUPPORTED, message, "remove it from the file"));
            };
            let is_like = elements.keys().next().is_none_or(|known| known.len() == place.len());
            let is_small = place.len() <= 3 && place.iter().all(|index| (0..MAX_ELEMENTS as i64).contains(index));
            if !is_like || !is_small || elements.len() >= MAX_ELEMENTS {
                return Err(at(word.span, Code::BAD_INDEX, format!("{name} has no such element"), help));
            }
            elements.insert(place, setting);
        }
        Ok(())
    }
}

fn no_assignment(word: &Word) -> Fault {
    at(word.span, Code::UNEXPECTED, "saved data consist of assignments, but this is not one", "remove it from the file")
}

/// `true` if a variable is a zero offset or tool datum.
fn is_frame_or_tool(name: &str) -> bool {
    const FRAMES: &[&str] = &[
        "$P_UIFR",
        "$P_CHBFR",
        "$P_NCBFR",
        "$P_UBFR",
        "$P_PARTFR",
        "$P_SETFR",
        "$P_EXTFR",
        "$P_TOOLFR",
        "$P_WPFR",
        "$P_TRAFR",
        "$P_CYCFR",
    ];
    let is_edge = name.strip_prefix("$TC_DP").is_some_and(|rest| rest.bytes().all(|byte| byte.is_ascii_digit()));
    FRAMES.contains(&name) || is_edge || name == "$TC_TP2"
}

fn name_ends_with_scale(loaded: &Loaded, range: Option<ArgumentRange>) -> bool {
    let last = range.and_then(|range| loaded.program.arguments_of(range).last().copied().flatten());
    last.is_some_and(|id| match loaded.program.expr(id).node {
        Node::Name(name) => loaded.program.names.text(name) == "SC",
        _ => false,
    })
}

fn setting_of(value: &ExecValue) -> Option<Setting> {
    Some(match value {
        ExecValue::Int(value) => Setting::Whole(*value),
        ExecValue::Real(value) => Setting::Number(*value),
        ExecValue::Bool(value) => Setting::Truth(*value),
        ExecValue::Char(value) => Setting::Whole(i64::from(*value)),
        ExecValue::Text(text) => Setting::Text(String::from_utf8_lossy(text).into_owned()),
        ExecValue::Axis(name) => Setting::Text(name.clone()),
        ExecValue::Frame(_) => return None,
    })
}

/// A variable as nested lists; missing elements are 0.
fn nested(elements: &Elements) -> Setting {
    let dimensions = elements.keys().next().map_or(0, Vec::len);
    let length = |level: usize| elements.keys().filter_map(|place| place.get(level)).max().map_or(0, |last| last + 1);
    let lengths: Vec<i64> = (0..dimensions).map(length).collect();
    fill(elements, &lengths, &mut Vec::new(), &mut 0)
}

fn fill(elements: &Elements, lengths: &[i64], place: &mut Vec<i64>, count: &mut usize) -> Setting {
    let Some(&length) = lengths.get(place.len()) else {
        return elements.get(place).cloned().unwrap_or(Setting::Whole(0));
    };
    let mut values = Vec::new();
    for index in 0..length {
        *count += 1;
        if *count > 4 * MAX_ELEMENTS {
            break;
        }
        place.push(index);
        values.push(fill(elements, lengths, place, count));
        place.pop();
    }
    Setting::List(values)
}
