//! A tree as a Fanuc program: custom macro B, subprograms, macro calls.

use super::text::Style;
use super::tree::{Comparison, Condition, Expression, Function, GLOBALS, Operator, Statement, Tree};
use crate::bench_machine::Random;

const STYLE: Style = Style {
    brackets: ["[", "]"],
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
        (Function::Truncate, "FIX"),
    ],
    comparisons: [
        (Comparison::Equal, " EQ "),
        (Comparison::NotEqual, " NE "),
        (Comparison::Less, " LT "),
        (Comparison::AtMost, " LE "),
        (Comparison::Greater, " GT "),
        (Comparison::AtLeast, " GE "),
    ],
    and_or: [" AND ", " OR "],
    variable: |variable| match variable.checked_sub(GLOBALS) {
        // Arguments A and B are #1 and #2.
        Some(argument) => format!("#{}", argument + 1),
        None => format!("#{}", 101 + variable),
    },
};
/// Loops in each other that a program may have.
const MOST_LOOPS: u32 = 3;

/// The whole text: a main program, macros, and subprograms for what is repeated.
pub(super) fn write(tree: &Tree, random: &mut Random) -> String {
    let mut writer = Writer { programs: Vec::new(), lines: Vec::new(), sequence: 0, loops: 0, random };
    writer.lines = vec!["O0001".to_owned(), "G21 G17 G90 G54 G94".to_owned()];
    writer.body(&tree.main);
    writer.line("M30");
    let mut main = std::mem::take(&mut writer.lines);
    for (at, routine) in tree.routines.iter().enumerate() {
        writer.loops = 0;
        writer.lines.push(format!("O{}", 8000 + at));
        writer.body(routine);
        writer.line("M99");
        main.append(&mut writer.lines);
    }
    for program in writer.programs {
        main.extend(program);
    }
    format!("%\n{}\n%\n", main.join("\n"))
}

struct Writer<'a> {
    /// Subprograms that repetitions made.
    programs: Vec<Vec<String>>,
    lines: Vec<String>,
    sequence: u32,
    /// Loops around the place.
    loops: u32,
    random: &'a mut Random,
}

impl Writer<'_> {
    fn line(&mut self, text: &str) {
        self.lines.push(text.to_owned());
    }

    fn sequence(&mut self) -> u32 {
        self.sequence += 1;
        self.sequence
    }

    fn body(&mut self, statements: &[Statement]) {
        for statement in statements {
            self.statement(statement);
        }
    }

    fn value(&mut self, expression: &Expression) -> String {
        STYLE.expression(expression, self.random)
    }

    /// A condition with its brackets.
    fn condition(&mut self, condition: &Condition) -> String {
        format!("[{}]", STYLE.condition(condition, self.random))
    }

    fn word(&mut self, letter: &str, expression: &Expression) -> String {
        match expression {
            Expression::Number(_) | Expression::Variable(_) if self.random.chance() => {
                format!("{letter}{}", self.value(expression))
            }
            Expression::Minus(inner) if matches!(**inner, Expression::Variable(_)) && self.random.chance() => {
                format!("{letter}-{}", self.value(inner))
            }
            _ => format!("{letter}[{}]", self.value(expression)),
        }
    }

    fn statement(&mut self, statement: &Statement) {
        match statement {
            Statement::Assign(variable, expression) => {
                let text = format!("{}={}", (STYLE.variable)(*variable), self.value(expression));
                self.line(&text);
            }
            Statement::Move { is_incremental, words } => {
                let mut text = format!("{} G1 F500.", if *is_incremental { "G91" } else { "G90" });
                for (letter, word) in ["X", "Y", "Z"].iter().zip(words) {
                    if let Some(word) = word {
                        text += &format!(" {}", self.word(letter, word));
                    }
                }
                self.line(&text);
            }
            Statement::If(condition, then, other) => {
                let text = self.condition(condition);
                let (yes, end) = (self.sequence(), self.sequence());
                match then.as_slice() {
                    [Statement::Assign(variable, expression)] if other.is_empty() && self.random.chance() => {
                        let value = self.value(expression);
                        self.line(&format!("IF {text} THEN {}={value}", (STYLE.variable)(*variable)));
                    }
                    _ => {
                        self.line(&format!("IF {text} GOTO {yes}"));
                        self.body(other);
                        self.line(&format!("GOTO {end}"));
                        self.line(&format!("N{yes}"));
                        self.body(then);
                        self.line(&format!("N{end}"));
                    }
                }
            }
            Statement::While(condition, body) => {
                let text = self.condition(condition);
                self.around(&text, body);
            }
            Statement::Until(body, condition) => {
                let (start, text) = (self.sequence(), self.condition(condition));
                let end = self.sequence();
                self.line(&format!("N{start}"));
                self.body(body);
                self.line(&format!("IF {text} GOTO {end}"));
                self.line(&format!("GOTO {start}"));
                self.line(&format!("N{end}"));
            }
            Statement::Count { variable, from, to, body } => {
                let name = (STYLE.variable)(*variable);
                self.line(&format!("{name}={from}"));
                let next = Expression::Binary(
                    Operator::Add,
                    Box::new(Expression::Variable(*variable)),
                    Box::new(Expression::Number(1000)),
                );
                let mut body = body.clone();
                body.push(Statement::Assign(*variable, next));
                self.around(&format!("[{name} LE {to}]"), &body);
            }
            Statement::Repeat { more, body } => {
                // Variables are those of the caller in a subprogram, so that its statements may stand there.
                let number = 7000 + self.sequence();
                let caller = std::mem::replace(&mut self.lines, vec![format!("O{number}")]);
                let loops = std::mem::replace(&mut self.loops, 0);
                self.body(body);
                self.line("M99");
                let program = std::mem::replace(&mut self.lines, caller);
                self.programs.push(program);
                self.loops = loops;
                let times = more + 1;
                let text = if self.random.chance() {
                    format!("M98 P{number} L{times}")
                } else {
                    format!("M98 P{times:04}{number:04}")
                };
                self.line(&text);
            }
            Statement::Case(variable, cases, other) => {
                let name = (STYLE.variable)(*variable);
                let labels: Vec<u32> = cases.iter().map(|_| self.sequence()).collect();
                let end = self.sequence();
                for ((constant, _), label) in cases.iter().zip(&labels) {
                    self.line(&format!("IF [FIX[{name}] EQ {constant}] GOTO {label}"));
                }
                self.body(other);
                self.line(&format!("GOTO {end}"));
                for ((_, body), label) in cases.iter().zip(&labels) {
                    self.line(&format!("N{label}"));
                    self.body(body);
                    self.line(&format!("GOTO {end}"));
                }
                self.line(&format!("N{end}"));
            }
            Statement::Call(routine, arguments) => {
                let [first, second] = arguments;
                let words = format!("{} {}", self.word("A", first), self.word("B", second));
                self.line(&format!("G65 P{} {words}", 8000 + routine));
            }
        }
    }

    /// A loop with its condition in front: `WHILE … DO`, or jumps.
    fn around(&mut self, condition: &str, body: &[Statement]) {
        if self.loops < MOST_LOOPS && self.random.chance() {
            self.loops += 1;
            let number = self.loops;
            self.line(&format!("WHILE {condition} DO{number}"));
            self.body(body);
            self.line(&format!("END{number}"));
            self.loops -= 1;
            return;
        }
        let (start, inside, end) = (self.sequence(), self.sequence(), self.sequence());
        self.line(&format!("N{start} IF {condition} GOTO {inside}"));
        self.line(&format!("GOTO {end}"));
        self.line(&format!("N{inside}"));
        self.body(body);
        self.line(&format!("GOTO {start}"));
        self.line(&format!("N{end}"));
    }
}
