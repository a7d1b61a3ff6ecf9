//! System variables that a program reads: those of the execution, those written by the run, and the table of the machine file.

use super::control::System;
use super::variables::setting_value;

use super::expression::Scope;
use super::frame_store::{FrameStore, settable_number};
use super::frame_value::plane_axis;
use super::value::Value;
use crate::exec::core::fault::{Fault, fault};
use crate::exec::core::position::{BEGIN_ABSOLUTE, MEASURE_APART};
use crate::syntax::sinumerik::{ArgumentRange, ExprId};
use ncfix_base::diagnostic::Code;
use ncfix_base::geometry::Axis;
use ncfix_base::units::MM_PER_INCH;
use ncfix_machine::machine::Machine;
use ncfix_machine::snc::WordValue;

/// Maximum number of values written by a run.
const MAX_VALUES: usize = 200_000;

/// Variables with a fixed value on every control that actually runs a program.
const CONSTANTS: &[(&str, f64)] = &[
    ("$P_SIM", 0.0),
    ("$P_ISTEST", 0.0),
    ("$P_DRYRUN", 0.0),
    ("$P_SEARCH", 0.0),
    ("$P_SEARCHL", 0.0),
    ("$MN_SCALING_SYSTEM_IS_METRIC", 1.0),
    ("$MN_SCALING_VALUE_INCH", MM_PER_INCH),
];

/// Prefixes of main-run variables: the control reads them when it reaches them, as with STOPRE.
const MAIN_RUN: &[(&str, &str)] =
    &[("$AA_", "$AA_…"), ("$AC_", "$AC_…"), ("$AN_", "$AN_…"), ("$A_", "$A_…"), ("$VA_", "$VA_…"), ("$VC_", "$VC_…")];

/// Variables that are 0 at the start of a program.
const ZERO_AT_START: &[&str] = &["$AC_MARKER", "$AC_PARAM"];

impl System {
    /// A state without written values.
    pub(super) fn new(strict: bool, machine: &Machine) -> System {
        System { strict, frames: FrameStore::new(machine), ..System::default() }
    }

    /// A main-run variable that was read since the last call.
    pub(super) fn looked(&self) -> Option<&'static str> {
        self.looked.take()
    }

    /// A value written by the run.
    pub(super) fn value(&self, key: &str) -> Option<&Value> {
        self.values.get(key)
    }

    /// Stores a value; `false` if there is no room.
    pub(super) fn set(&mut self, key: String, value: Value) -> bool {
        let has_room = self.values.len() < MAX_VALUES || self.values.contains_key(&key);
        if has_room {
            self.values.insert(key, value);
        }
        has_room
    }
}

impl Scope<'_> {
    /// The name with its indices in the notation of the tables: `$TC_DP6[1,1]`.
    pub(super) fn key(&self, name: &str, range: Option<ArgumentRange>) -> Result<(String, Vec<Value>), Fault> {
        let Some(range) = range else { return Ok((name.to_owned(), Vec::new())) };
        let values: Vec<Value> =
            self.list(range)?.into_iter().map(|value| value.unwrap_or(Value::Text(Vec::new()))).collect();
        let shown: Vec<String> =
            values.iter().map(|value| String::from_utf8_lossy(&value.text()).to_ascii_uppercase()).collect();
        Ok((format!("{name}[{}]", shown.join(",")), values))
    }

    /// Reads a system variable.
    pub(super) fn read_system(&self, name: &str, range: Option<ArgumentRange>, id: ExprId) -> Result<Value, Fault> {
        if let Some(frame) = self.frame_name(name, range, self.program.expr(id).span)? {
            return self.read_frame(frame, range, id);
        }
        if let Some(&(_, shown)) = MAIN_RUN.iter().find(|(start, _)| name.starts_with(start)) {
            self.system.looked.set(Some(shown));
        }
        let (key, indices) = self.key(name, range)?;
        if let Some(value) = self.system.value(&key) {
            return Ok(value.clone());
        }
        if let Some(value) = self.computed(name, &indices, id)? {
            // Data that the program itself has set are the same at the control.
            let is_of_tool = name.starts_with("$TC_DP") || matches!(name, "$P_TOOLL" | "$P_TOOLR");
            if is_of_tool && !self.system.tools.has_written() {
                self.variables.fixed.note(self.program.expr(id).span);
            }
            return Ok(value);
        }
        if let Some(value) = self.machine.system.get(&key).and_then(setting_value) {
            return Ok(value);
        }
        if let Some(&(_, value)) = CONSTANTS.iter().find(|(known, _)| *known == name) {
            return Ok(Value::Real(value));
        }
        if ZERO_AT_START.contains(&name) {
            return Ok(Value::Real(0.0));
        }
        let span = self.program.expr(id).span;
        // Values that the program itself must state, and the machine file cannot.
        match name {
            "$P_EP" => {
                let message = format!("{key} is read, but the position of this axis is not known yet");
                let help = BEGIN_ABSOLUTE;
                return Err(fault(Code::UNKNOWN_START, span, message, help));
            }
            "$P_TOOLR" if self.modal.tool.assumed => return Ok(Value::Real(0.0)),
            "$P_TOOLR" => {
                let message = "the tool radius is read, but no cutting edge is in force";
                return Err(fault(
                    Code::NO_TOOL,
                    span,
                    message,
                    "program T, M6 where the machine needs it, and D first",
                ));
            }
            _ => {}
        }
        let message = format!("{key} is read, but its value is known only to the machine");
        // Results of measuring blocks.
        let help = if ["$AA_MM", "$AA_MW", "$AC_MEA"].iter().any(|start| name.starts_with(start)) {
            MEASURE_APART.to_owned()
        } else {
            format!("add \"{}\" = … to [system] of the machine file", key.replace('"', "\\\""))
        };
        Err(fault(Code::NO_SYSTEM_VALUE, span, message, help).of_variable(key))
    }

    /// Values that the execution itself knows.
    fn computed(&self, name: &str, indices: &[Value], id: ExprId) -> Result<Option<Value>, Fault> {
        let first = indices.first();
        let number = || first.and_then(Value::whole);
        let real = |value: f64| Ok(Some(Value::Real(value)));
        let whole = |value: i64| Ok(Some(Value::Int(value)));
        let of_tool = || number().and_then(|number| u32::try_from(number).ok());
        let tool = self.modal.size_in(&self.system.tools, self.machine);
        match name {
            "$P_AXN1" | "$P_AXN2" | "$P_AXN3" => {
                let place = usize::from(name.as_bytes().last().map_or(0, |digit| digit - b'0'));
                Ok(plane_axis(self.modal.modes.plane, place).map(|axis| Value::Axis(axis.to_string())))
            }
            "$P_EP" | "$AA_IW" | "$AA_IM" | "$AA_IB" => {
                let Some(axis) = first.map(|value| self.axis_in(value, id)).transpose()? else { return Ok(None) };
                Ok(self.position(name, axis))
            }
            "$R" => match number() {
                Some(index) => real(self.variables.parameter(index, self.program.expr(id).span)?),
                None => Ok(None),
            },
            "$P_GG" => Ok(number().and_then(|group| self.member(group)).map(Value::Int)),
            "$P_UIFRNUM" => Ok(settable_number(self.modal.stated.offset()).map(Value::Int)),
            "$P_S" => Ok(self.modal.modes.speed.filter(|_| matches!(number(), None | Some(0 | 1))).map(Value::Real)),
            "$P_F" => {
                real(if self.modal.inch_feed { self.modal.modes.feed / MM_PER_INCH } else { self.modal.modes.feed })
            }
            "$P_MC" => whole(i64::from(self.system.modal_call)),
            "$P_SUBPAR" => Ok(number().and_then(|number| self.variables.is_given(number)).map(Value::Bool)),
            "$P_TOOL" => whole(i64::from(self.modal.edge)),
            "$P_TOOLNO" => Ok(match &self.modal.tool.active {
                Some(WordValue::Number(number)) => Some(Value::Int(*number as i64)),
                Some(WordValue::Name(name)) => {
                    self.system.tools.number_of(self.machine, name).map(|number| Value::Int(i64::from(number)))
                }
                None => None,
            }),
            "$P_TOOLR" => Ok(tool.map(|tool| Value::Real(tool.radius_mm))),
            "$P_TOOLL" => Ok(match (tool, number()) {
                (Some(tool), Some(number @ 1..=3)) => {
                    tool.length_mm.get(number as usize - 1).map(|mm| Value::Real(*mm))
                }
                _ => None,
            }),
            "$P_TOOLEXIST" => Ok(of_tool().map(|number| Value::Bool(self.system.tools.exists(self.machine, number)))),
            "$TC_TP2" => Ok(of_tool()
                .and_then(|number| self.system.tools.name_of(self.machine, number))
                .map(|name| Value::Text(name.as_bytes().to_vec()))),
            _ => match tool_parameter(name, indices) {
                Some((parameter, tool, edge)) => {
                    Ok(self.system.tools.parameter(self.machine, parameter, tool, edge).map(Value::Real))
                }
                None => Ok(None),
            },
        }
    }

    /// The position of an axis in program or machine coordinates; `None` if the program has not stated it.
    fn position(&self, name: &str, axis: Axis) -> Option<Value> {
        let of_machine = matches!(name, "$AA_IM" | "$AA_IB");
        let in_plane = self.modal.modes.plane.axes().into_iter().take(2).any(|known| known == axis);
        if in_plane && self.modal.contour.compensates() && name != "$P_EP" {
            // The position of the tool center depends on the following motion.
            return None;
        }
        let known = self.modal.position.known;
        let known = if of_machine { self.modal.frame().known_across(known, false) } else { known };
        if self.system.strict && !known.contains(axis) {
            return None;
        }
        let command = &self.modal.position.command;
        let position = if of_machine { command[axis] } else { self.modal.setup().programmed(command)[axis] };
        let unit = if self.modal.inch_feed { MM_PER_INCH } else { 1.0 };
        Some(Value::Real(if axis.is_rotary() { position.to_degrees() } else { position / unit }))
    }

    /// Functions that read the channel; `None` for other functions.
    pub(super) fn channel_function(&self, name: &str, arguments: &[Value], id: ExprId) -> Result<Option<Value>, Fault> {
        let span = self.program.expr(id).span;
        match (name, arguments) {
            ("ISAXIS", [number]) => {
                let number = number.whole().ok_or_else(|| self.type_fault(id))?;
                let axis = usize::try_from(number.saturating_sub(1))
                    .ok()
                    .and_then(|slot| [Axis::X, Axis::Y, Axis::Z].get(slot).copied());
                Ok(Some(Value::Bool(axis.is_some_and(|axis| self.machine.axis(axis).is_some()))))
            }
            ("ISVAR", [Value::Text(text)]) => Ok(Some(Value::Bool(self.is_variable(text)))),
            ("GETT", [Value::Text(name)] | [Value::Text(name), _]) => {
                match self.system.tools.number_of(self.machine, name) {
                    Some(number) => Ok(Some(Value::Int(i64::from(number)))),
                    None => {
                        let message = format!("no tool is named \"{}\"", String::from_utf8_lossy(name));
                        let help =
                            "add a [[tool]] entry with this name to the machine file or a file given with --setup";
                        Err(fault(Code::NO_TOOL, span, message, help))
                    }
                }
            }
            ("ISAXIS" | "ISVAR", _) => Err(self.argument_count(name, "1 argument", arguments.len(), id)),
            ("GETT", _) => Err(self.argument_count(name, "a name and a number", arguments.len(), id)),
            _ => {
                let shown: Vec<String> =
                    arguments.iter().map(|value| String::from_utf8_lossy(&value.text()).to_ascii_uppercase()).collect();
                Ok(self.machine.system.get(&format!("{name}({})", shown.join(","))).and_then(setting_value))
            }
        }
    }

    /// `true` if a text names a readable variable.
    fn is_variable(&self, text: &[u8]) -> bool {
        let text = String::from_utf8_lossy(text).trim().to_ascii_uppercase();
        let name = text.split('[').next().unwrap_or_default().trim_end();
        let is_parameter = name.strip_prefix('R').is_some_and(|rest| rest.bytes().all(|byte| byte.is_ascii_digit()));
        is_parameter
            || name.starts_with('$')
            || self.program.names.find(name).is_some_and(|id| self.variables.has(id, name))
            || self.variables.has_global(name)
    }
}

/// Number, tool and edge of `$TC_DPn[t,d]`.
pub(super) fn tool_parameter(name: &str, indices: &[Value]) -> Option<(usize, u32, u32)> {
    let number = name.strip_prefix("$TC_DP")?.parse().ok()?;
    let [tool, edge] = indices else { return None };
    let index = |value: &Value| u32::try_from(value.whole()?).ok();
    Some((number, index(tool)?, index(edge)?))
}
