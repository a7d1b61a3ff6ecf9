//! An evaluated argument of a call.

use super::cells::Cells;
use crate::syntax::sinumerik::NameId;

/// An argument of a call.
#[derive(Clone, Debug, Default)]
pub(super) struct Argument {
    /// The value as the parameter stores it; `None` for an empty slot.
    pub(super) cells: Option<Cells>,
    /// The caller's variable, for VAR.
    pub(super) reference: Option<Reference>,
}

/// A variable of the caller, indices evaluated.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Reference {
    Parameter(i64),
    Name(NameId),
    Element(NameId, Vec<i64>),
}
