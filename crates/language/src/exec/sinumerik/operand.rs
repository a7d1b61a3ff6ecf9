//! Operands of expressions that are looked up: variables, elements, axes, system variables; and assigned lists.

use super::expression::Scope;
use super::value::{Value, axis_of, is_axis_name};
use super::variables::List;
use crate::exec::core::fault::{Fault, fault};
use crate::syntax::sinumerik::{ArgumentRange, ExprId, NameId, Node};
use ncfix_base::diagnostic::Code;
use ncfix_base::geometry::Axis;
use ncfix_base::source::Span;

impl Scope<'_> {
    fn text_of(&self, name: NameId) -> &str {
        self.program.names.text(name)
    }

    pub(super) fn named(&self, name: NameId, id: ExprId) -> Result<Value, Fault> {
        let text = self.text_of(name);
        let span = self.program.expr(id).span;
        if let Some(cells) = self.variables.cells(name, text) {
            return match cells.first() {
                Some(value) if !cells.is_array() => Ok(value.clone()),
                _ => cells.get(&[], (text, span)),
            };
        }
        if text == "$PI" {
            return Ok(Value::Real(std::f64::consts::PI));
        }
        if text.starts_with('$') {
            return self.read_system(text, None, id);
        }
        if is_axis_name(text) || self.machine.axis_named(text).is_some() {
            return Ok(Value::Axis(text.to_owned()));
        }
        Err(self.undefined(text, id))
    }

    pub(super) fn undefined(&self, text: &str, id: ExprId) -> Fault {
        undefined(format!("{text} is not defined"), text, self.program.expr(id).span)
    }

    pub(super) fn indexed(&self, name: NameId, range: ArgumentRange, id: ExprId) -> Result<Value, Fault> {
        let text = self.text_of(name);
        let span = self.program.expr(id).span;
        if let Some(cells) = self.variables.cells(name, text) {
            if let Some((axis, component, front)) = self.component(range)? {
                let indices = self.first_indices(range, front, id)?;
                let Value::Frame(parts) = cells.get(&indices, (text, span))? else { return Err(self.type_fault(id)) };
                return self.get_component(&parts, axis, component, span);
            }
            return cells.get(&self.indices(range, id)?, (text, span));
        }
        if text.starts_with('$') {
            return self.read_system(text, Some(range), id);
        }
        Err(self.undefined(text, id))
    }

    /// Whole numbers as indices.
    pub(super) fn indices(&self, range: ArgumentRange, id: ExprId) -> Result<Vec<i64>, Fault> {
        self.first_indices(range, usize::MAX, id)
    }

    /// Whole numbers as the first `count` indices.
    pub(super) fn first_indices(&self, range: ArgumentRange, count: usize, id: ExprId) -> Result<Vec<i64>, Fault> {
        let list = self.program.arguments_of(range).iter().take(count);
        list.map(|index| match index {
            Some(index) => self.whole(*index),
            None => {
                let span = self.program.expr(id).span;
                Err(fault(Code::BAD_INDEX, span, "an index is missing", "write all indices of the element"))
            }
        })
        .collect()
    }

    /// The values of a whole argument list; an empty slot is `None`.
    pub(super) fn list(&self, range: ArgumentRange) -> Result<Vec<Option<Value>>, Fault> {
        self.program.arguments_of(range).iter().map(|slot| slot.map(|id| self.value(id)).transpose()).collect()
    }

    /// The assigned value: a value, `SET(…)` or `REP(…)`.
    pub(super) fn assigned(&self, id: ExprId) -> Result<List, Fault> {
        let Node::Call(name, range) = self.program.expr(id).node else { return self.value(id).map(List::One) };
        match self.text_of(name) {
            "SET" => self.list(range).map(List::Set),
            "REP" => match self.list(range)?.as_slice() {
                [Some(value)] => Ok(List::Repeat(value.clone(), None)),
                [Some(value), Some(count)] => {
                    let count = count.whole().ok_or_else(|| self.type_fault(id))?;
                    Ok(List::Repeat(value.clone(), Some(count)))
                }
                _ => {
                    let span = self.program.expr(id).span;
                    let message = "REP takes a value, and a count unless it fills to the end";
                    Err(fault(Code::BAD_EXPRESSION, span, message, "write for example REP(0) or REP(0,5)"))
                }
            },
            _ => self.value(id).map(List::One),
        }
    }

    /// The axis that an expression names.
    pub(super) fn axis(&self, id: ExprId) -> Result<Axis, Fault> {
        self.axis_in(&self.value(id)?, id)
    }

    /// The axis that a value names.
    pub(super) fn axis_in(&self, value: &Value, id: ExprId) -> Result<Axis, Fault> {
        let span = self.program.expr(id).span;
        let Value::Axis(name) = value else { return Err(self.type_fault(id)) };
        let known = self.machine.axis_named(name).or_else(|| axis_of(name, self.machine.axis_set().iter()));
        known.filter(|&axis| self.machine.axis(axis).is_some()).ok_or_else(|| {
            let message = if name.is_empty() {
                "this AXIS variable was never assigned".to_owned()
            } else {
                format!("the machine has no axis {name}")
            };
            fault(Code::NO_AXIS, span, message, "write an axis of the machine")
        })
    }
}

/// The error for an undefined name.
pub(super) fn undefined(message: String, name: &str, span: Span) -> Fault {
    let help = format!(
        "define it with DEF at the start of this program, or give its value as {name} = … in [gud] of the machine file"
    );
    fault(Code::UNDEFINED_VARIABLE, span, message, help).of_variable(name)
}
