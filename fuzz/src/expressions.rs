//! Expressions: a tree made of the bytes, written with as few brackets as the precedence of the language allows and with all of them, has the value
//! that plain arithmetic gives it.
//!
//! Precedence: RS274/NGC `**`, then `* / MOD`, `+ -`, comparisons, `AND OR XOR` (LinuxCNC, G-Code Overview, "Binary Operators"); Fanuc functions,
//! `* /`, `+ -` (B-63944EN, 15.4); Sinumerik `* / DIV MOD`, `+ -` (Programming Manual Job Planning, 1.1.12); Grundig `*  /` before `+ -`. Operators of
//! the same rank go from left to right.

use ncfix_base::geometry::Axis;
use ncfix_language::exec::{Execution, NoLibrary, Options};
use ncfix_language::syntax;
use ncfix_machine::machine::{DecimalPoint, Machine};
use ncfix_machine::snc::Kind;

use super::programs::{dialect_of, machine_of};
use super::source;

#[derive(Clone, Copy, Debug, PartialEq)]
enum Operator {
    Power,
    Multiply,
    Divide,
    Mod,
    Add,
    Subtract,
    Less,
    AtLeast,
    And,
    Or,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Function {
    Sin,
    Cos,
    Abs,
    Sqrt,
    ToNearest,
}

#[derive(Clone, Debug)]
enum Tree {
    /// Thousandths.
    Number(u32),
    Minus(Box<Tree>),
    Call(Function, Box<Tree>),
    Binary(Operator, Box<Tree>, Box<Tree>),
}

/// How a language writes them.
struct Style {
    dialect: &'static str,
    brackets: [char; 2],
    operators: &'static [(Operator, &'static str, u8)],
    functions: &'static [(Function, &'static str)],
}

const STYLES: &[Style] = &[
    Style {
        dialect: "rs274",
        brackets: ['[', ']'],
        operators: &[
            (Operator::Power, "**", 5),
            (Operator::Multiply, "*", 4),
            (Operator::Divide, "/", 4),
            (Operator::Mod, " MOD ", 4),
            (Operator::Add, "+", 3),
            (Operator::Subtract, "-", 3),
            (Operator::Less, " LT ", 2),
            (Operator::AtLeast, " GE ", 2),
            (Operator::And, " AND ", 1),
            (Operator::Or, " OR ", 1),
        ],
        functions: &[
            (Function::Sin, "SIN"),
            (Function::Cos, "COS"),
            (Function::Abs, "ABS"),
            (Function::Sqrt, "SQRT"),
            (Function::ToNearest, "ROUND"),
        ],
    },
    Style {
        dialect: "fanuc",
        brackets: ['[', ']'],
        operators: &[
            (Operator::Multiply, "*", 4),
            (Operator::Divide, "/", 4),
            (Operator::Add, "+", 3),
            (Operator::Subtract, "-", 3),
        ],
        functions: &[
            (Function::Sin, "SIN"),
            (Function::Cos, "COS"),
            (Function::Abs, "ABS"),
            (Function::Sqrt, "SQRT"),
            (Function::ToNearest, "ROUND"),
        ],
    },
    Style {
        dialect: "sinumerik",
        brackets: ['(', ')'],
        operators: &[
            (Operator::Multiply, "*", 4),
            (Operator::Divide, "/", 4),
            (Operator::Add, "+", 3),
            (Operator::Subtract, "-", 3),
        ],
        functions: &[
            (Function::Sin, "SIN"),
            (Function::Cos, "COS"),
            (Function::Abs, "ABS"),
            (Function::Sqrt, "SQRT"),
            (Function::ToNearest, "ROUND"),
        ],
    },
    Style {
        dialect: "grundig",
        brackets: ['(', ')'],
        operators: &[
            (Operator::Multiply, "*", 4),
            (Operator::Divide, ":", 4),
            (Operator::Add, "+", 3),
            (Operator::Subtract, "-", 3),
        ],
        functions: &[(Function::Sin, "sin"), (Function::Cos, "cos"), (Function::Abs, "abs"), (Function::Sqrt, "sqrt")],
    },
];

/// Trees of this depth at most.
const DEEPEST: u32 = 6;
/// Values beyond this are no positions.
const LARGEST: f64 = 1e5;

/// The first byte is the language, the others make the tree.
pub fn agree(bytes: &[u8]) {
    let Some((first, mut rest)) = bytes.split_first() else { return };
    let style = &STYLES[usize::from(*first) % STYLES.len()];
    let tree = style.tree(&mut rest, 0);
    let Some(wanted) = value(&tree) else { return };
    if wanted.abs() > LARGEST {
        return;
    }
    for text in [style.text(&tree, false), style.text(&tree, true)] {
        if text.len() > 200 {
            continue;
        }
        let found = executed(style.dialect, &text);
        let off = (found - wanted).abs();
        assert!(
            off <= half_increment_mm(style.dialect) + 1e-9 * (1.0 + wanted.abs()),
            "{} {text} is {found}, not {wanted}",
            style.dialect
        );
    }
}

/// What putting a word on the grid of the control moves it by at most, mm.
fn half_increment_mm(dialect: &str) -> f64 {
    machine_of(dialect).0.control.word_grid(dialect).map_or(0.0, |[linear_mm, _]| 0.5 * linear_mm)
}

impl Style {
    fn tree(&self, bytes: &mut &[u8], depth: u32) -> Tree {
        let Some((&first, rest)) = bytes.split_first() else { return Tree::Number(1000) };
        *bytes = rest;
        let choice = usize::from(first / 8);
        if depth >= DEEPEST {
            return Tree::Number(u32::from(first) * 125);
        }
        match first % 8 {
            0..=1 => Tree::Number(u32::from(first) * 250),
            2 => Tree::Minus(Box::new(self.tree(bytes, depth + 1))),
            3 => {
                let (function, _) = self.functions[choice % self.functions.len()];
                Tree::Call(function, Box::new(self.tree(bytes, depth + 1)))
            }
            _ => {
                let (operator, ..) = self.operators[choice % self.operators.len()];
                let left = self.tree(bytes, depth + 1);
                Tree::Binary(operator, Box::new(left), Box::new(self.tree(bytes, depth + 1)))
            }
        }
    }

    /// The text, with brackets around everything or where the precedence needs them.
    fn text(&self, tree: &Tree, has_all: bool) -> String {
        let [open, close] = self.brackets;
        match tree {
            Tree::Number(thousandths) => format!("{}.{:03}", thousandths / 1000, thousandths % 1000),
            // A sign between operators is not of every language: it gets brackets.
            Tree::Minus(inner) => format!("{open}0-{}{close}", self.operand(inner, 4, has_all)),
            Tree::Call(function, inner) => {
                let (_, name) = self.functions.iter().find(|(known, _)| known == function).expect("of this language");
                format!("{name}{open}{}{close}", self.text(inner, has_all))
            }
            Tree::Binary(operator, left, right) => {
                let (_, sign, rank) = self.row(*operator);
                format!("{}{sign}{}", self.operand(left, rank, has_all), self.operand(right, rank + 1, has_all))
            }
        }
    }

    /// An operand of an operator that binds like `rank`.
    fn operand(&self, tree: &Tree, rank: u8, has_all: bool) -> String {
        let text = self.text(tree, has_all);
        let [open, close] = self.brackets;
        match tree {
            Tree::Binary(operator, ..) if has_all || self.row(*operator).2 < rank => format!("{open}{text}{close}"),
            _ => text,
        }
    }

    fn row(&self, operator: Operator) -> (Operator, &'static str, u8) {
        *self.operators.iter().find(|(known, ..)| *known == operator).expect("of this language")
    }
}

/// Plain arithmetic; `None` where there is no value, or where a rounding decides what it is.
fn value(tree: &Tree) -> Option<f64> {
    let found = match tree {
        Tree::Number(thousandths) => f64::from(*thousandths) / 1000.0,
        Tree::Minus(inner) => 0.0 - value(inner)?,
        Tree::Call(function, inner) => {
            let of = value(inner)?;
            match function {
                Function::Sin => exact(of, of.to_radians().sin()),
                Function::Cos => exact(of, of.to_radians().cos()),
                Function::Abs => of.abs(),
                Function::Sqrt if of < 0.0 => return None,
                Function::Sqrt => of.sqrt(),
                Function::ToNearest if is_near_edge(of + 0.5) => return None,
                Function::ToNearest => of.round(),
            }
        }
        Tree::Binary(operator, left, right) => {
            let (left, right) = (value(left)?, value(right)?);
            let truth = |holds: bool| f64::from(u8::from(holds));
            match operator {
                Operator::Power if left <= 0.0 => return None,
                Operator::Power => left.powf(right),
                Operator::Multiply => left * right,
                Operator::Divide | Operator::Mod if right.abs() < 1e-9 => return None,
                Operator::Divide => left / right,
                Operator::Mod if is_near_edge(left / right) => return None,
                // LinuxCNC, G-Code Overview: the result is never negative.
                Operator::Mod => left.rem_euclid(right),
                Operator::Add => left + right,
                Operator::Subtract => left - right,
                Operator::Less | Operator::AtLeast if (left - right).abs() < 1e-3 => return None,
                Operator::Less => truth(left < right),
                Operator::AtLeast => truth(left >= right),
                Operator::And | Operator::Or if [left, right].iter().any(|one| one.abs() < 1e-9 && *one != 0.0) => {
                    return None;
                }
                Operator::And => truth(left != 0.0 && right != 0.0),
                Operator::Or => truth(left != 0.0 || right != 0.0),
            }
        }
    };
    // Beyond this the digits that are left say nothing of a small result.
    (found.is_finite() && found.abs() < 1e6).then_some(found)
}

/// A sine or cosine of degrees, which is 0 at quarters of a turn, without what the rounding of radians leaves there.
fn exact(degrees: f64, value: f64) -> f64 {
    if value.abs() < 1e-9 && degrees.abs() > 1.0 { 0.0 } else { value }
}

/// Whether a value is so near a whole number that its last bits decide on which side of it.
fn is_near_edge(value: f64) -> bool {
    (value - value.round()).abs() < 1e-6
}

/// The value as a position of X.
fn executed(dialect: &str, text: &str) -> f64 {
    let text = match dialect {
        "sinumerik" => format!("R1={text}\nG0 G90 X=R1\nM30\n"),
        "grundig" => format!("%PM9001\nN9001\nN1 G17\nN2 E1={text}\nN3 G0 G90 X=E1\nN4 M30\n"),
        _ => {
            format!("#1={}\nG0 G90 X#1\nM30\n", if dialect == "fanuc" { text.to_owned() } else { format!("[{text}]") })
        }
    };
    let (program, findings) = syntax::parse(&source("expression", text.as_bytes()), dialect_of(dialect));
    assert!(findings.is_empty(), "{findings:?}\n{text}");
    let machine = machine(dialect);
    let execution = Execution::new(program, &machine, Box::new(NoLibrary), Options::default());
    let mut x_mm = None;
    for item in execution {
        match item {
            Ok(element) => {
                if let Kind::Move(step) = element.kind {
                    x_mm = Some(step.target[Axis::X]);
                }
            }
            Err(finding) => assert!(!finding.is_error(), "{finding:?}\n{text}"),
        }
    }
    x_mm.unwrap_or_else(|| panic!("no move in\n{text}"))
}

/// The sample machine without travel and offsets, on which a position is the value that is written.
fn machine(dialect: &str) -> Machine {
    let mut machine = machine_of(dialect).0.clone();
    machine.axes.iter_mut().flatten().for_each(|axis| axis.travel = None);
    machine.zero_offsets.values_mut().for_each(|offset| *offset = Default::default());
    machine.control.iso.decimal_point = Some(DecimalPoint::Calculator);
    machine
}
