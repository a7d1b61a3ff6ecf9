//! A call that is evaluated: what is called, how, and with what.

use ncfix_base::source::Span;

/// Variables and their values, in the order of the words; null ones are left out.
pub(super) type Arguments = Vec<(u32, f64)>;

/// What is called.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Callee {
    /// `P1234`
    Number(u32),
    /// `P51002`: 1002 five times, unless there is a program 51002 and no program 1002.
    Counted(u32),
    /// `<NAME>`
    Name(String),
    /// `o<name>`, `o100`
    Sub(String),
}

/// How it is called.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum CallKind {
    /// M98: sees the variables of its caller.
    Subprogram,
    /// G65, G66 and mapped codes: has variables of its own.
    Macro,
    /// A mapped T: the tool number.
    Tool(f64),
    /// O-word
    Sub,
}

/// A call that is evaluated.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Call {
    pub(super) callee: Callee,
    pub(super) kind: CallKind,
    pub(super) repeats: u32,
    pub(super) arguments: Arguments,
    pub(super) span: Span,
    /// Whether a mapped code calls: such codes mean what they always mean within.
    pub(super) is_of_code: bool,
}
