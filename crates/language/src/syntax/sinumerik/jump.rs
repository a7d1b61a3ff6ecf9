//! Jumps, their targets, and the repetition of program parts.

use super::tree::{BlockNumber, ExprId};
use crate::syntax::names::NameId;
use ncfix_base::source::Span;

/// A jump of a block.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Jump {
    /// From the keyword to the target.
    pub span: Span,
    /// Condition of a preceding `IF …`, or the comparison of a CASE branch.
    pub condition: Option<ExprId>,
    /// Search direction.
    pub search: Search,
    /// Target.
    pub target: JumpTarget,
}

/// Search direction of a jump.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Search {
    /// `GOTOF`
    Forward,
    /// `GOTOB`
    Backward,
    /// `GOTO`: to the end, then from the start.
    Around,
    /// `GOTOC`: as `GOTO`, but continues if the target is missing.
    AroundIfAny,
    /// `GOTOS`: the start of the program.
    Start,
}

/// Target of a jump.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum JumpTarget {
    /// A label, or a variable that holds one.
    Label(NameId),
    /// A block number.
    Number(BlockNumber),
    /// A computed name.
    Computed(ExprId),
    /// The start (GOTOS).
    Start,
}

/// `REPEAT label …` or `REPEATB label …`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Repetition {
    /// From the keyword to the last label.
    pub span: Span,
    /// The repeated block, or the first one of the repeated part.
    pub first: JumpTarget,
    /// The last block, if named.
    pub last: Option<JumpTarget>,
    /// REPEATB: a single block.
    pub one_block: bool,
    /// `P`: number of repetitions.
    pub count: Option<ExprId>,
}
