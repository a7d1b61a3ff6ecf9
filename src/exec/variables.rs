//! R parameters, which live as long as the run, and DEF variables, which live as long as their program level.

use super::expression::is_function;
use super::fault::{Fault, fault};
use super::value::Value;
use crate::diagnostic::Code;
use crate::source::Span;
use crate::syntax::{DefinitionType, NameId};

/// R0 … R9999.
const PARAMETERS: usize = 10_000;

/// A DEF variable.
#[derive(Clone, Debug)]
struct Variable {
    name: NameId,
    kind: DefinitionType,
    value: Value,
}

/// DEF variables of one program level.
#[derive(Clone, Debug, Default)]
pub(super) struct Locals(Vec<Variable>);

/// All variables that a block can see.
pub(super) struct Variables {
    parameters: Vec<f64>,
    locals: Locals,
}

impl Variables {
    pub(super) fn new() -> Self {
        Variables { parameters: vec![0.0; PARAMETERS], locals: Locals::default() }
    }

    /// Puts the variables of another level in place and gives back those that were there.
    pub(super) fn exchange(&mut self, locals: Locals) -> Locals {
        std::mem::replace(&mut self.locals, locals)
    }

    /// An R parameter.
    pub(super) fn parameter(&self, index: i64, span: Span) -> Result<f64, Fault> {
        slot(index).and_then(|slot| self.parameters.get(slot)).copied().ok_or_else(|| bad_index(index, span))
    }

    /// Sets an R parameter.
    pub(super) fn set_parameter(&mut self, index: i64, value: f64, span: Span) -> Result<(), Fault> {
        let place = slot(index).and_then(|slot| self.parameters.get_mut(slot)).ok_or_else(|| bad_index(index, span))?;
        *place = value;
        Ok(())
    }

    /// A variable of this level.
    pub(super) fn get(&self, name: NameId) -> Option<&Value> {
        self.locals.0.iter().find(|variable| variable.name == name).map(|variable| &variable.value)
    }

    /// Whether the level has a variable of this name.
    pub(super) fn has(&self, name: NameId) -> bool {
        self.get(name).is_some()
    }

    /// Defines a variable.
    pub(super) fn define(
        &mut self,
        name: NameId,
        text: &str,
        kind: DefinitionType,
        value: Option<Value>,
        span: Span,
    ) -> Result<(), Fault> {
        if self.has(name) || is_function(text) {
            return Err(fault(Code::DUPLICATE_NAME, span, format!("{text} is taken already"), "choose another name"));
        }
        let Some(initial) = Value::initial(kind) else {
            let message = "variables of type AXIS and FRAME are not supported yet";
            return Err(fault(Code::NOT_SUPPORTED, span, message, "write the axis or frame out"));
        };
        let value = match value {
            Some(value) => value.converted(kind).ok_or_else(|| wrong_type(text, span))?,
            None => initial,
        };
        self.locals.0.push(Variable { name, kind, value });
        Ok(())
    }

    /// Assigns a variable that is defined; `false` where it is not.
    pub(super) fn assign(&mut self, name: NameId, text: &str, value: Value, span: Span) -> Result<bool, Fault> {
        let Some(variable) = self.locals.0.iter_mut().find(|variable| variable.name == name) else { return Ok(false) };
        variable.value = value.converted(variable.kind).ok_or_else(|| wrong_type(text, span))?;
        Ok(true)
    }
}

fn slot(index: i64) -> Option<usize> {
    usize::try_from(index).ok()
}

fn bad_index(index: i64, span: Span) -> Fault {
    fault(
        Code::BAD_INDEX,
        span,
        format!("there is no R{index}"),
        format!("R parameters run from R0 to R{}", PARAMETERS - 1),
    )
}

fn wrong_type(text: &str, span: Span) -> Fault {
    fault(Code::TYPE_MISMATCH, span, format!("{text} cannot hold this value"), "check the types in the DEF block")
}
