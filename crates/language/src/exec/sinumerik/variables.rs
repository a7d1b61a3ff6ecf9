//! R parameters and global variables, which live for the run, and DEF variables, which live for their program level.

use std::collections::{BTreeMap, HashMap};

use super::cells::{Cells, wrong_type};
use super::functions::is_function;
use super::value::Value;
use crate::exec::core::assumed_values::AssumedValues;
use crate::exec::core::fault::{Fault, fault};
use crate::exec::core::fixed_values::FixedValues;
use crate::exec::core::options::Options;
use crate::syntax::sinumerik::{DefinitionType, NameId};
use ncfix_base::diagnostic::Code;
use ncfix_base::source::Span;
use ncfix_machine::machine::{Machine, Setting};

/// R0 … R9999.
const PARAMETERS: usize = 10_000;
/// Maximum number of elements of all variables of one program level.
const MAX_LOCAL: usize = 100_000;
/// Maximum number of elements of all global variables.
const MAX_GLOBAL: usize = 1_000_000;

/// Definition of a variable.
#[derive(Clone, Copy, Debug)]
pub(super) struct Shape<'a> {
    pub(super) kind: DefinitionType,
    /// `n` of `STRING[n]`.
    pub(super) string: Option<i64>,
    /// Lengths of an array; empty for a single value.
    pub(super) dimensions: &'a [i64],
}

/// Values assigned from an index on.
#[derive(Clone, Debug)]
pub(super) enum List {
    /// One value.
    One(Value),
    /// `SET(1,,3)`
    Set(Vec<Option<Value>>),
    /// `REP(0)`, `REP(0,5)`
    Repeat(Value, Option<i64>),
}

/// DEF variables of one program level.
#[derive(Clone, Debug, Default)]
pub(super) struct Locals {
    variables: Vec<(NameId, Cells)>,
    elements: usize,
    /// Bit set of the first parameters: a bit is set if the call gave a value.
    given: u64,
}

impl Locals {
    /// Removes variables and returns them under other names.
    pub(super) fn lend(&mut self, names: &[(NameId, NameId)]) -> Locals {
        let mut lent = Locals { given: self.given, ..Locals::default() };
        for &(own, other) in names {
            if let Some(place) = self.variables.iter().position(|(name, _)| *name == own) {
                let (_, cells) = self.variables.swap_remove(place);
                lent.variables.push((other, cells));
            }
        }
        lent
    }
}

/// All variables that a block can access.
pub(super) struct Variables {
    parameters: Vec<f64>,
    /// Parameters set by the machine file, saved data or the program: others contain values of an earlier program.
    stated: Vec<bool>,
    /// `true` if such other parameters must not be read.
    strict: bool,
    /// Those that were read nevertheless, as 0.
    pub(super) assumed: AssumedValues,
    /// Values of the control that positions and conditions use.
    pub(super) fixed: FixedValues,
    locals: Locals,
    globals: HashMap<String, Cells>,
    global_elements: usize,
    /// Values of global variables from the machine file, independent of their definition.
    presets: BTreeMap<String, Setting>,
}

impl Variables {
    /// Global variables and R parameters with the values of the machine.
    pub(super) fn new(machine: &Machine, options: &Options) -> Self {
        let presets = &machine.gud;
        let mut variables = Variables {
            parameters: vec![0.0; PARAMETERS],
            stated: vec![false; PARAMETERS],
            strict: options.strict,
            assumed: AssumedValues::new(options.tells_assumed),
            fixed: FixedValues::default(),
            locals: Locals::default(),
            globals: HashMap::new(),
            global_elements: 0,
            presets: presets.clone(),
        };
        // A number beyond the R parameters of this control has no effect.
        for (&index, &value) in &machine.parameters {
            let _ = variables.set_parameter(index, value, Span::default());
        }
        for (key, setting) in &machine.system {
            let index = key.strip_prefix("$R[").and_then(|rest| rest.strip_suffix(']')?.parse().ok());
            if let (Some(index), Some(value)) = (index, setting_value(setting).and_then(|value| value.number())) {
                let _ = variables.set_parameter(index, value, Span::default());
            }
        }
        for (name, setting) in presets {
            let (kind, dimensions) = kind_of(setting);
            let shape = Shape { kind, string: None, dimensions: &dimensions };
            // Its type is derived from its value; a value too large for the store stays undefined.
            let _ = variables.define_global(name, shape, None, Span::default());
        }
        variables
    }

    /// R parameters that were set.
    pub(super) fn parameters_in_use(&self) -> impl Iterator<Item = (i64, f64)> + '_ {
        let set = self.parameters.iter().copied().zip(self.stated.iter().copied());
        (0..).zip(set).filter(|(_, (_, is_stated))| *is_stated).map(|(index, (value, _))| (index, value))
    }

    /// Installs the variables of another level and returns the previous ones.
    pub(super) fn exchange(&mut self, locals: Locals) -> Locals {
        std::mem::replace(&mut self.locals, locals)
    }

    /// Restores lent variables.
    pub(super) fn take_back(&mut self, lent: Locals, names: &[(NameId, NameId)]) {
        for (other, cells) in lent.variables {
            let own = names.iter().find(|(_, name)| *name == other).map(|(own, _)| *own);
            self.locals.variables.extend(own.map(|own| (own, cells)));
        }
    }

    /// Records the parameters with a value from the call.
    pub(super) fn set_given(&mut self, given: u64) {
        self.locals.given = given;
    }

    /// `true` if the call gave a value for the parameter with a number, from 1.
    pub(super) fn is_given(&self, number: i64) -> Option<bool> {
        let place = u32::try_from(number - 1).ok().filter(|place| *place < u64::BITS)?;
        Some(self.locals.given >> place & 1 == 1)
    }

    /// The value of an R parameter. A parameter that is never set keeps the value of an earlier program.
    pub(super) fn parameter(&self, index: i64, span: Span) -> Result<f64, Fault> {
        let is_left_over = slot(index).and_then(|slot| self.stated.get(slot)) == Some(&false);
        if is_left_over && !self.strict {
            self.assumed.note(index, span);
        } else if is_left_over {
            let message = format!("R{index} keeps its value between programs, and this program has not set it");
            let help = format!(
                "set it in the program, add \"$R[{index}]\" = … to [system] of the machine file, or give --setup the R parameters that the control has saved"
            );
            return Err(fault(Code::NO_SYSTEM_VALUE, span, message, help).of_variable(format!("R{index}")));
        }
        slot(index).and_then(|slot| self.parameters.get(slot)).copied().ok_or_else(|| bad_parameter(index, span))
    }

    /// Sets an R parameter.
    pub(super) fn set_parameter(&mut self, index: i64, value: f64, span: Span) -> Result<(), Fault> {
        let place =
            slot(index).and_then(|slot| self.parameters.get_mut(slot)).ok_or_else(|| bad_parameter(index, span))?;
        *place = value;
        if let Some(is_stated) = slot(index).and_then(|slot| self.stated.get_mut(slot)) {
            *is_stated = true;
        }
        Ok(())
    }

    /// Sets R parameters from an index on.
    pub(super) fn set_parameters(&mut self, index: i64, list: List, span: Span) -> Result<(), Fault> {
        let number = |value: &Value| {
            let message = "an R parameter holds a number";
            value.number().ok_or_else(|| fault(Code::TYPE_MISMATCH, span, message, "assign a number"))
        };
        match list {
            List::One(value) => self.set_parameter(index, number(&value)?, span),
            List::Set(values) => {
                for (offset, value) in (0..).zip(values) {
                    if let Some(value) = value {
                        self.set_parameter(index.saturating_add(offset), number(&value)?, span)?;
                    }
                }
                Ok(())
            }
            List::Repeat(value, count) => {
                let end = count.map_or(PARAMETERS as i64, |count| index.saturating_add(count.max(0)));
                let value = number(&value)?;
                for index in index..end.min(PARAMETERS as i64) {
                    self.set_parameter(index, value, span)?;
                }
                Ok(())
            }
        }
    }

    /// The cells of a variable of this level, otherwise of a global one.
    pub(super) fn cells(&self, name: NameId, text: &str) -> Option<&Cells> {
        let local = self.locals.variables.iter().find(|(known, _)| *known == name).map(|(_, cells)| cells);
        local.or_else(|| if self.globals.is_empty() { None } else { self.globals.get(text) })
    }

    fn cells_mut(&mut self, name: NameId, text: &str) -> Option<&mut Cells> {
        let local = self.locals.variables.iter_mut().find(|(known, _)| *known == name).map(|(_, cells)| cells);
        if local.is_some() || self.globals.is_empty() { local } else { self.globals.get_mut(text) }
    }

    /// `true` if there is a global variable of this name.
    pub(super) fn has_global(&self, text: &str) -> bool {
        self.globals.contains_key(text)
    }

    /// `true` if there is a variable of this name.
    pub(super) fn has(&self, name: NameId, text: &str) -> bool {
        self.cells(name, text).is_some()
    }

    /// Defines a variable of this level.
    pub(super) fn define(
        &mut self,
        name: NameId,
        text: &str,
        shape: Shape<'_>,
        value: Option<List>,
        span: Span,
    ) -> Result<(), Fault> {
        self.check_new(name, text, span)?;
        let left = MAX_LOCAL - self.locals.elements;
        let mut cells = Cells::new(shape.kind, shape.string, shape.dimensions, left, (text, span))?;
        initialise(&mut cells, value, (text, span))?;
        self.locals.elements += cells.count();
        self.locals.variables.push((name, cells));
        Ok(())
    }

    /// Checks that a name is free, and distinct from an address.
    fn check_new(&self, name: NameId, text: &str, span: Span) -> Result<(), Fault> {
        // A single letter is read as a variable in expressions; a letter and a digit are an address with extension.
        if matches!(text.as_bytes(), [first, second, ..] if first.is_ascii_alphabetic() && second.is_ascii_digit()) {
            let message = format!("{text} cannot be distinguished from an address");
            return Err(fault(Code::DUPLICATE_NAME, span, message, "begin the name with two letters or underscores"));
        }
        if self.locals.variables.iter().any(|(known, _)| *known == name) || is_function(text) {
            return Err(fault(Code::DUPLICATE_NAME, span, format!("{text} is already in use"), "choose another name"));
        }
        Ok(())
    }

    /// Defines a variable of this level with existing content: a parameter.
    pub(super) fn define_cells(&mut self, name: NameId, text: &str, cells: Cells, span: Span) -> Result<(), Fault> {
        self.check_new(name, text, span)?;
        if cells.count() > MAX_LOCAL - self.locals.elements {
            let message = format!("{text} has more elements than the {MAX_LOCAL} of a program");
            return Err(fault(Code::BAD_INDEX, span, message, "make the array smaller"));
        }
        self.locals.elements += cells.count();
        self.locals.variables.push((name, cells));
        Ok(())
    }

    /// Replaces the content of a variable by content of the same shape: a returned VAR parameter.
    pub(super) fn replace_cells(&mut self, name: NameId, text: &str, cells: Cells) {
        if let Some(old) = self.cells_mut(name, text).filter(|old| old.count() == cells.count()) {
            *old = cells;
        }
    }

    /// Defines a variable that all programs see and that lives for the run. An existing one is replaced.
    pub(super) fn define_global(
        &mut self,
        text: &str,
        shape: Shape<'_>,
        value: Option<List>,
        span: Span,
    ) -> Result<(), Fault> {
        if let Some(old) = self.globals.remove(text) {
            self.global_elements -= old.count();
        }
        let left = MAX_GLOBAL - self.global_elements;
        let mut cells = Cells::new(shape.kind, shape.string, shape.dimensions, left, (text, span))?;
        initialise(&mut cells, value, (text, span))?;
        match self.presets.get(text) {
            Some(setting @ Setting::List(_)) => {
                let mut values = Vec::new();
                flatten(setting, &mut values);
                let kind = cells.kind();
                cells.fill(&[], values.into_iter().map(|value| value_of(value, kind)), (text, span))?;
            }
            Some(setting) => {
                let value = value_of(setting, cells.kind()).map(List::One);
                initialise(&mut cells, value, (text, span))?;
            }
            None => {}
        }
        self.global_elements += cells.count();
        self.globals.insert(text.to_owned(), cells);
        Ok(())
    }

    /// Assigns to a defined variable; `false` if it is not defined.
    pub(super) fn assign(
        &mut self,
        name: NameId,
        text: &str,
        indices: &[i64],
        list: List,
        span: Span,
    ) -> Result<bool, Fault> {
        let Some(cells) = self.cells_mut(name, text) else { return Ok(false) };
        put(cells, indices, list, (text, span))?;
        Ok(true)
    }
}

fn initialise(cells: &mut Cells, value: Option<List>, at: (&str, Span)) -> Result<(), Fault> {
    match value {
        None => Ok(()),
        // A single value for an array is assigned to all elements.
        Some(List::One(value)) if cells.is_array() => cells.repeat(&[], &value, None, at),
        Some(list) => put(cells, &[], list, at),
    }
}

fn put(cells: &mut Cells, indices: &[i64], list: List, at: (&str, Span)) -> Result<(), Fault> {
    match list {
        List::One(_) if cells.is_array() && indices.is_empty() => Err(wrong_type(at.0, at.1)),
        List::One(value) => cells.set(indices, value, at),
        List::Set(values) => cells.fill(indices, values, at),
        List::Repeat(value, count) => cells.repeat(indices, &value, count, at),
    }
}

/// Type and lengths of a variable for a setting.
fn kind_of(setting: &Setting) -> (DefinitionType, Vec<i64>) {
    let Setting::List(values) = setting else {
        let kind = match setting {
            Setting::Whole(_) => DefinitionType::Int,
            Setting::Truth(_) => DefinitionType::Bool,
            Setting::Text(_) => DefinitionType::String,
            Setting::Number(_) | Setting::List(_) => DefinitionType::Real,
        };
        return (kind, Vec::new());
    };
    let mut kind = None;
    let mut lengths = vec![i64::try_from(values.len()).unwrap_or(i64::MAX)];
    for (index, value) in values.iter().enumerate() {
        let (own, inner) = kind_of(value);
        if index == 0 {
            lengths.extend(inner);
        }
        // One fraction among whole numbers makes all of them reals.
        kind = if kind == Some(DefinitionType::Real) { kind } else { Some(own) };
    }
    (kind.unwrap_or(DefinitionType::Real), lengths)
}

/// The values of nested lists, in sequence.
fn flatten<'s>(setting: &'s Setting, out: &mut Vec<&'s Setting>) {
    match setting {
        Setting::List(values) => values.iter().for_each(|value| flatten(value, out)),
        value => out.push(value),
    }
}

/// A setting converted to the type of a variable.
fn value_of(setting: &Setting, kind: DefinitionType) -> Option<Value> {
    match (setting, kind) {
        (Setting::Text(name), DefinitionType::Axis) => Some(Value::Axis(name.to_ascii_uppercase())),
        _ => setting_value(setting),
    }
}

fn slot(index: i64) -> Option<usize> {
    usize::try_from(index).ok()
}

fn bad_parameter(index: i64, span: Span) -> Fault {
    fault(
        Code::BAD_INDEX,
        span,
        format!("there is no R{index}"),
        format!("R parameters run from R0 to R{}", PARAMETERS - 1),
    )
}

/// A value of the machine file's tables.
pub(super) fn setting_value(setting: &Setting) -> Option<Value> {
    Some(match setting {
        Setting::Whole(value) => Value::Int(*value),
        Setting::Number(value) => Value::Real(*value),
        Setting::Truth(value) => Value::Bool(*value),
        Setting::Text(text) => Value::Text(text.clone().into_bytes()),
        Setting::List(_) => return None,
    })
}
