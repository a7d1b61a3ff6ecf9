//! Values of expressions.

use super::channel::Channel;
use crate::diagnostic::Code;
use crate::exec::fault::{Fault, fault};
use crate::syntax::words::{ExprId, Node, Program, UnaryOperator};

/// Everything in scope of a block's expressions.
#[derive(Clone, Copy)]
pub(super) struct Scope<'s, 'a> {
    pub(super) program: &'s Program,
    #[allow(dead_code, reason = "for the variables")]
    pub(super) channel: &'s Channel<'a>,
}

impl Scope<'_, '_> {
    /// The value of an expression; `None` where it is undefined (null).
    pub(super) fn value(&self, id: ExprId) -> Result<Option<f64>, Fault> {
        let expr = self.program.expr(id);
        match expr.node {
            Node::Number(value) => Ok(Some(value)),
            Node::Unary(UnaryOperator::Plus, inner) => self.value(inner),
            Node::Unary(UnaryOperator::Minus, inner) => Ok(self.value(inner)?.map(|value| -value)),
            _ => Err(fault(
                Code::NOT_SUPPORTED,
                expr.span,
                "expressions are not supported yet",
                "write the value itself",
            )),
        }
    }
}
