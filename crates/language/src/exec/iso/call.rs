//! An evaluated call: the program, the kind of call, and the arguments.

use super::data_origin::DataOrigin;
use ncfix_base::source::Span;

/// Variables, their values and the origin of these in data of the control, in the order of the words, without null values.
pub(super) type Arguments = Vec<(u32, f64, Option<DataOrigin>)>;

/// The called program.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Callee {
    /// `P1234`
    Number(u32),
    /// `P51002`: 1002 five times, unless there is a program 51002 and no program 1002.
    Counted(u32),
    /// `<NAME>`
    Name(String),
    /// The program that contains the call: `M98 Q100`, `M97 P100`.
    Own,
    /// `o<name>`, `o100`
    Sub(String),
}

/// Kind of a call.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum CallKind {
    /// M98: uses the variables of its caller.
    Subprogram,
    /// G65, G66 and mapped codes: has its own variables.
    Macro,
    /// A mapped T: the tool number.
    Tool(f64),
    /// O-word
    Sub,
}

/// An evaluated call.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Call {
    pub(super) callee: Callee,
    pub(super) kind: CallKind,
    pub(super) repeats: u32,
    /// The block number at which the program begins, if it is not its first block (`M98 Q`).
    pub(super) at_block: Option<u32>,
    pub(super) arguments: Arguments,
    pub(super) span: Span,
    /// `true` for a call by a mapped code: within it, such codes have their standard meaning.
    pub(super) is_of_code: bool,
}
