//! Evaluation of the expressions of the macro languages.

use super::channel::Channel;
use super::functions::{Arithmetic, NoValue};
use super::measure;
use super::predefined;
use super::system;
use super::variables::Missing;
use super::variables::{Place, number_of};
use crate::exec::core::fault::{Fault, at, fault};
use crate::exec::core::grid::on_grid;
use crate::exec::core::position;
use crate::syntax::words::{Address, ExprId, Function, NameId, Node, Operator, Program, UnaryOperator, Value, Word};
use ncfix_base::diagnostic::Code;
use ncfix_base::source::Span;
use ncfix_dialect::Language;
use ncfix_machine::machine::DecimalPoint;

/// Maximum number of operators in an expression.
const MAX_DEPTH: u32 = 500;
/// Tolerance of a value that must be a whole number.
const WHOLE: f64 = 1e-4;

/// Data that an expression can access.
#[derive(Clone, Copy)]
pub(super) struct Scope<'s, 'a> {
    pub(super) program: &'s Program,
    /// Index of the program, in the order of loading.
    pub(super) index: usize,
    pub(super) channel: &'s Channel<'a>,
    /// Increments per unit of the current address, for ROUND; `None` rounds to whole numbers.
    pub(super) grid: Option<f64>,
}

impl Scope<'_, '_> {
    fn arithmetic(&self) -> Arithmetic {
        Arithmetic {
            language: self.channel.language,
            signed_angles: self.channel.settings.machine.control.macros.signed_angles,
        }
    }

    /// The length of a number without decimal point, in program units, if such numbers count increments.
    pub(super) fn increment(&self) -> Option<f64> {
        let counts = self.channel.settings.machine.control.iso.decimal_point == Some(DecimalPoint::Increment);
        counts.then(|| 1.0 / measure::increments_per_length(self.channel.settings.machine, &self.channel.modal))
    }

    /// The value of an expression; `None` is null.
    pub(super) fn value(&self, id: ExprId) -> Result<Option<f64>, Fault> {
        self.value_at(id, 0)
    }

    /// The value of a word; `None` is null, and such a word counts as not programmed.
    pub(super) fn word(&self, word: &Word) -> Result<Option<f64>, Fault> {
        match word.value {
            Value::Number { value, .. } => Ok(Some(value)),
            Value::Expr(id) => self.value(id),
            Value::None => Ok(None),
        }
    }

    /// The value, with 0 for null.
    pub(super) fn number(&self, id: ExprId) -> Result<f64, Fault> {
        Ok(self.value(id)?.unwrap_or(0.0))
    }

    /// `true` if a condition is true.
    pub(super) fn truth(&self, id: ExprId) -> Result<bool, Fault> {
        Ok(self.number(id)? != 0.0)
    }

    /// The value as a whole number; an error if it is not whole.
    pub(super) fn whole(&self, id: ExprId) -> Result<i64, Fault> {
        let value = self.number(id)?;
        let nearest = value.round();
        if (value - nearest).abs() > WHOLE || nearest.abs() > 1e15 {
            let message = format!("a whole number is required, and this is {value}");
            return Err(at(self.span(id), Code::BAD_WORD_VALUE, message, "use ROUND where the value is computed"));
        }
        Ok(nearest as i64)
    }

    pub(super) fn span(&self, id: ExprId) -> Span {
        self.program.expr(id).span
    }

    fn value_at(&self, id: ExprId, depth: u32) -> Result<Option<f64>, Fault> {
        let expr = self.program.expr(id);
        if depth > MAX_DEPTH {
            let message = format!("more than {MAX_DEPTH} operators in one expression");
            return Err(at(expr.span, Code::TOO_DEEP, message, "split it over several blocks"));
        }
        let depth = depth + 1;
        let computed = match expr.node {
            Node::Number(value) => return Ok(Some(value)),
            Node::Parameter(number) => return self.parameter(i64::from(number), expr.span),
            Node::ParameterAt(inner) => return self.parameter(self.index_of(inner, depth)?, expr.span),
            Node::Named(name) => return self.named(name, expr.span),
            Node::Unary(UnaryOperator::Plus, inner) => return self.value_at(inner, depth),
            Node::Unary(UnaryOperator::Minus, inner) => return Ok(self.value_at(inner, depth)?.map(|value| -value)),
            Node::Unary(UnaryOperator::Not, inner) => {
                let is_zero = self.value_at(inner, depth)?.unwrap_or(0.0) == 0.0;
                return Ok(Some(f64::from(u8::from(is_zero))));
            }
            Node::Binary(operator, left, right) => {
                let (left, right) = (self.value_at(left, depth)?, self.value_at(right, depth)?);
                self.binary(operator, left, right)
            }
            Node::Call(Function::Exists, inner, _) => return self.exists(inner).map(Some),
            Node::Call(Function::Prm, ..) => return self.of_machine_file(expr.span).map(Some),
            Node::Call(Function::Adp, inner, _) => return self.with_point(inner, expr.span, depth),
            Node::Call(Function::Round, inner, _) if self.grid.is_some() => {
                let value = self.value_at(inner, depth)?.unwrap_or(0.0);
                return Ok(Some(on_grid(value, self.grid.unwrap_or(1.0))));
            }
            Node::Call(function, first, second) => {
                let first = self.value_at(first, depth)?.unwrap_or(0.0);
                let second = second.map(|id| self.value_at(id, depth)).transpose()?;
                self.arithmetic().call(function, first, second.map(Option::unwrap_or_default))
            }
        };
        let wrong = |reason| fault(Code::NOT_COMPUTABLE, expr.span, reason, "check its operands");
        computed.map(Some).map_err(wrong)
    }

    /// Fanuc: null equals only null; elsewhere it counts as 0.
    fn binary(&self, operator: Operator, left: Option<f64>, right: Option<f64>) -> Result<f64, NoValue> {
        if left.is_none() || right.is_none() {
            let is_same = left.is_none() && right.is_none();
            match operator {
                Operator::Equal => return Ok(f64::from(u8::from(is_same))),
                Operator::NotEqual => return Ok(f64::from(u8::from(!is_same))),
                _ => {}
            }
        }
        self.arithmetic().binary(operator, left.unwrap_or(0.0), right.unwrap_or(0.0))
    }

    /// The number of the variable `#[…]`.
    fn index_of(&self, inner: ExprId, depth: u32) -> Result<i64, Fault> {
        let value = self.value_at(inner, depth)?.unwrap_or(0.0);
        self.variable_number(value, self.span(inner))
    }

    /// A computed number of a variable.
    fn variable_number(&self, value: f64, span: Span) -> Result<i64, Fault> {
        let nearest = value.round();
        if (value - nearest).abs() > WHOLE || nearest.abs() > 1e9 {
            let message = format!("a variable number must be whole, and this is {value}");
            return Err(at(span, Code::BAD_INDEX, message, "use ROUND or FIX where it is computed"));
        }
        Ok(nearest as i64)
    }

    /// The variable number of `#n` or `#[…]` as the target of an assignment.
    pub(super) fn target_number(&self, id: ExprId) -> Result<Option<i64>, Fault> {
        match self.program.expr(id).node {
            Node::Parameter(number) => Ok(Some(i64::from(number))),
            Node::ParameterAt(inner) => self.index_of(inner, 0).map(Some),
            _ => Ok(None),
        }
    }

    /// The value of a numbered variable.
    pub(super) fn parameter(&self, number: i64, span: Span) -> Result<Option<f64>, Fault> {
        let known = u32::try_from(number).unwrap_or(u32::MAX);
        match self.channel.variables.place(known) {
            Place::Null => return Ok(None),
            Place::Nowhere => return Err(no_variable(number, span)),
            Place::Variable if self.channel.settings.strict && self.channel.variables.is_left_over(known) => {
                let keeps = self.channel.variables.keeps(known);
                let message = format!("#{number} {keeps} its value between programs, and this program has not set it");
                let help = format!("set it in the program, or add \"#{number}\" = … to [system] of the machine file");
                return Err(fault(Code::NO_SYSTEM_VALUE, span, message, help).of_variable(format!("#{number}")));
            }
            Place::Variable if self.channel.variables.is_left_over(known) => {
                self.channel.variables.assumed.note(number, span);
            }
            Place::Variable | Place::System => {}
        }
        if self.channel.language == Language::Rs274 {
            return match predefined::special_parameter(self.channel, known) {
                None => Ok(self.channel.variables.get(known)),
                Some(Ok(value)) => Ok(Some(value)),
                Some(Err(missing)) => self.missing(missing, span).map(Some),
            };
        }
        match self.channel.variables.place(known) {
            Place::System => match system::system_variable(self.channel, known) {
                Ok(value) => Ok(value),
                Err(missing) => self.missing(missing, span).map(Some),
            },
            _ => Ok(self.channel.variables.get(known)),
        }
    }

    /// The value of `#<name>`.
    fn named(&self, name: NameId, span: Span) -> Result<Option<f64>, Fault> {
        let symbol = self.channel.variables.symbol_of(self.index, name);
        if let Some(value) = symbol.and_then(|symbol| self.channel.variables.named(symbol)) {
            return Ok(Some(value));
        }
        let text = self.program.names.text(name);
        if let Some(value) = self.in_machine_file(&format!("#<{text}>")) {
            return Ok(Some(value));
        }
        match self.predefined(text) {
            Some(Ok(value)) => return Ok(Some(value)),
            Some(Err(missing)) => return self.missing(missing, span).map(Some),
            None => {}
        }
        if text.starts_with("_INI[") || text.starts_with("_HAL[") {
            return self.missing(Missing::OnlyMachine, span).map(Some);
        }
        let message = format!("#<{}> has no value yet", text.to_ascii_lowercase());
        let help = "assign it before it is used; a name without _ at its start belongs to its own subroutine";
        Err(fault(Code::UNDEFINED_VARIABLE, span, message, help).of_variable(name_of(text)))
    }

    /// The value of a name, upper case, if it has one.
    pub(super) fn value_of_name(&self, name: &str) -> Option<f64> {
        let value = self.channel.variables.of_name(name).or_else(|| self.in_machine_file(&format!("#<{name}>")));
        value.or_else(|| self.predefined(name)?.ok())
    }

    fn predefined(&self, name: &str) -> Option<Result<f64, Missing>> {
        if self.channel.language == Language::Rs274 { predefined::predefined_name(self.channel, name) } else { None }
    }

    /// `true` if a name, upper case, is predefined by the control.
    pub(super) fn is_predefined(&self, name: &str) -> bool {
        self.predefined(name).is_some()
    }

    /// `EXISTS[#<name>]`
    fn exists(&self, inner: ExprId) -> Result<f64, Fault> {
        let exists = match self.program.expr(inner).node {
            Node::Named(name) => {
                let text = self.program.names.text(name);
                let symbol = self.channel.variables.symbol_of(self.index, name);
                symbol.and_then(|symbol| self.channel.variables.named(symbol)).is_some()
                    || self.is_predefined(text)
                    || self.in_machine_file(&format!("#<{text}>")).is_some()
                    || self.is_set_before(inner, name)
            }
            Node::Parameter(number) => self.channel.variables.place(number) == Place::Variable,
            Node::ParameterAt(index) => u32::try_from(self.index_of(index, 0)?)
                .is_ok_and(|number| self.channel.variables.place(number) == Place::Variable),
            _ => false,
        };
        Ok(f64::from(u8::from(exists)))
    }

    /// `true` if an assignment to a name begins further left in the block of an expression: LinuxCNC's interpreter knows the name from there on
    /// (`#<a> = [EXISTS[#<a>]]` is 1).
    fn is_set_before(&self, expr: ExprId, name: NameId) -> bool {
        let start = self.span(expr).start;
        let blocks = self.program.blocks.there(0..self.program.blocks.len());
        let behind = blocks.partition_point(|block| block.span.start <= start);
        let block = behind.checked_sub(1).and_then(|index| blocks.get(index));
        let sets = |word: &Word| match word.address {
            Address::Variable(target) => self.program.expr(target).node == Node::Named(name) && word.span.start < start,
            _ => false,
        };
        block.is_some_and(|block| self.program.words_of(block).iter().any(sets))
    }

    /// `ADP[…]` adds a decimal point to an argument without one; if numbers without a point are whole units, it has no effect.
    fn with_point(&self, inner: ExprId, span: Span, depth: u32) -> Result<Option<f64>, Fault> {
        if self.increment().is_some() {
            let message = "ADP[ ] is not supported if numbers without a point count increments";
            return Err(at(span, Code::NOT_SUPPORTED, message, "write the arguments with a decimal point"));
        }
        self.value_at(inner, depth)
    }

    /// A value that only the machine file contains, under its notation in the program.
    fn of_machine_file(&self, span: Span) -> Result<f64, Fault> {
        let shown: String = String::from_utf8_lossy(self.program.source.slice(span)).to_ascii_uppercase();
        let key: String = shown.chars().filter(|letter| !letter.is_whitespace()).collect();
        self.in_machine_file(&key).ok_or_else(|| no_value(&key, span))
    }

    fn in_machine_file(&self, key: &str) -> Option<f64> {
        self.channel.settings.machine.system.get(key).and_then(number_of)
    }

    fn missing(&self, missing: Missing, span: Span) -> Result<f64, Fault> {
        let shown = String::from_utf8_lossy(self.program.source.slice(span)).into_owned();
        match missing {
            Missing::Unknown | Missing::OnlyMachine => self.of_machine_file(span),
            Missing::Unstated => {
                let message = format!("{shown} is read, but the position of this axis is not known yet");
                let help = position::advice(self.channel.modal.position.probed);
                Err(fault(Code::UNKNOWN_START, span, message, help))
            }
            Missing::Compensated => {
                let message = format!("{shown} is a position that has no value while radius compensation is on");
                Err(fault(Code::BAD_COMPENSATION, span, message, "read it before G41 or G42, or after G40"))
            }
        }
    }
}

fn no_value(key: &str, span: Span) -> Fault {
    let message = format!("{key} is read, but its value is known only to the machine");
    // Positions of the last probing: of G38 on LinuxCNC, of G31 on a Fanuc.
    let number = key.trim_matches(['#', '[', ']']).parse();
    let help = if matches!(number, Ok(5061_u32..=5070)) {
        position::MEASURE_APART.to_owned()
    } else {
        format!("add \"{key}\" = … to [system] of the machine file")
    };
    fault(Code::NO_SYSTEM_VALUE, span, message, help).of_variable(key)
}

/// The name of a named variable in messages.
pub(super) fn name_of(text: &str) -> String {
    format!("#<{text}>")
}

/// The error for a number that is not a variable.
pub(super) fn no_variable(number: i64, span: Span) -> Fault {
    let message = format!("#{number} is not a variable of this control");
    at(span, Code::BAD_INDEX, message, "check the number, and how it is computed")
}
