//! The nodes of expressions of the word languages.

use crate::syntax::names::NameId;
use ncfix_base::source::Span;

/// Index of an expression in [`super::Program::exprs`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct ExprId(pub(super) u32);

/// An expression.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Expr {
    /// Span of the expression.
    pub span: Span,
    /// Kind and operands.
    pub node: Node,
}

/// Kind and operands of an expression.
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

/// Operators with two operands. Whether AND, OR and XOR are bitwise or logical depends on the dialect's execution.
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
    /// Rounds to the nearest whole number.
    Round,
    /// Rounds down: `FIX`, on Fanuc towards zero.
    Fix,
    /// Rounds up: `FUP`, on Fanuc away from zero.
    Fup,
    /// Whole part: `int`.
    Int,
    /// Natural logarithm.
    Ln,
    /// Exponential function, base e.
    Exp,
    /// `POW[a,b]`
    Pow,
    /// Converts from binary-coded decimal.
    Bin,
    /// Converts to binary-coded decimal.
    Bcd,
    /// Adds a decimal point to an argument.
    Adp,
    /// A parameter of the control.
    Prm,
    /// Converts radians to degrees.
    Deg,
    /// Converts degrees to radians.
    Rad,
    /// 1 if a parameter exists, otherwise 0; its operand is [`Node::Named`], [`Node::Parameter`] or [`Node::ParameterAt`].
    Exists,
}
