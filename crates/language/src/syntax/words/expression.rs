//! Expressions of the word languages: one precedence-climbing parser, with operators and functions of each language.

use nom::Parser as _;
use nom::branch::alt;
use nom::combinator::{map, opt, peek};
use nom::sequence::{preceded, terminated};

use super::node::{Expr, ExprId, Function, Node, Operator, UnaryOperator};
use super::parser::Parser;
use super::token::{Input, Parsed, angled, behind_blanks, blanks, byte, fault, letters, number, one_of, small_number};
use ncfix_base::diagnostic::Code;
use ncfix_base::source::Span;
use ncfix_dialect::Language;

/// Maximum nesting of brackets and signs.
const MAX_DEPTH: u32 = 64;

const UNCLOSED: &str = "this bracket is not closed in the block";

/// Operators of Fanuc's custom macros.
const FANUC_OPERATORS: &[(&str, Operator)] = &[
    ("*", Operator::Multiply),
    ("/", Operator::Divide),
    ("+", Operator::Add),
    ("-", Operator::Subtract),
    ("MOD", Operator::Mod),
    ("AND", Operator::And),
    ("OR", Operator::Or),
    ("XOR", Operator::Xor),
    ("EQ", Operator::Equal),
    ("NE", Operator::NotEqual),
    ("GT", Operator::Greater),
    ("GE", Operator::GreaterEqual),
    ("LT", Operator::Less),
    ("LE", Operator::LessEqual),
];

/// Operators of RS274/NGC in addition to those of Fanuc, which it has too.
const POWER: &[(&str, Operator)] = &[("**", Operator::Power)];

const GRUNDIG_OPERATORS: &[(&str, Operator)] = &[
    ("^", Operator::Power),
    ("*", Operator::Multiply),
    (":", Operator::Divide),
    ("/", Operator::Divide),
    ("+", Operator::Add),
    ("-", Operator::Subtract),
    ("=", Operator::Equal),
    ("<>", Operator::NotEqual),
    (">=", Operator::GreaterEqual),
    ("<=", Operator::LessEqual),
    (">", Operator::Greater),
    ("<", Operator::Less),
    ("AND", Operator::And),
    ("XOR", Operator::Xor),
    ("OR", Operator::Or),
];

/// Functions of all these languages.
const FUNCTIONS: &[(&str, Function)] = &[
    ("SIN", Function::Sin),
    ("COS", Function::Cos),
    ("TAN", Function::Tan),
    ("ASIN", Function::Asin),
    ("ACOS", Function::Acos),
    ("ATAN", Function::Atan),
    ("SQRT", Function::Sqrt),
    ("ABS", Function::Abs),
    ("ROUND", Function::Round),
    ("LN", Function::Ln),
    ("EXP", Function::Exp),
];

/// Functions common to Fanuc and RS274/NGC, in addition.
const ISO_FUNCTIONS: &[(&str, Function)] = &[("FIX", Function::Fix), ("FUP", Function::Fup)];

/// Functions that only RS274/NGC has.
const RS274_FUNCTIONS: &[(&str, Function)] = &[("EXISTS", Function::Exists)];

/// Functions that only Fanuc has.
const FANUC_FUNCTIONS: &[(&str, Function)] = &[
    ("POW", Function::Pow),
    ("BIN", Function::Bin),
    ("BCD", Function::Bcd),
    ("ADP", Function::Adp),
    ("PRM", Function::Prm),
];

/// Functions that only Grundig has.
const GRUNDIG_FUNCTIONS: &[(&str, Function)] =
    &[("INT", Function::Int), ("RND", Function::Round), ("DEG", Function::Deg), ("RAD", Function::Rad)];

/// Precedence of the power operator: the highest.
const POWER_STRENGTH: u8 = 6;
/// Precedence of comparisons.
const COMPARISON: u8 = 3;

/// Precedence of an operator: higher binds first, equal ones from left to right.
fn strength(operator: Operator, language: Language) -> u8 {
    match operator {
        Operator::Power => POWER_STRENGTH,
        Operator::Multiply | Operator::Divide | Operator::Mod => 5,
        Operator::Add | Operator::Subtract => 4,
        // Fanuc's logic is bitwise, so it has the precedence of multiplication and addition.
        Operator::And if language == Language::Fanuc => 5,
        Operator::Or | Operator::Xor if language == Language::Fanuc => 4,
        Operator::And if language == Language::Grundig => 2,
        Operator::Or | Operator::Xor if language == Language::Grundig => 1,
        Operator::And | Operator::Or | Operator::Xor => 1,
        Operator::Equal
        | Operator::NotEqual
        | Operator::Greater
        | Operator::GreaterEqual
        | Operator::Less
        | Operator::LessEqual => COMPARISON,
    }
}

impl Parser {
    /// Productions `expression` (fanuc, rs274) and `relation` (grundig): operands joined by operators.
    pub(super) fn expression<'a>(&mut self, input: Input<'a>) -> Parsed<'a, ExprId> {
        self.deeper(input, |parser| parser.binary(input, 0))
    }

    fn deeper<'a, T>(&mut self, input: Input<'a>, parse: impl FnOnce(&mut Self) -> Parsed<'a, T>) -> Parsed<'a, T> {
        self.depth += 1;
        let result = if self.depth > MAX_DEPTH {
            fault(Code::TOO_DEEP, input, 1, "brackets and signs are nested more than 64 deep")
        } else {
            parse(self)
        };
        self.depth -= 1;
        result
    }

    /// The operator at the start of the input.
    pub(super) fn operator<'a>(&self, input: Input<'a>) -> Parsed<'a, Operator> {
        match self.language {
            Language::Grundig => one_of(GRUNDIG_OPERATORS)(input),
            Language::Rs274 => alt((one_of(POWER), one_of(FANUC_OPERATORS))).parse(input),
            _ => one_of(FANUC_OPERATORS)(input),
        }
    }

    /// Operands joined by operators of at least the given precedence, which determines the production.
    ///
    /// Productions `sum` and `product` (fanuc, rs274, grundig), `comparison` (rs274, grundig), `conjunction` (grundig), `power` (rs274, grundig).
    fn binary<'a>(&mut self, input: Input<'a>, weakest: u8) -> Parsed<'a, ExprId> {
        let (mut rest, mut left) = self.operand(input)?;
        let mut compared = false;
        loop {
            let at = blanks(rest);
            let Ok((behind, operator)) = self.operator(at) else { return Ok((rest, left)) };
            let strength = strength(operator, self.language);
            if strength < weakest {
                return Ok((rest, left));
            }
            if strength == COMPARISON && self.language == Language::Fanuc {
                // The second comparison would use the bitwise result of AND, which is never intended.
                if compared {
                    let message = "a second comparison needs its own brackets: [[#1 EQ 1] AND [#2 EQ 2]]";
                    return fault(Code::BAD_EXPRESSION, at, 2, message);
                }
                compared = true;
            }
            // Operators of equal precedence join from left to right, so the right side accepts only higher ones.
            let (behind, right) = self.deeper(behind, |parser| parser.binary(behind, strength + 1))?;
            let span = self.program.expr(left).span.to(self.program.expr(right).span);
            left = self.push_expr(span, Node::Binary(operator, left, right));
            rest = behind;
        }
    }

    /// One operand: a number, a parameter, a function or a bracket, with any sign.
    ///
    /// Productions `factor` (fanuc, grundig) and `operand` (grundig).
    pub(super) fn operand<'a>(&mut self, input: Input<'a>) -> Parsed<'a, ExprId> {
        let input = blanks(input);
        match input.first() {
            None => fault(Code::BAD_EXPRESSION, input, 1, "an operand is missing at the end of the expression"),
            Some(b'0'..=b'9' | b'.') => {
                let (rest, number) = number(input, self.is_spaced())?;
                self.no_exponent(input, rest)?;
                Ok((rest, self.push_between(input, rest, Node::Number(number.value))))
            }
            Some(b'+') => self.unary(input, 1, UnaryOperator::Plus),
            Some(b'-') => self.unary(input, 1, UnaryOperator::Minus),
            Some(b'[') if self.language != Language::Grundig => self.bracket(input, b']'),
            Some(b'(') if self.language == Language::Grundig => self.bracket(input, b')'),
            Some(b'#') if self.language != Language::Grundig => self.parameter(input),
            Some(b'E' | b'e') if self.language == Language::Grundig && !keyword_exp(input) => self.e_parameter(input),
            Some(byte) if byte.is_ascii_alphabetic() => self.function(input),
            Some(_) => fault(Code::BAD_EXPRESSION, input, 1, "this is not an operand"),
        }
    }

    fn unary<'a>(&mut self, input: Input<'a>, length: usize, operator: UnaryOperator) -> Parsed<'a, ExprId> {
        let behind = &input[length..];
        let (rest, inner) = self.deeper(behind, |parser| match parser.language {
            // -E1^2 is -(E1^2).
            Language::Grundig => parser.binary(behind, POWER_STRENGTH),
            Language::Fanuc if matches!(blanks(behind).first(), Some(b'+' | b'-')) => {
                fault(Code::BAD_EXPRESSION, blanks(behind), 1, "two signs in sequence")
            }
            _ => parser.operand(behind),
        })?;
        Ok((rest, self.push_between(input, rest, Node::Unary(operator, inner))))
    }

    /// `[…]` or `(…)`: the first byte of the input opens it.
    pub(super) fn bracket<'a>(&mut self, input: Input<'a>, close: u8) -> Parsed<'a, ExprId> {
        let (rest, inner) = self.expression(&input[1..])?;
        match blanks(rest) {
            [byte, rest @ ..] if *byte == close => Ok((rest, inner)),
            [] => fault(Code::UNCLOSED, input, 1, UNCLOSED),
            other => fault(Code::BAD_EXPRESSION, other, 1, "an operator or the closing bracket was expected here"),
        }
    }

    /// Productions `variable` (fanuc) and `parameter` (rs274): `#5`, `#[…]`, `##5`, `#<name>`: the first byte of the input is `#`.
    pub(super) fn parameter<'a>(&mut self, input: Input<'a>) -> Parsed<'a, ExprId> {
        let behind = blanks(&input[1..]);
        let (rest, node) = match behind.first() {
            Some(b'0'..=b'9') => map(|input| small_number(input, self.is_spaced()), Node::Parameter).parse(behind)?,
            Some(b'<') => map(angled, |name| Node::Named(self.intern(name))).parse(behind)?,
            Some(&byte)
                if b"#[".contains(&byte) || (byte.is_ascii_alphabetic() && self.language == Language::Rs274) =>
            {
                let (rest, inner) = self.deeper(behind, |parser| parser.operand(behind))?;
                (rest, Node::ParameterAt(inner))
            }
            _ => {
                return fault(
                    Code::BAD_EXPRESSION,
                    input,
                    1,
                    "a number, a name in < > or an expression in [ ] must follow #",
                );
            }
        };
        Ok((rest, self.push_between(input, rest, node)))
    }

    /// Production `parameter` (grundig): `E5`, `E(…)`.
    fn e_parameter<'a>(&mut self, input: Input<'a>) -> Parsed<'a, ExprId> {
        let behind = &input[1..];
        let (rest, node) = match behind.first() {
            Some(b'(') => map(|input| self.bracket(input, b')'), Node::ParameterAt).parse(behind)?,
            Some(b'0'..=b'9') => map(|input| small_number(input, false), Node::Parameter).parse(behind)?,
            _ => return fault(Code::BAD_EXPRESSION, input, 1, "a parameter number must follow E"),
        };
        Ok((rest, self.push_between(input, rest, node)))
    }

    /// Productions `call` (fanuc, rs274) and `function` (grundig): `SIN[…]`, `ATAN[…]/[…]`, `POW[…,…]`, `sin(…)`, `pi`.
    fn function<'a>(&mut self, input: Input<'a>) -> Parsed<'a, ExprId> {
        let (rest, word) = letters(input)?;
        let length = word.len();
        if self.language == Language::Grundig {
            if word.eq_ignore_ascii_case(b"PI") {
                let node = Node::Number(std::f64::consts::PI);
                return Ok((rest, self.push_between(input, rest, node)));
            }
            if word.eq_ignore_ascii_case(b"NOT") {
                return self.unary(input, length, UnaryOperator::Not);
            }
        }
        let Some(function) = self.find_function(word) else {
            return fault(Code::BAD_EXPRESSION, input, length, "no function of this language has this name");
        };
        let (open, close) = if self.language == Language::Grundig { (b'(', b')') } else { (b'[', b']') };
        let bracket = blanks(rest);
        let Ok((inside, _)) = byte(open)(bracket) else {
            return fault(Code::BAD_EXPRESSION, input, length, "the argument of a function must be in brackets");
        };
        let (rest, first) = self.expression(inside)?;
        let (rest, second) = match blanks(rest) {
            [byte, rest @ ..] if *byte == close => (rest, None),
            [b',', rest @ ..] if matches!(function, Function::Atan | Function::Pow | Function::Prm) => {
                let closed = terminated(|input| self.expression(input), behind_blanks(byte(close)));
                match map(closed, Some).parse(rest) {
                    Err(nom::Err::Error(_)) => return fault(Code::UNCLOSED, bracket, 1, UNCLOSED),
                    found => found?,
                }
            }
            [] => return fault(Code::UNCLOSED, bracket, 1, UNCLOSED),
            other => {
                return fault(Code::BAD_EXPRESSION, other, 1, "an operator or the closing bracket was expected here");
            }
        };
        let (rest, second) = match (function, second) {
            (Function::Atan, None) => {
                let over = (behind_blanks(byte(b'/')), behind_blanks(peek(byte(b'['))));
                opt(preceded(over, |input| self.bracket(input, b']'))).parse(rest)?
            }
            (_, second) => (rest, second),
        };
        let needs_two = function == Function::Pow || (function == Function::Atan && self.language == Language::Rs274);
        if needs_two && second.is_none() {
            return fault(Code::BAD_EXPRESSION, input, length, "this function needs two values");
        }
        let node = self.program.expr(first).node;
        let is_parameter = matches!(node, Node::Named(_) | Node::Parameter(_) | Node::ParameterAt(_));
        if function == Function::Exists && !is_parameter {
            return fault(Code::BAD_EXPRESSION, bracket, 1, "EXISTS needs a parameter: EXISTS[#<name>]");
        }
        Ok((rest, self.push_between(input, rest, Node::Call(function, first, second))))
    }

    fn find_function(&self, word: &[u8]) -> Option<Function> {
        let (tables, is_short): (&[&[(&str, Function)]], bool) = match self.language {
            Language::Grundig => (&[FUNCTIONS, GRUNDIG_FUNCTIONS], false),
            Language::Rs274 => (&[FUNCTIONS, ISO_FUNCTIONS, RS274_FUNCTIONS], false),
            // Fanuc accepts the first two letters for the whole name.
            _ => (&[FUNCTIONS, ISO_FUNCTIONS, FANUC_FUNCTIONS], true),
        };
        let fits = |name: &str| {
            let is_prefix = name.len() >= word.len() && name.as_bytes()[..word.len()].eq_ignore_ascii_case(word);
            is_prefix && (name.len() == word.len() || (is_short && word.len() >= 2))
        };
        tables.iter().flat_map(|table| table.iter()).find(|(name, _)| fits(name)).map(|&(_, function)| function)
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
}

/// `true` for `exp(`, which begins like a parameter.
fn keyword_exp(input: Input<'_>) -> bool {
    input.get(..3).is_some_and(|word| word.eq_ignore_ascii_case(b"EXP"))
}
