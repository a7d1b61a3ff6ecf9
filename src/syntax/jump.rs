//! Jumps and their targets.

use super::names::NameId;
use super::tree::{BlockNumber, ExprId};
use crate::source::Span;

/// A jump of a block.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Jump {
    /// From the keyword to the target.
    pub span: Span,
    /// `IF …` before it.
    pub condition: Option<ExprId>,
    /// Where to look.
    pub search: Search,
    /// What to look for.
    pub target: JumpTarget,
}

/// Where a jump looks for its target.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Search {
    /// `GOTOF`
    Forward,
    /// `GOTOB`
    Backward,
    /// `GOTO`: to the end, then from the start.
    Around,
    /// `GOTOC`: the same, going on where it finds nothing.
    AroundIfAny,
    /// `GOTOS`: the start of the program.
    Start,
}

/// What a jump looks for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum JumpTarget {
    /// A label.
    Label(NameId),
    /// A block number.
    Number(BlockNumber),
    /// A computed name, which is known but not executed yet.
    Computed,
    /// The start (GOTOS).
    Start,
}
