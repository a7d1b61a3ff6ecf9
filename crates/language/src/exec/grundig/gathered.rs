//! The words of one block with their values. Each word is consumed once; an unconsumed word is an error.

use super::expression::Scope;
use super::modal::Modal;
use crate::exec::core::fault::{Fault, bad_value, fault};
use crate::exec::core::grid::on_grid;
use crate::syntax::words::{Address, Block, Program, Value};
use ncfix_base::diagnostic::Code;
use ncfix_base::source::Span;
use ncfix_dialect::CodeEntry;
use ncfix_machine::machine::Machine;

/// Largest accepted magnitude of a value.
const MOST: f64 = 1e9;

/// A word.
#[derive(Clone, Copy, Debug)]
pub(super) struct Item {
    pub(super) letter: u8,
    /// The 1 of `X1=`.
    pub(super) index: Option<u16>,
    pub(super) value: f64,
    pub(super) span: Span,
    used: bool,
}

/// A value and its span.
pub(super) type Found = (f64, Span);

/// A code and its span.
#[derive(Clone, Copy, Debug)]
pub(super) struct CodeWord {
    pub(super) number: u16,
    pub(super) span: Span,
}

/// The words of a block.
#[derive(Debug, Default)]
pub(super) struct Gathered {
    pub(super) items: Vec<Item>,
    /// G codes in order.
    pub(super) codes: Vec<CodeWord>,
    /// M functions in order.
    pub(super) functions: Vec<CodeWord>,
    /// `E5` without `=`: the parameter of a code.
    pub(super) parameters: Vec<CodeWord>,
    /// Span of the block.
    pub(super) span: Span,
}

impl Gathered {
    /// Reads the words of a block; assignments are already executed.
    pub(super) fn gather(&mut self, program: &Program, block: &Block, scope: Scope<'_>) -> Result<(), Fault> {
        self.items.clear();
        self.codes.clear();
        self.functions.clear();
        self.parameters.clear();
        self.span = block.span;
        for word in program.words_of(block) {
            let (letter, index) = match word.address {
                Address::Letter(letter) => (letter, None),
                // Already executed.
                Address::Indexed(b'E', _) => continue,
                Address::Indexed(letter, index) => (letter, Some(index)),
                Address::Comma(_) | Address::Variable(_) | Address::Name(_) => {
                    return Err(fault(Code::UNEXPECTED, word.span, "not a word of this language", "remove it"));
                }
            };
            let value = match word.value {
                Value::Number { value, .. } => value,
                Value::Expr(id) => scope.number(id)?,
                Value::None => return Err(fault(Code::MISSING_VALUE, word.span, "a word without value", "add it")),
            };
            match (letter, index) {
                (b'G', None) => self.codes.push(code_word(value, word.span, "G")?),
                (b'M', None) => self.functions.push(code_word(value, word.span, "M")?),
                (b'E', None) => self.parameters.push(code_word(value, word.span, "E")?),
                _ if value.is_nan() || value.abs() > MOST => {
                    let message = format!("{}{value} is beyond the range of any machine", char::from(letter));
                    return Err(bad_value(word.span, message, "check the value"));
                }
                _ => self.items.push(Item { letter, index, value, span: word.span, used: false }),
            }
        }
        Ok(())
    }

    /// Rounds lengths and angles to the increment of the control, in inches to a tenth of it; factors, counts, feeds and times stay.
    pub(super) fn put_on_grid(&mut self, modal: &Modal, machine: &Machine) {
        let has = |number: u16| self.codes.iter().any(|code| code.number == number);
        let inch = if has(70) || has(71) { has(70) } else { modal.modes.inch };
        let per_length = per_unit(machine.control.grid[0]) * if inch { 10.0 } else { 1.0 };
        let per_degree = per_unit(machine.control.grid[1].to_degrees());
        // J of tapping is a lead, A4= a factor.
        let is_tapping = has(84);
        for item in &mut self.items {
            match (item.letter, item.index) {
                (b'J', None) if is_tapping => {}
                (b'A', Some(4)) => {}
                (b'A'..=b'C', _) => item.value = on_grid(item.value, per_degree),
                (b'X'..=b'Z' | b'U'..=b'W' | b'I'..=b'L' | b'R', _) => item.value = on_grid(item.value, per_length),
                _ => {}
            }
        }
    }

    /// `true` if the block has only its number, comments and assignments.
    pub(super) fn is_empty(&self) -> bool {
        self.items.is_empty() && self.codes.is_empty() && self.functions.is_empty() && self.parameters.is_empty()
    }

    /// Consumes a G code.
    pub(super) fn take_code(&mut self, number: u16) -> Option<Span> {
        let at = self.codes.iter().position(|code| code.number == number)?;
        Some(self.codes.remove(at).span)
    }

    /// Consumes an M function.
    pub(super) fn take_function(&mut self, number: u16) -> Option<Span> {
        let at = self.functions.iter().position(|code| code.number == number)?;
        Some(self.functions.remove(at).span)
    }

    /// `true` if every word has been consumed.
    pub(super) fn is_used_up(&self) -> bool {
        self.items.iter().all(|item| item.used)
    }

    /// The value of an unconsumed word.
    pub(super) fn peek(&self, letter: u8, index: Option<u16>) -> Option<Found> {
        let item = self.items.iter().find(|item| !item.used && item.letter == letter && item.index == index)?;
        Some((item.value, item.span))
    }

    /// Consumes a word, the first of several.
    pub(super) fn take(&mut self, letter: u8, index: Option<u16>) -> Option<Found> {
        let found = |item: &&mut Item| !item.used && item.letter == letter && item.index == index;
        let item = self.items.iter_mut().find(found)?;
        item.used = true;
        Some((item.value, item.span))
    }

    /// Consumes a word that may occur once.
    pub(super) fn once(&mut self, letter: u8, index: Option<u16>) -> Result<Option<Found>, Fault> {
        let found = self.take(letter, index);
        if found.is_some()
            && let Some((_, span)) = self.peek(letter, index)
        {
            return Err(fault(
                Code::DOUBLE_WORD,
                span,
                format!("{} is given twice in the block", name(letter, index)),
                "keep one of them",
            ));
        }
        Ok(found)
    }

    /// Consumes all words of a letter with any index, in order.
    pub(super) fn take_all(&mut self, letter: u8) -> Vec<Item> {
        let all = self.items.iter_mut().filter(|item| !item.used && item.letter == letter);
        all.map(|item| {
            item.used = true;
            *item
        })
        .collect()
    }

    /// Consumes all words of a code.
    pub(super) fn take_used_by(&mut self, entry: &CodeEntry) -> Vec<Item> {
        let mut out = Vec::new();
        for item in self.items.iter_mut().filter(|item| !item.used) {
            let is_own = match item.index {
                None => entry.uses(item.letter),
                Some(index) => entry.uses_indexed(item.letter, index),
            };
            if is_own {
                item.used = true;
                out.push(*item);
            }
        }
        out
    }

    /// Reports unconsumed words.
    pub(super) fn check_all_used(&self) -> Result<(), Fault> {
        if let Some(item) = self.items.iter().find(|item| !item.used) {
            let message = format!("{} has no effect in this block", name(item.letter, item.index));
            let help = "remove the word, or add the code that it belongs to";
            return Err(fault(Code::BAD_WORD_VALUE, item.span, message, help));
        }
        match self.parameters.first() {
            None => Ok(()),
            Some(code) => {
                let message = format!("E{} has no effect in this block", code.number);
                Err(fault(Code::BAD_WORD_VALUE, code.span, message, "assign it with E=, or remove it"))
            }
        }
    }
}

/// A word as written.
pub(super) fn name(letter: u8, index: Option<u16>) -> String {
    match index {
        None => char::from(letter).to_string(),
        Some(index) => format!("{}{index}=", char::from(letter)),
    }
}

/// Increments per unit, rounded if nearly whole.
fn per_unit(increment: f64) -> f64 {
    let count = 1.0 / increment;
    if (count - count.round()).abs() < 1e-6 * count { count.round() } else { count }
}

fn code_word(value: f64, span: Span, letter: &str) -> Result<CodeWord, Fault> {
    if value.fract() != 0.0 || !(0.0..=9999.0).contains(&value) {
        return Err(bad_value(
            span,
            format!("{letter}{value} is not a whole number from 0 to 9999"),
            "correct the number",
        ));
    }
    // Within the range of the type.
    Ok(CodeWord { number: value as u16, span })
}
