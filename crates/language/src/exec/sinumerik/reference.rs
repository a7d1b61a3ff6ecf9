//! Blocks with G74 or G75: axes move to their reference point or to a fixed point of the machine, which only the control knows.
//!
//! The code, the number of the point and the axes are passed through. The axis words are not positions and may name machine axes (`X1=0`); after the
//! block the position of these axes is unknown. All other words act as in any block.

use super::gathered::Gathered;
use super::gatherer::Gatherer;
use super::names::Meaning;
use crate::exec::core::fault::Fault;
use crate::syntax::sinumerik::{Address, Block, Value, Word};
use ncfix_base::geometry::{Axis, AxisSet};
use ncfix_dialect::{CodeEffect, CodeEntry, ValueUnit};

/// The number of the fixed point.
const POINT: &str = "FP";

impl Gatherer<'_> {
    /// `true` if the words contain G74 or G75.
    pub(super) fn is_reference(&self, words: &[Word]) -> bool {
        words.iter().any(|word| self.reference_code(word).is_some())
    }

    fn reference_code(&self, word: &Word) -> Option<&'static CodeEntry> {
        let (Address::Letter(b'G'), Value::Number(number, _)) = (word.address, word.value) else { return None };
        let is_whole = number.fract() == 0.0 && (0.0..=999.0).contains(&number);
        let entry = self.codes.g(is_whole.then_some(number as usize)?)?;
        (entry.effect == CodeEffect::Reference).then_some(entry)
    }

    /// Reads a block with G74 or G75 from its beginning.
    ///
    /// Production `reference`.
    pub(super) fn reference(&self, block: &Block) -> Result<Gathered, Fault> {
        let mut out = Gathered::new();
        out.is_reference = true;
        let mut text = Vec::new();
        let (mut lost, mut names_axis) = (AxisSet::EMPTY, false);
        for word in self.scope.program.words_of(block) {
            if let Some(entry) = self.reference_code(word) {
                self.group(entry.group, word.span, &mut out)?;
            } else if let Some(axes) = self.referenced(word) {
                lost = lost.union(axes);
                names_axis = true;
            } else if !self.is_point(word) {
                self.word(word, block, &mut out)?;
                continue;
            }
            if !text.is_empty() {
                text.push(b' ');
            }
            text.extend(self.text(word, ValueUnit::None)?);
        }
        out.verbatim.push(text);
        out.lost = out.lost.union(if names_axis { lost } else { AxisSet::ALL });
        Ok(out)
    }

    fn is_point(&self, word: &Word) -> bool {
        matches!(word.address, Address::Name(name) if self.scope.program.names.text(name) == POINT)
    }

    /// The axes of an axis word; `None` for another word.
    fn referenced(&self, word: &Word) -> Option<AxisSet> {
        match word.address {
            // X1 is the first machine axis of X; it moves no other axis on any machine.
            Address::Letter(letter) | Address::Extended(letter, _) => {
                Axis::from_letter(letter).map(|axis| [axis].into_iter().collect())
            }
            Address::Name(name) if !self.is_point(word) && matches!(word.value, Value::Expr(_)) => {
                let text = self.scope.program.names.text(name);
                let is_axis =
                    matches!(self.meanings[name.index()], Meaning::Free) && !self.scope.variables.has(name, text);
                // Only the control knows this axis.
                let named = self.scope.machine.axis_named(text).map(|axis| [axis].into_iter().collect());
                is_axis.then(|| named.unwrap_or(AxisSet::ALL))
            }
            _ => None,
        }
    }
}
