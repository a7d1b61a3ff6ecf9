//! Words whose address has an index: `AX[…]=`. Assignments to elements of arrays and system variables were carried out before.

use super::fault::Fault;
use super::gather::Gatherer;
use super::gathered::Gathered;
use super::names::Meaning;
use crate::syntax::{ExprId, Node, Word};

impl Gatherer<'_> {
    /// Reads a word with an index.
    pub(super) fn indexed(&self, left: ExprId, word: &Word, out: &mut Gathered) -> Result<(), Fault> {
        let Node::Indexed(name, range) = self.scope.program.expr(left).node else { return Ok(()) };
        let text = self.scope.program.names.text(name);
        if text.starts_with('$') || self.scope.variables.has(name, text) {
            return Ok(());
        }
        match (text, self.scope.program.arguments_of(range)) {
            // The axis itself, found at run time.
            ("AX", [Some(axis)]) => {
                let axis = self.scope.axis(*axis)?;
                self.axis(axis.letter(), word, out)
            }
            // An array that nobody has defined.
            _ if matches!(self.meanings[name.index()], Meaning::Free) => Err(self.scope.undefined(text, left)),
            _ => Err(self.unsupported(word)),
        }
    }
}
