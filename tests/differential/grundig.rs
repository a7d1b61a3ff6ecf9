//! A tree as a program of the Grundig family: E parameters, jumps, repetitions, macros.

use super::text::Style;
use super::tree::{Comparison, Condition, Expression, Function, GLOBALS, Operator, Statement, Tree};
use crate::bench_machine::Random;

const STYLE: Style = Style {
    brackets: ["(", ")"],
    operators: [
        (Operator::Add, "+"),
        (Operator::Subtract, "-"),
        (Operator::Multiply, "*"),
        (Operator::Divide, ":"),
        // There is none: see `without_remainders`.
        (Operator::Modulo, "?"),
    ],
    functions: [
        (Function::Sin, "sin"),
        (Function::Cos, "cos"),
        (Function::Sqrt, "sqrt"),
        (Function::Abs, "abs"),
        (Function::Round, "rnd"),
        (Function::Truncate, "int"),
    ],
    comparisons: [
        (Comparison::Equal, "="),
        (Comparison::NotEqual, "<>"),
        (Comparison::Less, "<"),
        (Comparison::AtMost, "<="),
        (Comparison::Greater, ">"),
        (Comparison::AtLeast, ">="),
    ],
    and_or: [" and ", " or "],
    variable: |variable| format!("E{}", variable + 1),
};
/// The parameter that holds what a condition gives.
const CONDITION: &str = "E40";

/// The parameters of a routine: parameters are those of all programs, so that each routine has its own.
fn argument(routine: usize, argument: usize) -> usize {
    GLOBALS + 10 + 10 * routine + argument
}

/// The whole text: a main program and its macros.
pub(super) fn write(tree: &Tree, random: &mut Random) -> String {
    let lines = vec!["%PM9001".to_owned(), "N9001".to_owned()];
    let mut writer = Writer { lines, number: 0, routine: None, random };
    writer.line("G17 G90 G71 G54 I1");
    writer.body(&tree.main);
    writer.line("M30");
    for (at, routine) in tree.routines.iter().enumerate() {
        writer.lines.extend([format!("%MM{}", 9100 + at), format!("N{}", 9100 + at)]);
        writer.routine = Some(at);
        writer.body(routine);
        // A macro has a block.
        writer.line("");
    }
    writer.lines.join("\n") + "\n"
}

struct Writer<'a> {
    lines: Vec<String>,
    number: u32,
    routine: Option<usize>,
    random: &'a mut Random,
}

impl Writer<'_> {
    /// Adds a block and gives its number.
    fn line(&mut self, text: &str) -> u32 {
        self.number += 1;
        self.lines.push(format!("N{} {text}", self.number).trim_end().to_owned());
        self.number
    }

    /// A place in the lines where a block is written later, when the number of its target is known.
    fn later(&mut self) -> usize {
        self.line("");
        self.lines.len() - 1
    }

    fn put(&mut self, place: usize, text: &str) {
        self.lines[place] += &format!(" {text}");
    }

    /// The number of the block that comes next.
    fn next(&self) -> u32 {
        self.number + 1
    }

    fn body(&mut self, statements: &[Statement]) {
        for statement in statements {
            self.statement(statement);
        }
    }

    /// Arguments get the parameters of their routine.
    fn own(&self, variable: usize) -> usize {
        match (variable.checked_sub(GLOBALS), self.routine) {
            (Some(at), Some(routine)) => argument(routine, at),
            _ => variable,
        }
    }

    fn renamed(&self, expression: &Expression) -> Expression {
        match expression {
            Expression::Number(_) => expression.clone(),
            Expression::Variable(variable) => Expression::Variable(self.own(*variable)),
            Expression::Minus(inner) => Expression::Minus(Box::new(self.renamed(inner))),
            Expression::Call(function, inner) => Expression::Call(*function, Box::new(self.renamed(inner))),
            Expression::Binary(operator, left, right) => {
                Expression::Binary(*operator, Box::new(self.renamed(left)), Box::new(self.renamed(right)))
            }
        }
    }

    fn value(&mut self, expression: &Expression) -> String {
        STYLE.expression(&without_remainders(&self.renamed(expression)), self.random)
    }

    fn condition(&mut self, condition: &Condition) -> String {
        let condition = self.renamed_condition(condition);
        STYLE.condition(&condition, self.random)
    }

    fn renamed_condition(&self, condition: &Condition) -> Condition {
        let inner = |inner: &Condition| Box::new(self.renamed_condition(inner));
        match condition {
            Condition::Compare(comparison, left, right) => {
                let side = |side: &Expression| without_remainders(&self.renamed(side));
                Condition::Compare(*comparison, side(left), side(right))
            }
            Condition::And(left, right) => Condition::And(inner(left), inner(right)),
            Condition::Or(left, right) => Condition::Or(inner(left), inner(right)),
        }
    }

    fn statement(&mut self, statement: &Statement) {
        match statement {
            Statement::Assign(variable, expression) => {
                let text = format!("{}={}", (STYLE.variable)(self.own(*variable)), self.value(expression));
                self.line(&text);
            }
            Statement::Move { is_incremental, words } => {
                let mut text = format!("{} G1", if *is_incremental { "G91" } else { "G90" });
                for (letter, word) in ["X", "Y", "Z"].iter().zip(words) {
                    let Some(word) = word else { continue };
                    let value = self.value(word);
                    let is_plain = matches!(word, Expression::Number(_)) && self.random.chance();
                    text += &if is_plain { format!(" {letter}{value}") } else { format!(" {letter}={value}") };
                }
                self.line(&format!("{text} F500"));
            }
            Statement::If(condition, then, other) => {
                let jump = self.jump_if(condition);
                self.body(other);
                let over = self.later();
                self.aim(jump);
                self.line("");
                self.body(then);
                let end = self.line("");
                self.put(over, &format!("G29 N={end}"));
            }
            Statement::While(condition, body) => {
                let start = self.next();
                let inside = self.jump_if(condition);
                let out = self.later();
                self.aim(inside);
                self.line("");
                self.body(body);
                self.line(&format!("G29 N={start}"));
                let end = self.line("");
                self.put(out, &format!("G29 N={end}"));
            }
            Statement::Until(body, condition) => {
                let start = self.line("");
                self.body(body);
                let out = self.jump_if(condition);
                self.line(&format!("G29 N={start}"));
                self.aim(out);
                self.line("");
            }
            Statement::Count { variable, from, to, body } => {
                let name = (STYLE.variable)(self.own(*variable));
                self.line(&format!("{name}={from}"));
                let start = self.line(&format!("{CONDITION}={name}>{to}"));
                let out = self.later();
                self.body(body);
                self.line(&format!("{name}={name}+1"));
                self.line(&format!("G29 N={start}"));
                let end = self.line("");
                self.put(out, &format!("G29 {CONDITION} N={end}"));
            }
            Statement::Repeat { more, body } => {
                let start = self.line("");
                self.body(body);
                let end = self.line("");
                self.line(&format!("G14 N1={start} N2={end} J{more}"));
            }
            Statement::Case(variable, cases, other) => {
                let name = (STYLE.variable)(self.own(*variable));
                let mut jumps = Vec::new();
                for (constant, _) in cases {
                    self.line(&format!("{CONDITION}=int({name})={constant}"));
                    jumps.push(Jump { place: self.later(), condition: CONDITION.to_owned() });
                }
                self.body(other);
                let mut ends = vec![self.later()];
                for ((_, body), jump) in cases.iter().zip(jumps) {
                    self.aim(jump);
                    self.line("");
                    self.body(body);
                    ends.push(self.later());
                }
                let end = self.line("");
                for place in ends {
                    self.put(place, &format!("G29 N={end}"));
                }
            }
            Statement::Call(routine, arguments) => {
                for (at, expression) in arguments.iter().enumerate() {
                    // Through a parameter of its own: a routine may call with its own arguments.
                    let value = self.value(expression);
                    self.line(&format!("{}={value}", (STYLE.variable)(argument(*routine, at))));
                }
                self.line(&format!("G22 N={}", 9100 + routine));
            }
        }
    }

    /// A jump that is taken where a condition holds.
    fn jump_if(&mut self, condition: &Condition) -> Jump {
        let text = self.condition(condition);
        if self.random.chance() {
            self.line(&format!("{CONDITION}={text}"));
            return Jump { place: self.later(), condition: CONDITION.to_owned() };
        }
        Jump { place: self.later(), condition: format!("{CONDITION}={text} {CONDITION}") }
    }

    /// A jump goes to the block that comes next.
    fn aim(&mut self, jump: Jump) {
        let text = format!("G29 {} N={}", jump.condition, self.next());
        self.put(jump.place, &text);
    }
}

struct Jump {
    place: usize,
    condition: String,
}

/// `a mod b` of a whole number that is not negative is `a − b·int(a : b)`.
fn without_remainders(expression: &Expression) -> Expression {
    let inner = |inner: &Expression| Box::new(without_remainders(inner));
    match expression {
        Expression::Number(_) | Expression::Variable(_) => expression.clone(),
        Expression::Minus(of) => Expression::Minus(inner(of)),
        Expression::Call(function, of) => Expression::Call(*function, inner(of)),
        Expression::Binary(Operator::Modulo, left, right) => {
            let quotient = Expression::Binary(Operator::Divide, inner(left), inner(right));
            let whole = Expression::Call(Function::Truncate, Box::new(quotient));
            let back = Expression::Binary(Operator::Multiply, inner(right), Box::new(whole));
            Expression::Binary(Operator::Subtract, inner(left), Box::new(back))
        }
        Expression::Binary(operator, left, right) => Expression::Binary(*operator, inner(left), inner(right)),
    }
}
