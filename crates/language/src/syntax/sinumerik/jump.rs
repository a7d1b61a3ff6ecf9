//! Jumps, their targets, and the repetition of program parts.

use super::tree::{BlockNumber, ExprId};
use crate::syntax::names::NameId;
use ncfix_base::source::Span;

/// A jump of a block.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Jump {
    /// From the keyword to the target.
    pub span: Span,
    /// `IF …` before it; a branch of CASE compares here.
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
    /// The block that is repeated, or with which the part begins.
    pub first: JumpTarget,
    /// The last block, where it is named.
    pub last: Option<JumpTarget>,
    /// REPEATB: only the one block.
    pub one_block: bool,
    /// `P`: how many times.
    pub count: Option<ExprId>,
}
