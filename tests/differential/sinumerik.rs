//! A tree as a Sinumerik program with its own words, or with labels and jumps.

use super::text::Style;
use super::tree::{ARGUMENTS, Comparison, Condition, Expression, Function, GLOBALS, Operator, Statement, Tree};
use crate::bench_machine::Random;

const STYLE: Style = Style {
    brackets: ["(", ")"],
    operators: [
        (Operator::Add, "+"),
        (Operator::Subtract, "-"),
        (Operator::Multiply, "*"),
        (Operator::Divide, "/"),
        (Operator::Modulo, " MOD "),
    ],
    functions: [
        (Function::Sin, "SIN"),
        (Function::Cos, "COS"),
        (Function::Sqrt, "SQRT"),
        (Function::Abs, "ABS"),
        (Function::Round, "ROUND"),
        (Function::Truncate, "TRUNC"),
    ],
    comparisons: [
        (Comparison::Equal, "=="),
        (Comparison::NotEqual, "<>"),
        (Comparison::Less, "<"),
        (Comparison::AtMost, "<="),
        (Comparison::Greater, ">"),
        (Comparison::AtLeast, ">="),
    ],
    and_or: [" AND ", " OR "],
    variable: |variable| match variable.checked_sub(GLOBALS) {
        Some(argument) => format!("ARG_{argument}"),
        None => format!("R{}", variable + 1),
    },
};

/// The whole text: a main program and its subprograms in one file.
pub(super) fn write(tree: &Tree, random: &mut Random) -> String {
    let mut writer =
        Writer { lines: vec!["%_N_TREE_MPF".to_owned(), "G17 G90 G710 G500".to_owned()], label: 0, random };
    writer.body(&tree.main);
    writer.line("M30");
    for (at, routine) in tree.routines.iter().enumerate() {
        writer.line(&format!("%_N_PART{at}_SPF"));
        let arguments: Vec<String> = (0..ARGUMENTS).map(|argument| format!("REAL ARG_{argument}")).collect();
        writer.line(&format!("PROC PART{at}({})", arguments.join(",")));
        writer.body(routine);
        writer.line("M17");
    }
    writer.lines.join("\n") + "\n"
}

struct Writer<'a> {
    lines: Vec<String>,
    label: u32,
    random: &'a mut Random,
}

impl Writer<'_> {
    fn line(&mut self, text: &str) {
        self.lines.push(text.to_owned());
    }

    fn label(&mut self) -> String {
        self.label += 1;
        format!("LB_{}", self.label)
    }

    fn body(&mut self, statements: &[Statement]) {
        for statement in statements {
            self.statement(statement);
        }
    }

    fn value(&mut self, expression: &Expression) -> String {
        STYLE.expression(expression, self.random)
    }

    fn condition(&mut self, condition: &Condition) -> String {
        STYLE.condition(condition, self.random)
    }

    fn motion(&mut self, is_incremental: bool, words: &[Option<Expression>; 3]) {
        // What holds for the block, and words that say otherwise for themselves.
        let holds_incremental = if self.random.chance() { is_incremental } else { !is_incremental };
        let mut text = format!("{} G1 F500", if holds_incremental { "G91" } else { "G90" });
        for (letter, word) in ["X", "Y", "Z"].iter().zip(words) {
            let Some(word) = word else { continue };
            let value = self.value(word);
            let is_own = holds_incremental != is_incremental || self.random.between(0.0, 1.0) < 0.1;
            text += &match word {
                _ if is_own && is_incremental => format!(" {letter}=IC({value})"),
                _ if is_own => format!(" {letter}=AC({value})"),
                Expression::Number(_) if self.random.chance() => format!(" {letter}{value}"),
                _ => format!(" {letter}={value}"),
            };
        }
        self.line(&text);
    }

    fn statement(&mut self, statement: &Statement) {
        match statement {
            Statement::Assign(variable, expression) => {
                let text = format!("{}={}", (STYLE.variable)(*variable), self.value(expression));
                self.line(&text);
            }
            Statement::Move { is_incremental, words } => self.motion(*is_incremental, words),
            Statement::If(condition, then, other) => self.branch(condition, then, other),
            Statement::While(condition, body) => {
                let condition = self.condition(condition);
                if self.random.chance() {
                    self.line(&format!("WHILE {condition}"));
                    self.body(body);
                    self.line("ENDWHILE");
                } else {
                    let (start, check) = (self.label(), self.label());
                    self.line(&format!("GOTOF {check}"));
                    self.line(&format!("{start}:"));
                    self.body(body);
                    self.line(&format!("{check}: IF {condition} GOTOB {start}"));
                }
            }
            Statement::Until(body, condition) => {
                let condition = self.condition(condition);
                match self.random.chance() {
                    true => {
                        self.line("REPEAT");
                        self.body(body);
                        self.line(&format!("UNTIL {condition}"));
                    }
                    false => {
                        let end = self.label();
                        self.line("LOOP");
                        self.body(body);
                        self.line(&format!("IF {condition} GOTOF {end}"));
                        self.line("ENDLOOP");
                        self.line(&format!("{end}:"));
                    }
                }
            }
            Statement::Count { variable, from, to, body } => {
                self.line(&format!("FOR {}={from} TO {to}", (STYLE.variable)(*variable)));
                self.body(body);
                self.line("ENDFOR");
                // What the variable is behind the loop is nothing to build on.
                self.line(&format!("{}={}", (STYLE.variable)(*variable), (to + 1).max(*from)));
            }
            Statement::Repeat { more, body } => {
                let (start, end) = (self.label(), self.label());
                self.line(&format!("{start}:"));
                self.body(body);
                self.line(&format!("{end}:"));
                self.line(&format!("REPEAT {start} {end} P={more}"));
            }
            Statement::Case(variable, cases, other) => {
                let labels: Vec<String> = cases.iter().map(|_| self.label()).collect();
                let (default, end) = (self.label(), self.label());
                let rows: Vec<String> = cases
                    .iter()
                    .zip(&labels)
                    .map(|((constant, _), label)| format!("{constant} GOTOF {label}"))
                    .collect();
                let name = (STYLE.variable)(*variable);
                self.line(&format!("CASE(TRUNC({name})) OF {} DEFAULT GOTOF {default}", rows.join(" ")));
                for ((_, body), label) in cases.iter().zip(&labels) {
                    self.line(&format!("{label}:"));
                    self.body(body);
                    self.line(&format!("GOTOF {end}"));
                }
                self.line(&format!("{default}:"));
                self.body(other);
                self.line(&format!("{end}:"));
            }
            Statement::Call(routine, arguments) => {
                let values: Vec<String> = arguments.iter().map(|argument| self.value(argument)).collect();
                self.line(&format!("PART{routine}({})", values.join(",")));
            }
        }
    }

    fn branch(&mut self, condition: &Condition, then: &[Statement], other: &[Statement]) {
        let text = self.condition(condition);
        if self.random.chance() {
            self.line(&format!("IF {text}"));
            self.body(then);
            if !other.is_empty() {
                self.line("ELSE");
                self.body(other);
            }
            self.line("ENDIF");
            return;
        }
        let (yes, end) = (self.label(), self.label());
        self.line(&format!("IF {text} GOTOF {yes}"));
        self.body(other);
        self.line(&format!("GOTOF {end}"));
        self.line(&format!("{yes}:"));
        self.body(then);
        self.line(&format!("{end}:"));
    }
}
