//! Expressions with Sinumerik's precedence: comparisons bind weakest, so `R1==1 AND R2==2` reads `R1==(1 AND R2)==2`.

use nom::Parser as _;
use nom::branch::alt;
use nom::bytes::complete::{tag, take_till, take_while1};
use nom::combinator::{map, map_opt, not, peek, value};
use nom::sequence::{delimited, preceded, terminated};

use super::block::Parser;
use super::token::{
    Input, Parsed, behind_blanks, blank, blanks, byte, digits, fault, identifier, is_name_byte, number, one, required,
    small_number, string,
};
use super::tree::{ArgumentRange, BlockNumber, DimensionFunction, Expr, ExprId, Node, Operator, UnaryOperator, Value};
use ncfix_base::diagnostic::Code;
use ncfix_base::source::Span;

/// Maximum nesting of brackets and signs.
const MAX_DEPTH: u32 = 64;
/// Maximum number of operators in one expression: the evaluation follows the chain of operands down to the first. A block of a control has 512
/// characters.
const MAX_OPERATORS: u32 = 500;

const UNCLOSED: &str = "this bracket is not closed in the block";

/// Precedence of an operator: higher binds first, equal ones from left to right.
fn strength(operator: Operator) -> u8 {
    match operator {
        Operator::Multiply | Operator::Divide | Operator::Div | Operator::Mod => 10,
        Operator::Add | Operator::Subtract => 9,
        Operator::BitAnd => 8,
        Operator::BitXor => 7,
        Operator::BitOr => 6,
        Operator::And => 5,
        Operator::Xor => 4,
        Operator::Or => 3,
        Operator::Concatenate => 2,
        Operator::Equal
        | Operator::NotEqual
        | Operator::Greater
        | Operator::Less
        | Operator::GreaterEqual
        | Operator::LessEqual => 1,
        Operator::Chain => 0,
    }
}

fn symbol_operator(input: Input<'_>) -> Parsed<'_, Operator> {
    alt((
        value(Operator::Concatenate, tag("<<")),
        value(Operator::Equal, tag("==")),
        value(Operator::NotEqual, tag("<>")),
        value(Operator::GreaterEqual, tag(">=")),
        value(Operator::LessEqual, tag("<=")),
        value(Operator::Greater, tag(">")),
        value(Operator::Less, tag("<")),
        value(Operator::Add, tag("+")),
        value(Operator::Subtract, tag("-")),
        value(Operator::Multiply, tag("*")),
        value(Operator::Divide, tag("/")),
        value(Operator::Chain, tag(":")),
    ))
    .parse(input)
}

fn word_operator(input: Input<'_>) -> Parsed<'_, Operator> {
    let named = |name: &[u8]| {
        Some(match name.to_ascii_uppercase().as_slice() {
            b"DIV" => Operator::Div,
            b"MOD" => Operator::Mod,
            b"B_AND" => Operator::BitAnd,
            b"B_XOR" => Operator::BitXor,
            b"B_OR" => Operator::BitOr,
            b"AND" => Operator::And,
            b"XOR" => Operator::Xor,
            b"OR" => Operator::Or,
            _ => return None,
        })
    };
    map_opt(take_while1(is_name_byte), named).parse(input)
}

/// Production `dimension`: the name of a function that defines the meaning of a position.
fn dimension(input: Input<'_>) -> Parsed<'_, DimensionFunction> {
    let function = |name: &[u8]| {
        Some(match name.to_ascii_uppercase().as_slice() {
            b"AC" => DimensionFunction::Absolute,
            b"IC" => DimensionFunction::Incremental,
            b"DC" => DimensionFunction::Shortest,
            b"ACP" => DimensionFunction::Positive,
            b"ACN" => DimensionFunction::Negative,
            b"CAC" | b"CIC" | b"CDC" | b"CACP" | b"CACN" | b"QU" | b"DAC" | b"DIC" | b"RAC" | b"RIC" | b"GP" => {
                DimensionFunction::Other
            }
            _ => return None,
        })
    };
    map_opt(identifier, function).parse(input)
}

impl Parser {
    /// Productions `value` and `list`, after `=`: an expression, a dimension function around one, or a list.
    pub(super) fn assigned_value<'a>(&mut self, input: Input<'a>) -> Parsed<'a, Value> {
        let input = blanks(input);
        if let Ok((open, function)) = terminated(dimension, (blank, peek(byte(b'(')))).parse(input) {
            let open = blanks(open);
            let inner = delimited(byte(b'('), |input| self.expression(input), behind_blanks(byte(b')')));
            return match map(inner, |inner| Value::Dimension(function, inner)).parse(open) {
                Err(nom::Err::Error(_)) => fault(Code::UNCLOSED, open, 1, UNCLOSED),
                found => found,
            };
        }
        match self.expression(input) {
            Ok((rest, id)) => Ok((rest, Value::Expr(id))),
            // A list, `(1,2,3)`, fails as an expression at its first comma.
            Err(_) if input.first() == Some(&b'(') && self.depth == 0 => {
                map(|input| self.arguments(input, b')'), Value::Arguments).parse(input)
            }
            Err(error) => Err(error),
        }
    }

    /// Productions `expr` and `frame`: a whole expression.
    pub(super) fn expression<'a>(&mut self, input: Input<'a>) -> Parsed<'a, ExprId> {
        self.depth += 1;
        if self.depth == 1 {
            self.operators = 0;
        }
        let result = if self.depth > MAX_DEPTH {
            fault(Code::TOO_DEEP, input, 1, "brackets are nested more than 64 deep")
        } else {
            self.binary(input, 0)
        };
        self.depth -= 1;
        result
    }

    /// Operands joined by operators of at least the given precedence, which determines the production.
    ///
    /// Productions `concatenation`, `or`, `xor`, `and`, `bit_or`, `bit_xor`, `bit_and`, `sum` and `product`.
    fn binary<'a>(&mut self, input: Input<'a>, weakest: u8) -> Parsed<'a, ExprId> {
        let (mut rest, mut left) = self.operand(input)?;
        loop {
            let at = blanks(rest);
            let operator = match at.first() {
                Some(b'a'..=b'z' | b'A'..=b'Z') => word_operator(at).ok(),
                Some(_) => symbol_operator(at).ok(),
                None => None,
            };
            let Some((behind, operator)) = operator.filter(|(_, operator)| strength(*operator) >= weakest) else {
                return Ok((rest, left));
            };
            self.operators += 1;
            if self.operators > MAX_OPERATORS {
                return fault(Code::TOO_DEEP, at, 1, "more than 500 operators in one expression");
            }
            // Operators of equal precedence join from left to right, so the right side accepts only higher ones.
            let (behind, right) = self.binary(behind, strength(operator) + 1)?;
            let span = self.span_of(left).to(self.span_of(right));
            left = self.push_expr(span, Node::Binary(operator, left, right));
            rest = behind;
        }
    }

    /// Production `primary`, with the signs before it.
    fn operand<'a>(&mut self, input: Input<'a>) -> Parsed<'a, ExprId> {
        let input = blanks(input);
        let Some(&first) = input.first() else {
            return fault(Code::BAD_EXPRESSION, input, 1, "an operand is missing at the end of the expression");
        };
        match first {
            b'0'..=b'9' | b'.' => {
                let (rest, number) = number(input)?;
                let node = if number.is_integer && number.value.abs() < 9e15 {
                    Node::Integer(number.value as i64)
                } else {
                    Node::Real(number.value)
                };
                Ok((rest, self.push_between(input, rest, node)))
            }
            b'+' => self.unary(input, 1, UnaryOperator::Plus),
            b'-' => self.unary(input, 1, UnaryOperator::Minus),
            b'(' => {
                let inner = delimited(byte(b'('), |input| self.expression(input), behind_blanks(byte(b')')));
                required(inner, Code::UNCLOSED, 1, UNCLOSED)(input)
            }
            b'"' => {
                let (rest, text) = string(input)?;
                let start = self.offset(input) + 1;
                let node = Node::Text(Span::new(start, start + text.len()));
                Ok((rest, self.push_between(input, rest, node)))
            }
            b'\'' => self.based_constant(input),
            // `<<R1` converts a number to a text.
            b'<' if input.starts_with(b"<<") => self.unary(input, 2, UnaryOperator::ToText),
            _ => self.named(input),
        }
    }

    /// Production `unary`: a sign or NOT and its operand.
    fn unary<'a>(&mut self, input: Input<'a>, length: usize, operator: UnaryOperator) -> Parsed<'a, ExprId> {
        self.depth += 1;
        let result = if self.depth > MAX_DEPTH {
            fault(Code::TOO_DEEP, input, length, "signs are nested more than 64 deep")
        } else {
            self.operand(&input[length..])
        };
        self.depth -= 1;
        let (rest, inner) = result?;
        Ok((rest, self.push_between(input, rest, Node::Unary(operator, inner))))
    }

    /// `'H1F'` or `'B101'`, of production `primary`.
    fn based_constant<'a>(&mut self, input: Input<'a>) -> Parsed<'a, ExprId> {
        const BAD: &str = "a constant in apostrophes has the form 'H1F' or 'B101'";
        let base = alt((
            value(16, one(|byte| byte.eq_ignore_ascii_case(&b'H'))),
            value(2, one(|byte| byte.eq_ignore_ascii_case(&b'B'))),
        ));
        let (digits, base) = required(preceded(byte(b'\''), base), Code::BAD_NUMBER, 1, BAD)(input)?;
        let Ok((rest, digits)) = terminated(take_till(|byte| byte == b'\''), byte(b'\'')).parse(digits) else {
            return fault(Code::UNCLOSED, input, 1, "this apostrophe is not closed in the block");
        };
        let text = std::str::from_utf8(digits).unwrap_or_default();
        let Ok(value) = i64::from_str_radix(text, base) else {
            return fault(Code::BAD_NUMBER, input, digits.len() + 3, BAD);
        };
        Ok((rest, self.push_between(input, rest, Node::Integer(value))))
    }

    /// Productions `variable`, `function`, `system`, `component` and `frame_term`, and the rest of `primary`: constants, parameters, variables, calls, NOT.
    fn named<'a>(&mut self, input: Input<'a>) -> Parsed<'a, ExprId> {
        if let Ok((rest, index)) = r_parameter(input) {
            return Ok((rest, self.push_between(input, rest, Node::Parameter(index))));
        }
        let (rest, name) = required(identifier, Code::BAD_EXPRESSION, 1, "this is not an operand")(input)?;
        let node = match name.to_ascii_uppercase().as_slice() {
            b"NOT" => return self.unary(input, name.len(), UnaryOperator::Not),
            b"B_NOT" => return self.unary(input, name.len(), UnaryOperator::BitNot),
            b"TRUE" => Node::Boolean(true),
            b"FALSE" => Node::Boolean(false),
            _ => return self.name_with_arguments(input, name, rest),
        };
        Ok((rest, self.push_between(input, rest, node)))
    }

    /// The left side of an assignment: `R5`, `R[…]`, `NAME`, `NAME[…]`.
    pub(super) fn left_side<'a>(&mut self, input: Input<'a>) -> Parsed<'a, ExprId> {
        self.named(input)
    }

    /// `left == right`, for a branch of CASE.
    pub(super) fn comparison(&mut self, left: ExprId, right: ExprId) -> ExprId {
        self.push_expr(self.span_of(right), Node::Binary(Operator::Equal, left, right))
    }

    fn name_with_arguments<'a>(&mut self, input: Input<'a>, name: &[u8], rest: Input<'a>) -> Parsed<'a, ExprId> {
        let id = self.intern(name);
        let open = blanks(rest);
        match open.first() {
            Some(b'[') if name.eq_ignore_ascii_case(b"R") => {
                let index = delimited(byte(b'['), |input| self.expression(input), behind_blanks(byte(b']')));
                let (rest, index) = required(index, Code::UNCLOSED, 1, UNCLOSED)(open)?;
                Ok((rest, self.push_between(input, rest, Node::ParameterAt(index))))
            }
            Some(b'[') => {
                let (rest, range) = self.arguments(open, b']')?;
                Ok((rest, self.push_between(input, rest, Node::Indexed(id, range))))
            }
            Some(b'(') => {
                let (rest, range) = self.arguments(open, b')')?;
                Ok((rest, self.push_between(input, rest, Node::Call(id, range))))
            }
            _ => Ok((rest, self.push_between(input, rest, Node::Name(id)))),
        }
    }

    /// Production `arguments`: `(a,,b)` or `[a,b]`, the opening bracket is the first byte of the input; empty slots are `None`.
    pub(super) fn arguments<'a>(&mut self, input: Input<'a>, close: u8) -> Parsed<'a, ArgumentRange> {
        let mut list = Vec::new();
        let mut rest = blanks(&input[1..]);
        if rest.first() == Some(&close) {
            return Ok((&rest[1..], ArgumentRange::default()));
        }
        loop {
            rest = blanks(rest);
            match rest.first() {
                Some(b',') => list.push(None),
                Some(byte) if *byte == close => list.push(None),
                _ => {
                    let (behind, id) = self.expression(rest)?;
                    list.push(Some(id));
                    rest = blanks(behind);
                }
            }
            match rest.first() {
                Some(b',') => rest = &rest[1..],
                Some(byte) if *byte == close => break,
                Some(_) => {
                    return fault(Code::BAD_EXPRESSION, rest, 1, "a ',' or the closing bracket was expected here");
                }
                None => return fault(Code::UNCLOSED, input, 1, UNCLOSED),
            }
        }
        let range = ArgumentRange {
            start: u32::try_from(self.program.arguments.next()).unwrap_or(u32::MAX),
            count: u16::try_from(list.len()).unwrap_or(u16::MAX),
        };
        self.program.arguments.extend(list);
        Ok((&rest[1..], range))
    }

    pub(super) fn push_between(&mut self, from: Input<'_>, to: Input<'_>, node: Node) -> ExprId {
        let span = Span::new(self.offset(from), self.offset(to));
        self.push_expr(span, node)
    }

    fn push_expr(&mut self, span: Span, node: Node) -> ExprId {
        let id = ExprId(u32::try_from(self.program.exprs.next()).unwrap_or(u32::MAX));
        self.program.exprs.push(Expr { span, node });
        id
    }

    fn span_of(&self, id: ExprId) -> Span {
        self.program.expr(id).span
    }
}

/// A block number as the target of a jump, of production `target`: `N123`, `:123`.
pub(super) fn target_number(input: Input<'_>) -> Parsed<'_, BlockNumber> {
    let start = one(|byte| matches!(byte, b'N' | b'n' | b':'));
    let behind = peek(terminated(digits, not(one(is_name_byte))));
    map((terminated(start, behind), small_number), |(first, number)| BlockNumber { main: first == b':', number })
        .parse(input)
}

/// `R5`, not followed by further characters of a name.
fn r_parameter(input: Input<'_>) -> Parsed<'_, u32> {
    let letter = terminated(one(|byte| byte.eq_ignore_ascii_case(&b'R')), peek(one(|byte| byte.is_ascii_digit())));
    delimited(letter, small_number, not(byte(b'_'))).parse(input)
}
