//! Words whose address has an index: `AX[…]=`. Assignments to array elements and system variables are already executed.

use super::gathered::Gathered;
use super::gatherer::Gatherer;
use super::groups::code_of;
use super::names::Meaning;
use crate::exec::core::fault::{Fault, fault};
use crate::syntax::sinumerik::{ExprId, Node, Value, Word};
use ncfix_base::diagnostic::Code;

impl Gatherer<'_> {
    /// Reads a word with an index.
    pub(super) fn indexed(&self, left: ExprId, word: &Word, out: &mut Gathered) -> Result<(), Fault> {
        let Node::Indexed(name, range) = self.scope.program.expr(left).node else { return Ok(()) };
        let text = self.scope.program.names.text(name);
        if text.starts_with('$') || self.scope.variables.has(name, text) {
            return Ok(());
        }
        match (text, self.scope.program.arguments_of(range)) {
            // The axis, determined at run time.
            ("AX", [Some(axis)]) => {
                let axis = self.scope.axis(*axis)?;
                self.axis(axis.letter(), word, out)
            }
            ("G", [Some(group)]) => self.code_by_number(*group, word, out),
            ("PO", axes) => self.polynomial(axes, word, out),
            // An undefined array.
            _ if matches!(self.meanings[name.index()], Meaning::Free) => Err(self.scope.undefined(text, left)),
            _ => Err(self.unsupported(word)),
        }
    }

    /// `G[8]=2`: the second code of group 8.
    fn code_by_number(&self, group: ExprId, word: &Word, out: &mut Gathered) -> Result<(), Fault> {
        let Value::Expr(value) = word.value else { return Err(self.unsupported(word)) };
        let (group, number) = (self.scope.whole(group)?, self.scope.whole(value)?);
        let unknown = || {
            let message = format!("G[{group}]={number}: codes by number are not known for this one");
            fault(Code::NOT_SUPPORTED, word.span, message, "program the code by its name")
        };
        let name = code_of(group, number).ok_or_else(unknown)?;
        match self.codes.word(&name) {
            Some(entry) => self.code(entry, word.span, out),
            None => {
                self.group(8, word.span, out)?;
                out.offset = Some((name, word.span));
                Ok(())
            }
        }
    }
}
