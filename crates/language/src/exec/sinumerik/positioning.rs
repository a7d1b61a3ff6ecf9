//! Positioning axes: `POS[X]=…` moves an axis independently, at rapid or at the feed of `FA[X]=`, and the block waits for it.
//!
//! Axes of the machine file are moved and corrected like others, and written as POS again. Nothing else may move in their block, as each axis arrives
//! at a different time. Axes outside the machine file are passed through.

use super::gathered::Gathered;
use super::gatherer::Gatherer;
use super::value::Value as ExecValue;
use crate::exec::core::fault::{Fault, fault};
use crate::syntax::sinumerik::{Address, Block, ExprId, Node, Value, Word};
use ncfix_base::diagnostic::Code;
use ncfix_base::geometry::Axis;
use ncfix_base::source::Span;
use ncfix_dialect::ValueUnit;

impl Gatherer<'_> {
    /// Takes `POS[…]=` and `POSA[…]=`; `false` for another word.
    ///
    /// Production `positioning`.
    pub(super) fn positioning(
        &self,
        left: ExprId,
        word: &Word,
        block: &Block,
        out: &mut Gathered,
    ) -> Result<bool, Fault> {
        let Node::Indexed(name, range) = self.scope.program.expr(left).node else { return Ok(false) };
        let text = self.scope.program.names.text(name);
        let ("POS" | "POSA", [Some(axis)]) = (text, self.scope.program.arguments_of(range)) else { return Ok(false) };
        if let Some(letter) = self.foreign_axis(*axis) {
            out.verbatim.push(self.foreign_position(letter, word, block)?);
            return Ok(true);
        }
        let axis = self.scope.axis(*axis)?;
        if text == "POSA" {
            let message = format!("POSA[{axis}]: the following blocks run while the axis still moves");
            return Err(fault(Code::NOT_SUPPORTED, word.span, message, "program POS, which waits for the axis"));
        }
        self.axis(axis.letter(), word, out)?;
        out.positioned.insert(axis);
        Ok(true)
    }

    /// The letter of an axis outside the machine file: a letter with an optional number.
    fn foreign_axis(&self, id: ExprId) -> Option<u8> {
        let name = match self.scope.value(id) {
            Ok(ExecValue::Axis(name)) => name.to_string(),
            Ok(_) => return None,
            Err(_) => match self.scope.program.expr(id).node {
                Node::Name(name) => self.scope.program.names.text(name).to_owned(),
                _ => return None,
            },
        };
        let (&letter, number) = name.as_bytes().split_first()?;
        let is_letter = letter.is_ascii_alphabetic() && letter != b'S' && number.iter().all(u8::is_ascii_digit);
        let is_own = Axis::from_letter(letter).is_some_and(|axis| self.machine_axes.contains(axis));
        (is_letter && !is_own).then_some(letter)
    }

    /// A position that is passed through. The output is metric and absolute.
    fn foreign_position(&self, letter: u8, word: &Word, block: &Block) -> Result<Vec<u8>, Fault> {
        let unit = match Axis::from_letter(letter) {
            Some(axis) if !axis.is_rotary() => ValueUnit::Length,
            None if self.scope.modal.modes.inch => {
                let message = "a position, in inch or degrees, of an axis that is not in the machine file";
                return Err(fault(Code::NOT_SUPPORTED, word.span, message, "program G71 or G710 before it"));
            }
            _ => ValueUnit::None,
        };
        let mut text = self.text(word, unit)?;
        if matches!(word.value, Value::Expr(_))
            && self.is_incremental(block)
            && let Some(at) = text.iter().position(|&byte| byte == b'=')
        {
            text.splice(at..=at, *b"=IC(");
            text.push(b')');
        }
        Ok(text)
    }

    /// `true` if G91 is active in a block.
    fn is_incremental(&self, block: &Block) -> bool {
        let words = self.scope.program.words_of(block).iter();
        let mut stated = words.filter_map(|word| match (word.address, word.value) {
            (Address::Letter(b'G'), Value::Number(90.0, _)) => Some(false),
            (Address::Letter(b'G'), Value::Number(91.0, _)) => Some(true),
            _ => None,
        });
        stated.next_back().unwrap_or(self.scope.modal.modes.incremental)
    }
}

/// `true` if a block moves positioning axes; rejects other motion in it.
pub(super) fn is_positioning(gathered: &Gathered, block: Span) -> Result<bool, Fault> {
    if gathered.positioned.is_empty() {
        return Ok(false);
    }
    let has_more = gathered.named != gathered.positioned
        || gathered.center.iter().any(Option::is_some)
        || gathered.taps
        || gathered.addresses.iter().any(|value| value.address.moves());
    if has_more {
        let message = "POS and a path motion in one block: only the control knows their timing";
        return Err(fault(Code::NOT_SUPPORTED, block, message, "give POS its own block"));
    }
    Ok(true)
}
