//! The context for gathering the words of a block.

use super::expression::Scope;
use super::names::Meaning;
use crate::exec::core::fault::Fault;
use crate::exec::core::fault::fault;
use ncfix_base::diagnostic::Code;
use ncfix_base::geometry::AxisSet;
use ncfix_base::source::Span;
use ncfix_dialect::CodeTable;
/// Gathers blocks of one program.
#[derive(Clone, Copy)]
pub(super) struct Gatherer<'a> {
    pub(super) scope: Scope<'a>,
    pub(super) meanings: &'a [Meaning],
    pub(super) codes: &'static CodeTable,
    pub(super) machine_axes: AxisSet,
}

pub(super) fn once<T>(place: &mut Option<T>, value: T, span: Span) -> Result<(), Fault> {
    match place.replace(value) {
        Some(_) => Err(twice(span)),
        None => Ok(()),
    }
}

pub(super) fn twice(span: Span) -> Fault {
    fault(Code::DOUBLE_WORD, span, "this address is given twice in the block", "keep one of them, or split the block")
}
