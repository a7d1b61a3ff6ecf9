//! The nodes of expressions of the word languages.

use crate::syntax::names::NameId;
use ncfix_base::source::Span;

/// Number of an expression in [`super::Program::exprs`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct ExprId(pub(super) u32);

/// An expression.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Expr {
    /// Its bytes.
    pub span: Span,
    /// What it is.
    pub node: Node,
}

/// What an expression is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Node {
    /// `1.5`, `pi`
    Number(f64),
    /// `#5`, `E5`
    Parameter(u32),
    /// `#[…]`, `##5`, `E(…)`: the number of the parameter is computed.
    ParameterAt(ExprId),
    /// `#<name>`
    Named(NameId),
    /// `SIN[…]`, `ATAN[a]/[b]`, `POW[a,b]`
    Call(Function, ExprId, Option<ExprId>),
    /// `-a`
    Unary(UnaryOperator, ExprId),
    /// `a + b`
    Binary(Operator, ExprId, ExprId),
}

/// Operators with one operand.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum UnaryOperator {
    /// `+`
    Plus,
    /// `-`
    Minus,
    /// `not(…)`
    Not,
}

/// Operators with two operands. What AND, OR and XOR do, with bits or with truth, is the business of the dialect's execution.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[expect(missing_docs, reason = "the names are the operators' names")]
pub enum Operator {
    Power,
    Multiply,
    Divide,
    Mod,
    Add,
    Subtract,
    And,
    Or,
    Xor,
    Equal,
    NotEqual,
    Greater,
    GreaterEqual,
    Less,
    LessEqual,
}

/// Functions.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Function {
    /// Sine of degrees.
    Sin,
    /// Cosine of degrees.
    Cos,
    /// Tangent of degrees.
    Tan,
    /// Arc sine in degrees.
    Asin,
    /// Arc cosine in degrees.
    Acos,
    /// Arc tangent in degrees, of one value or of `[y]/[x]`.
    Atan,
    /// Square root.
    Sqrt,
    /// Absolute value.
    Abs,
    /// To the nearest whole number.
    Round,
    /// Down: `FIX`, of Fanuc towards zero.
    Fix,
    /// Up: `FUP`, of Fanuc away from zero.
    Fup,
    /// Whole part: `int`.
    Int,
    /// Natural logarithm.
    Ln,
    /// Power of e.
    Exp,
    /// `POW[a,b]`
    Pow,
    /// From binary-coded decimal.
    Bin,
    /// To binary-coded decimal.
    Bcd,
    /// Adds a decimal point to an argument.
    Adp,
    /// A parameter of the control.
    Prm,
    /// Degrees of radians.
    Deg,
    /// Radians of degrees.
    Rad,
    /// Whether a parameter exists; its operand is [`Node::Named`], [`Node::Parameter`] or [`Node::ParameterAt`].
    Exists,
}
