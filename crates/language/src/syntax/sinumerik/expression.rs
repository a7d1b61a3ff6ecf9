//! Expressions with Sinumerik's precedence: comparisons bind weakest, so `R1==1 AND R2==2` reads `R1==(1 AND R2)==2`.

use nom::branch::alt;
use nom::bytes::complete::{tag, tag_no_case, take_while1};
use nom::combinator::{map, value, verify};

use super::block::Parser;
use super::token::{
    Fault, Input, Parsed, blanks, digits, fault, identifier, is_name_byte, number, small_number, string,
};
use super::tree::{ArgumentRange, DimensionFunction, Expr, ExprId, Node, Operator, UnaryOperator, Value};
use ncfix_base::diagnostic::Code;
use ncfix_base::source::Span;

/// Brackets and signs may be nested this deep.
const MAX_DEPTH: u32 = 64;

/// How strongly an operator binds: higher goes first, equal ones from left to right.
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
    .parse_input(input)
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
    map(verify(take_while1(is_name_byte), move |name: &[u8]| named(name).is_some()), move |name: &[u8]| {
        named(name).unwrap_or(Operator::Add)
    })
    .parse_input(input)
}

/// Lets nom's parser values be called like functions, with our fault type fixed.
trait ParseInput<'a, T> {
    fn parse_input(self, input: Input<'a>) -> Parsed<'a, T>;
}

impl<'a, T, P: nom::Parser<Input<'a>, Output = T, Error = Fault>> ParseInput<'a, T> for P {
    fn parse_input(mut self, input: Input<'a>) -> Parsed<'a, T> {
        self.parse(input)
    }
}

impl Parser {
    /// The value behind `=`: an expression, or a dimension function around one.
    pub(super) fn assigned_value<'a>(&mut self, input: Input<'a>) -> Parsed<'a, Value> {
        let input = blanks(input);
        if let Ok((rest, name)) = identifier(input) {
            let function = match name.to_ascii_uppercase().as_slice() {
                b"AC" => Some(DimensionFunction::Absolute),
                b"IC" => Some(DimensionFunction::Incremental),
                b"DC" => Some(DimensionFunction::Shortest),
                b"ACP" => Some(DimensionFunction::Positive),
                b"ACN" => Some(DimensionFunction::Negative),
                b"CAC" | b"CIC" | b"CDC" | b"CACP" | b"CACN" | b"QU" | b"DAC" | b"DIC" | b"RAC" | b"RIC" | b"GP" => {
                    Some(DimensionFunction::Other)
                }
                _ => None,
            };
            if let (Some(function), Some(b'(')) = (function, blanks(rest).first()) {
                let open = blanks(rest);
                let (rest, inner) = self.expression(&open[1..])?;
                return match blanks(rest).first() {
                    Some(b')') => Ok((&blanks(rest)[1..], Value::Dimension(function, inner))),
                    _ => fault(Code::UNCLOSED, open, 1, "this bracket is not closed in the block"),
                };
            }
        }
        match self.expression(input) {
            Ok((rest, id)) => Ok((rest, Value::Expr(id))),
            // A list, `(1,2,3)`, fails as an expression at its first comma.
            Err(_) if input.first() == Some(&b'(') && self.depth == 0 => {
                let (rest, range) = self.arguments(input, b')')?;
                Ok((rest, Value::Arguments(range)))
            }
            Err(error) => Err(error),
        }
    }

    /// A whole expression.
    pub(super) fn expression<'a>(&mut self, input: Input<'a>) -> Parsed<'a, ExprId> {
        self.depth += 1;
        let result = if self.depth > MAX_DEPTH {
            fault(Code::TOO_DEEP, input, 1, "brackets are nested more than 64 deep")
        } else {
            self.binary(input, 0)
        };
        self.depth -= 1;
        result
    }

    /// Operands joined by operators of at least the given strength.
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
            // Operators of one strength join from left to right, so the right side takes only stronger ones.
            let (behind, right) = self.binary(behind, strength(operator) + 1)?;
            let span = self.span_of(left).to(self.span_of(right));
            left = self.push_expr(span, Node::Binary(operator, left, right));
            rest = behind;
        }
    }

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
                let (rest, inner) = self.expression(&input[1..])?;
                let rest = blanks(rest);
                match rest.first() {
                    Some(b')') => Ok((&rest[1..], inner)),
                    _ => fault(Code::UNCLOSED, input, 1, "this bracket is not closed in the block"),
                }
            }
            b'"' => {
                let (rest, text) = string(input)?;
                let start = self.offset(input) + 1;
                let node = Node::Text(Span::new(start, start + text.len()));
                Ok((rest, self.push_between(input, rest, node)))
            }
            b'\'' => self.based_constant(input),
            // `<<R1` makes a text of a number.
            b'<' if input.starts_with(b"<<") => self.unary(input, 2, UnaryOperator::ToText),
            _ => self.named(input),
        }
    }

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

    /// `'H1F'` or `'B101'`.
    fn based_constant<'a>(&mut self, input: Input<'a>) -> Parsed<'a, ExprId> {
        const BAD: &str = "a constant in apostrophes reads 'H1F' or 'B101'";
        let base = match input.get(1) {
            Some(b'H' | b'h') => 16,
            Some(b'B' | b'b') => 2,
            _ => return fault(Code::BAD_NUMBER, input, 1, BAD),
        };
        let Some(length) = input[2..].iter().position(|&byte| byte == b'\'') else {
            return fault(Code::UNCLOSED, input, 1, "this apostrophe is not closed in the block");
        };
        let text = std::str::from_utf8(&input[2..2 + length]).unwrap_or_default();
        let Ok(value) = i64::from_str_radix(text, base) else {
            return fault(Code::BAD_NUMBER, input, length + 3, BAD);
        };
        let rest = &input[length + 3..];
        Ok((rest, self.push_between(input, rest, Node::Integer(value))))
    }

    /// Whatever begins with a name: constants, parameters, variables, calls, NOT.
    fn named<'a>(&mut self, input: Input<'a>) -> Parsed<'a, ExprId> {
        if matches!(input, [b'R' | b'r', digit, ..] if digit.is_ascii_digit())
            && let Ok((rest, index)) = small_number(&input[1..])
            && rest.first() != Some(&b'_')
        {
            return Ok((rest, self.push_between(input, rest, Node::Parameter(index))));
        }
        let Ok((rest, name)) = identifier(input) else {
            return fault(Code::BAD_EXPRESSION, input, 1, "this is no operand");
        };
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
                let (rest, index) = self.expression(&open[1..])?;
                let rest = blanks(rest);
                if rest.first() != Some(&b']') {
                    return fault(Code::UNCLOSED, open, 1, "this bracket is not closed in the block");
                }
                let rest = &rest[1..];
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

    /// `(a,,b)` or `[a,b]`: the opening bracket is the first byte of the input; empty slots are `None`.
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
                None => return fault(Code::UNCLOSED, input, 1, "this bracket is not closed in the block"),
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

/// A keyword at the start of the input, not followed by more of a name.
pub(super) fn keyword<'a>(word: &'static str, input: Input<'a>) -> Option<Input<'a>> {
    let (rest, _) = tag_no_case::<_, _, Fault>(word)(input).ok()?;
    (!rest.first().is_some_and(|&byte| is_name_byte(byte))).then_some(rest)
}

/// `N123` or `:123` as a jump target.
pub(super) fn target_number(input: Input<'_>) -> Option<(Input<'_>, bool, u32)> {
    let main = match input.first()? {
        b':' => true,
        b'N' | b'n' => false,
        _ => return None,
    };
    let (rest, _) = digits(&input[1..]).ok()?;
    if rest.first().is_some_and(|&byte| is_name_byte(byte)) {
        return None;
    }
    let (rest, value) = small_number(&input[1..]).ok()?;
    Some((rest, main, value))
}
