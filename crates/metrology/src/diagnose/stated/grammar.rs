//! Parser of hypotheses, by recursive descent over tokens: one hypothesis per line, with a diagnostic at its column for every syntax error.
//!
//! ```text
//! hypothesis = left "~" sum | component "*" product | component "." effect | effect parameter | component shape
//! sum        = term { "+" term }
//! term       = product [ "lag" number [ "s" | "min" | "h" ] ]
//! product    = factor { "*" factor }
//! factor     = ( "1" | variable | "(" variable "-" ( variable | number ) ")" | function ) [ "^" power ]
//! function   = "dir" "(" axis ")" | "v" "(" axis ")" | "sin" "(" axis "/" number ")" | "step" "(" variable ( ">" | "<" ) number ")"
//! variable   = axis | axis "_dir" | "t_s" | column
//! ```

use std::sync::Arc;

use super::super::cause::EffectKind;
use super::super::scene::Through;
use super::form::{Factor, Operand, Quantity, StatedContent, StatedHypothesis, StatedTerm};
use super::token::{TermPiece, Token, tokens};
use crate::measure::data::{DataSet, TIME};
use ncfix_base::diagnostic::{Code, Diagnostic, Place};
use ncfix_base::geometry::{AXES, Axis};
use ncfix_base::source::{Source, Span};
use ncfix_base::units::MM_PER_INCH;
use ncfix_machine::machine::Machine;
use ncfix_model::ErrorName;

/// Highest power of a variable, as for coefficients in the machine file.
const MOST_POWER: u8 = 9;
/// Maximum number of terms of a hypothesis, and of factors of a term.
const MOST_PARTS: usize = 12;

/// Effects that name causes in the results.
const EFFECTS: [EffectKind; 22] = [
    EffectKind::Location,
    EffectKind::Motion,
    EffectKind::Periodic,
    EffectKind::Backlash,
    EffectKind::LateralPlay,
    EffectKind::ReversalSpike,
    EffectKind::Cross,
    EffectKind::ServoMismatch,
    EffectKind::Following,
    EffectKind::Dynamic,
    EffectKind::Delay,
    EffectKind::ThermalDrift,
    EffectKind::ThermalExpansion,
    EffectKind::ThermalSquareness,
    EffectKind::Drift,
    EffectKind::SpindleSpeed,
    EffectKind::Load,
    EffectKind::Setup,
    EffectKind::Probe,
    EffectKind::Sensor,
    EffectKind::Program,
    EffectKind::Unknown,
];

/// Dimension of a number with a unit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Dimension {
    Length,
    Angle,
    Time,
    Temperature,
    Speed,
}

/// Units, with the factor to mm, rad, s, and to the units of tables.
const UNITS: [(&str, Dimension, f64); 10] = [
    ("mm", Dimension::Length, 1.0),
    ("um", Dimension::Length, 1e-3),
    ("in", Dimension::Length, MM_PER_INCH),
    ("m", Dimension::Length, 1e3),
    ("deg", Dimension::Angle, std::f64::consts::PI / 180.0),
    ("s", Dimension::Time, 1.0),
    ("min", Dimension::Time, 60.0),
    ("h", Dimension::Time, 3600.0),
    ("C", Dimension::Temperature, 1.0),
    ("rpm", Dimension::Speed, 1.0),
];

/// A syntax error: its position, a message, and a help text.
type Fault = (Span, String, String);

/// Reads hypotheses, one per line; empty lines and comments after `#` are skipped. Axes are those of the machine, columns those of the measurements.
/// A text without any hypothesis is an error.
#[must_use]
pub fn read(source: &Source, machine: &Machine, sets: &[&DataSet]) -> (Vec<StatedHypothesis>, Vec<Diagnostic>) {
    read_lines(source, machine, sets, true)
}

/// As [`read()`], of the options of a command: each line is one, and none may be empty.
#[must_use]
pub fn read_options(source: &Source, machine: &Machine, sets: &[&DataSet]) -> (Vec<StatedHypothesis>, Vec<Diagnostic>) {
    read_lines(source, machine, sets, false)
}

fn read_lines(
    source: &Source,
    machine: &Machine,
    sets: &[&DataSet],
    skips_empty: bool,
) -> (Vec<StatedHypothesis>, Vec<Diagnostic>) {
    let text = String::from_utf8_lossy(source.bytes()).into_owned();
    let (mut out, mut faults): (Vec<StatedHypothesis>, Vec<Fault>) = (Vec::new(), Vec::new());
    let mut offset = 0;
    for line in text.split('\n') {
        let stated = line.split('#').next().unwrap_or_default();
        let pieces = tokens(stated, offset);
        let is_comment = stated.len() < line.len();
        if let (Some(first), Some(last)) = (pieces.first(), pieces.last()) {
            let span = first.span.to(last.span);
            let own = text.get(span.range()).unwrap_or_default().to_owned();
            let mut reader = Reader {
                text: &text,
                machine,
                sets,
                pieces: &pieces,
                at: 0,
                end: last.span.end as usize,
                faults: Vec::new(),
            };
            let statement = reader.statement(&own, span);
            faults.append(&mut reader.faults);
            out.extend(statement.map(|statement| StatedHypothesis { text: own, span, statement }));
        } else if !is_comment && (!skips_empty || (offset == 0 && text.trim().is_empty())) {
            let message = "a hypothesis is empty".to_owned();
            faults.push((Span::new(offset, offset + line.len()), message, EXAMPLES.to_owned()));
        }
        offset += line.len() + 1;
    }
    let place = |span| Place { file: source.id(), span };
    let found = faults
        .into_iter()
        .map(|(span, message, help)| Diagnostic::at(Code::BAD_HYPOTHESIS, place(span), message, help));
    let found: Vec<Diagnostic> = found.collect();
    (if found.is_empty() { out } else { Vec::new() }, found)
}

const EXAMPLES: &str = "write an error and what it depends on, for example EXX ~ Y^2 or EYY ~ T_head_C lag 600s, or a cause, for example backlash EXX";

/// True for the words after the component in the name of an explanation: none, `X order 2`, `sin 1C`, `X_dir`, `X and Y`, `X lag`.
fn is_shape(words: &[&str]) -> bool {
    let is_axis = |word: &str| AXES.iter().any(|axis| axis.to_string() == word);
    let is_number = |word: &str| !word.is_empty() && word.bytes().all(|byte| byte.is_ascii_digit());
    match words {
        [] => true,
        [one] => one.strip_suffix("_dir").is_some_and(is_axis),
        ["sin" | "cos", wave] => {
            wave.split_at_checked(1).is_some_and(|(number, axis)| is_number(number) && is_axis(axis))
        }
        [axis, "lag"] => is_axis(axis),
        [axis, "order", number] => is_axis(axis) && is_number(number),
        [axis, "and", other] => is_axis(axis) && is_axis(other),
        _ => false,
    }
}

/// Reads one line.
struct Reader<'t, 'p> {
    text: &'t str,
    machine: &'p Machine,
    sets: &'p [&'p DataSet],
    pieces: &'p [TermPiece<'t>],
    at: usize,
    end: usize,
    faults: Vec<Fault>,
}

impl<'t> Reader<'t, '_> {
    fn peek(&self) -> Option<&Token<'t>> {
        self.pieces.get(self.at).map(|piece| &piece.token)
    }

    /// Position of the next token, or the end of the line.
    fn here(&self) -> Span {
        self.pieces.get(self.at).map_or(Span::new(self.end, self.end), |piece| piece.span)
    }

    fn takes(&mut self, sign: char) -> bool {
        let is_next = self.peek() == Some(&Token::Sign(sign));
        self.at += usize::from(is_next);
        is_next
    }

    fn fault(&mut self, span: Span, message: impl Into<String>, help: impl Into<String>) {
        self.faults.push((span, message.into(), help.into()));
    }

    fn demand(&mut self, sign: char, help: &str) -> Option<()> {
        if self.takes(sign) {
            return Some(());
        }
        let (span, found) = (self.here(), self.found());
        self.fault(span, format!("'{sign}' is missing before {found}"), help);
        None
    }

    /// The next token, for messages.
    fn found(&self) -> String {
        let span = self.here();
        match self.text.get(span.range()).filter(|text| !text.is_empty()) {
            Some(text) => format!("'{text}'"),
            None => "the end".to_owned(),
        }
    }

    fn word(&mut self) -> Option<(&'t str, Span)> {
        let span = self.here();
        let Some(Token::Word(word)) = self.peek() else { return None };
        let word = *word;
        self.at += 1;
        Some((word, span))
    }

    fn statement(&mut self, own: &str, span: Span) -> Option<StatedContent> {
        if self.pieces.iter().any(|piece| piece.token == Token::Sign('~')) {
            let through = self.left();
            let terms = self.sum();
            return Some(StatedContent::Sum(through?, terms?));
        }
        if let Some(at) = own.find('=') {
            let from = span.start as usize + at;
            self.fault(Span::new(from, from + 1), "'=' has no meaning here", EXAMPLES.to_owned());
            return None;
        }
        let first = match self.peek() {
            Some(Token::Word(word)) => *word,
            _ => "",
        };
        let sign = self.pieces.get(1).map(|piece| &piece.token);
        let component = first.parse::<ErrorName>().ok();
        match (component, sign) {
            (Some(component), Some(Token::Sign('*'))) => {
                self.at = 2;
                self.check_axis(component, span);
                let terms = self.sum();
                Some(StatedContent::Sum(Through::Component(component), terms?))
            }
            (Some(component), Some(Token::Sign('.'))) => {
                let word = own.split_once('.').map_or("", |(_, word)| word.trim());
                self.effect(word, span).map(|effect| StatedContent::Named(effect, component.to_string()))
            }
            (Some(component), _) => {
                self.check_axis(component, span);
                let words: Vec<&str> = own.split_whitespace().collect();
                if !is_shape(words.get(1..).unwrap_or_default()) {
                    let rest = own.get(first.len()..).unwrap_or_default().trim();
                    let message = format!(
                        "'{rest}' is not a form of {component}; '~' is missing if it is what {component} depends on"
                    );
                    self.fault(span, message, EXAMPLES.to_owned());
                    return None;
                }
                Some(StatedContent::Shape(words.join(" ")))
            }
            (None, _) => {
                let (word, parameter) = own.split_once(char::is_whitespace).unwrap_or((own, ""));
                let end = span.start as usize + word.len();
                let effect = self.effect(word, Span::new(span.start as usize, end))?;
                Some(StatedContent::Named(effect, parameter.trim().to_owned()))
            }
        }
    }

    fn effect(&mut self, word: &str, span: Span) -> Option<EffectKind> {
        let found = EFFECTS.into_iter().find(|effect| effect.to_string() == word);
        if found.is_none() {
            let known: Vec<String> = EFFECTS.iter().map(ToString::to_string).collect();
            let capital = word.to_uppercase();
            let help = match capital.parse::<ErrorName>() {
                Ok(_) => format!("names have capital letters: write {capital}"),
                Err(_) => {
                    format!("{EXAMPLES}; separate several parameters by commas; causes are {}", known.join(", "))
                }
            };
            self.fault(span, format!("'{word}' is neither an error nor a cause"), help);
        }
        found
    }

    /// The deviation on the left side, with its `~`.
    fn left(&mut self) -> Option<Through> {
        const HELP: &str =
            "write an error component (EXX, EC0Y, EX0S), or X, Y or Z for the tool relative to the workpiece";
        let span = self.here();
        let Some((word, span)) = self.word() else {
            let found = self.found();
            self.fault(span, format!("the left side is not an error: {found}"), HELP);
            self.at = self.pieces.iter().position(|piece| piece.token == Token::Sign('~')).map_or(self.at, |at| at + 1);
            return None;
        };
        let tip = ["X", "Y", "Z"].iter().position(|letter| *letter == word);
        let through = match (word.parse::<ErrorName>(), tip) {
            (Ok(component), _) => {
                self.check_axis(component, span);
                Some(Through::Component(component))
            }
            (Err(_), Some(direction)) => Some(Through::Tip(direction)),
            (Err(_), None) => {
                let capital = word.to_uppercase();
                let is_known = capital.parse::<ErrorName>().is_ok() || ["X", "Y", "Z"].contains(&capital.as_str());
                let help =
                    if is_known { format!("names have capital letters: write {capital}") } else { HELP.to_owned() };
                self.fault(span, format!("'{word}' is not an error component"), help);
                None
            }
        };
        if self.demand('~', "write ~ after the left side").is_none() {
            self.at = self.pieces.iter().position(|piece| piece.token == Token::Sign('~')).map_or(self.at, |at| at + 1);
            return None;
        }
        through
    }

    fn check_axis(&mut self, component: ErrorName, span: Span) {
        if let Some(axis) = component.axis().filter(|axis| self.machine.axis(*axis).is_none()) {
            self.no_axis(&axis.to_string(), span);
        }
    }

    fn no_axis(&mut self, name: &str, span: Span) {
        let known: Vec<String> = self.machine.axes.iter().flatten().map(|data| data.axis.to_string()).collect();
        let help = format!("name an axis of the machine: {}", known.join(", "));
        self.fault(span, format!("the machine has no axis {name}"), help);
    }

    fn sum(&mut self) -> Option<Vec<StatedTerm>> {
        let mut terms = vec![self.term()?];
        while self.takes('+') {
            terms.push(self.term()?);
        }
        let (span, found) = (self.here(), self.found());
        if self.peek().is_some() {
            self.fault(
                span,
                format!("{found} is not expected here"),
                "write * between factors, + between terms, and lag and a time after a term",
            );
            return None;
        }
        if terms.len() > MOST_PARTS || terms.iter().any(|term| term.factors.len() > MOST_PARTS) {
            self.fault(
                span,
                format!("there are more than {MOST_PARTS} terms or factors"),
                "state a simpler hypothesis",
            );
            return None;
        }
        Some(terms)
    }

    fn term(&mut self) -> Option<StatedTerm> {
        let start = self.here();
        let mut factors = Vec::new();
        loop {
            factors.extend(self.factor()?);
            if !self.takes('*') {
                break;
            }
        }
        let mut lag_s = 0.0;
        if self.peek() == Some(&Token::Word("lag")) {
            let span = self.here();
            self.at += 1;
            let (value, of, number) = self.number("write the time constant, for example lag 600s or lag 20min")?;
            if of.is_some_and(|of| of != Dimension::Time) || value <= 0.0 {
                self.fault(
                    number,
                    "a lag is a time above zero",
                    "write the time constant, for example lag 600s or lag 20min",
                );
            }
            lag_s = value;
            let has_temperature = factors
                .iter()
                .flat_map(|factor: &Factor| factor.quantities())
                .any(|quantity| matches!(quantity, Quantity::Temperature(_)));
            if !has_temperature {
                self.fault(
                    span,
                    "a lag needs a temperature in its term",
                    "remove the lag, or name a temperature column, for example T_head_C",
                );
            }
        }
        let last = self.at.checked_sub(1).and_then(|at| self.pieces.get(at)).map_or(start, |piece| piece.span);
        let text = self.text.get(start.to(last).range()).unwrap_or_default().to_owned();
        Some(StatedTerm { text, factors, lag_s })
    }

    /// A factor; the inner value is `None` for the constant 1.
    fn factor(&mut self) -> Option<Option<Factor>> {
        const HELP: &str = "write an axis, a column of the data, t_s, 1, a difference such as (X-300), dir(X), v(X), sin(X/5mm) or step(X > 400)";
        let span = self.here();
        match self.peek().cloned() {
            Some(Token::Number(value)) => {
                self.at += 1;
                if value != 1.0 {
                    self.fault(
                        span,
                        "a number is not a factor: the fit determines the amount of each term",
                        "leave the number out",
                    );
                }
                Some(None)
            }
            Some(Token::Sign('(')) => {
                self.at += 1;
                let (of, is_known) = self.variable(HELP)?;
                self.demand('-', "write a difference, for example (X-300) or (T_a_C - T_b_C)")?;
                let minus = match self.peek() {
                    Some(Token::Number(_)) => {
                        let (value, unit, at) = self.number(HELP)?;
                        if matches!(of, Quantity::Temperature(_)) {
                            self.fault(
                                at,
                                "a temperature already counts from its reference",
                                "write the sensor alone, or the difference of two sensors",
                            );
                        }
                        Operand::Number(self.inside(&of, value, unit, at))
                    }
                    _ => Operand::Quantity(self.variable(HELP)?.0),
                };
                let is_mixed = matches!(&minus, Operand::Quantity(other) if std::mem::discriminant(other) != std::mem::discriminant(&of));
                if is_mixed && is_known {
                    self.fault(
                        span,
                        "a difference of two unlike quantities has no unit",
                        "subtract quantities of one kind",
                    );
                }
                self.demand(')', "close the difference with )")?;
                Some(Some(Factor::Power { of, minus: Some(minus), power: self.power()? }))
            }
            Some(Token::Word(name))
                if self.pieces.get(self.at + 1).is_some_and(|next| next.token == Token::Sign('(')) =>
            {
                self.function(name, span).map(Some)
            }
            Some(Token::Word(_)) => {
                let (of, _) = self.variable(HELP)?;
                Some(Some(Factor::Power { of, minus: None, power: self.power()? }))
            }
            _ => {
                let found = self.found();
                self.fault(span, format!("a factor is missing before {found}"), HELP);
                None
            }
        }
    }

    fn power(&mut self) -> Option<u8> {
        if !self.takes('^') {
            return Some(1);
        }
        let span = self.here();
        let power = match self.peek() {
            Some(Token::Number(value)) => (1..=MOST_POWER).find(|power| f64::from(*power) == *value),
            _ => None,
        };
        if power.is_none() {
            self.fault(
                span,
                format!("a power is a whole number from 1 to {MOST_POWER}"),
                format!("write a power from 1 to {MOST_POWER}"),
            );
        }
        self.at += 1;
        power
    }

    fn function(&mut self, name: &str, span: Span) -> Option<Factor> {
        // Skips the name and the parenthesis after it.
        self.at += 2;
        let factor = match Function::find(name) {
            Some(Function::Dir) => Factor::Power { of: Quantity::Sense(self.axis()?), minus: None, power: 1 },
            Some(Function::Velocity) => Factor::Power { of: Quantity::Speed(self.axis()?), minus: None, power: 1 },
            Some(Function::Wave) => {
                const HELP: &str = "write the axis and the period, for example sin(X/5mm)";
                let axis = self.axis()?;
                self.demand('/', HELP)?;
                let (value, unit, at) = self.number(HELP)?;
                let period = self.inside(&Quantity::Position(axis), value, unit, at);
                if period <= 0.0 {
                    self.fault(at, "a period is greater than zero", HELP);
                }
                Factor::Wave { axis, period }
            }
            Some(Function::Step) => {
                const HELP: &str = "write a variable and a limit, for example step(X > 400)";
                let (of, _) = self.variable(HELP)?;
                let is_above = self.takes('>');
                if !is_above {
                    self.demand('<', HELP)?;
                }
                let (value, unit, at) = self.number(HELP)?;
                Factor::Step { limit: self.inside(&of, value, unit, at), of, is_above }
            }
            None => {
                self.fault(span, format!("'{name}' is not a function"), "functions are dir, v, sin and step");
                return None;
            }
        };
        self.demand(')', "close the function with )")?;
        Some(factor)
    }

    fn axis(&mut self) -> Option<Axis> {
        let span = self.here();
        let Some((word, span)) = self.word() else {
            let found = self.found();
            self.fault(
                span,
                format!("an axis is missing before {found}"),
                "write the letter of an axis, for example X",
            );
            return None;
        };
        let axis = axis_of(word).filter(|axis| self.machine.axis(*axis).is_some());
        if axis.is_none() {
            self.no_axis(word, span);
        }
        // The rest of the line is still parsed, to report further errors.
        Some(axis.unwrap_or(Axis::X))
    }

    /// A variable, and whether it is known. An unknown one is reported and counts as a column, so that the rest is parsed.
    fn variable(&mut self, help: &str) -> Option<(Quantity, bool)> {
        let span = self.here();
        let Some((word, span)) = self.word() else {
            let found = self.found();
            self.fault(span, format!("a variable is missing before {found}"), help);
            return None;
        };
        let letter = word.strip_suffix("_dir").unwrap_or(word);
        if let Some(axis) = axis_of(letter) {
            let is_known = self.machine.axis(axis).is_some();
            if !is_known {
                self.no_axis(letter, span);
            }
            let quantity = if letter.len() < word.len() { Quantity::Sense(axis) } else { Quantity::Position(axis) };
            return Some((quantity, is_known));
        }
        if word == TIME {
            let has_time = self.sets.iter().any(|set| set.observations.iter().any(|one| one.t_s.is_some()));
            if !has_time {
                self.fault(span, "the data have no column t_s", "log the time of each reading, in seconds");
            }
            return Some((Quantity::Time, has_time));
        }
        let has_column = self.sets.iter().flat_map(|set| &set.drivers).any(|column| column.name == word);
        if !has_column {
            let mut known: Vec<&str> =
                self.sets.iter().flat_map(|set| &set.drivers).map(|column| column.name.as_str()).collect();
            known.sort_unstable();
            known.dedup();
            let columns = if known.is_empty() {
                "the data have no columns of drivers, such as temperatures or feeds".to_owned()
            } else {
                format!("known columns: {}", known.join(", "))
            };
            let capital = word.to_uppercase();
            let is_axis = AXES.iter().any(|axis| capital.strip_suffix("_DIR").unwrap_or(&capital) == axis.to_string());
            let help = if is_axis {
                format!("axes have capital letters: write {}", capital.replace("_DIR", "_dir"))
            } else {
                format!("name an axis or a column; {columns}")
            };
            self.fault(span, format!("'{word}' is neither an axis nor a column of the data"), help);
        }
        let is_temperature = word.starts_with("T_") && word.ends_with("_C");
        let name: Arc<str> = word.into();
        Some((if is_temperature { Quantity::Temperature(name) } else { Quantity::Column(name) }, has_column))
    }

    /// A number and the dimension of its unit; with a unit it is converted to mm, rad or s.
    fn number(&mut self, help: &str) -> Option<(f64, Option<Dimension>, Span)> {
        let span = self.here();
        let is_negative = self.takes('-');
        let Some(Token::Number(value)) = self.peek().cloned() else {
            let found = self.found();
            self.fault(span, format!("a number is missing before {found}"), help);
            return None;
        };
        self.at += 1;
        let value = if is_negative { -value } else { value };
        let unit = match self.peek() {
            Some(Token::Word(word)) => UNITS.iter().find(|(name, ..)| name == word),
            _ => None,
        };
        if !value.is_finite() {
            self.fault(span, "the number is too large", help);
        }
        let Some((_, dimension, factor)) = unit else { return Some((value, None, span)) };
        let span = span.to(self.here());
        self.at += 1;
        Some((value * factor, Some(*dimension), span))
    }

    /// Converts a number into the internal unit of a quantity; numbers without a unit are in mm, degrees, s, otherwise as in tables.
    fn inside(&mut self, of: &Quantity, value: f64, unit: Option<Dimension>, span: Span) -> f64 {
        let own = match of {
            Quantity::Position(axis) if axis.is_rotary() => Some(Dimension::Angle),
            Quantity::Position(_) => Some(Dimension::Length),
            Quantity::Time => Some(Dimension::Time),
            Quantity::Temperature(_) => Some(Dimension::Temperature),
            Quantity::Column(_) => unit,
            Quantity::Sense(_) | Quantity::Speed(_) => None,
        };
        if unit.is_some() && unit != own {
            self.fault(
                span,
                format!("the unit does not fit {}", of.driver()),
                "write mm for a linear axis, deg for a rotary one, s for a time, C for a temperature",
            );
        }
        if unit.is_none() && own == Some(Dimension::Angle) { value.to_radians() } else { value }
    }
}

/// Functions.
#[derive(Clone, Copy, Debug)]
enum Function {
    Dir,
    Velocity,
    Wave,
    Step,
}

impl Function {
    fn find(name: &str) -> Option<Function> {
        const ALL: [(&str, Function); 4] =
            [("dir", Function::Dir), ("v", Function::Velocity), ("sin", Function::Wave), ("step", Function::Step)];
        ALL.iter().find(|(own, _)| *own == name).map(|(_, function)| *function)
    }
}

/// The axis of an upper-case letter.
fn axis_of(word: &str) -> Option<Axis> {
    match *word.as_bytes() {
        [letter] if letter.is_ascii_uppercase() => Axis::from_letter(letter),
        _ => None,
    }
}
