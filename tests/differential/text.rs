//! Expressions and conditions of a tree as text, with brackets only where the precedence of the language asks for them, and sometimes everywhere.

use super::tree::{Comparison, Condition, Expression, Function, Operator};
use crate::bench_machine::Random;

/// How a language writes values.
pub(super) struct Style {
    pub(super) brackets: [&'static str; 2],
    pub(super) operators: [(Operator, &'static str); 5],
    pub(super) functions: [(Function, &'static str); 6],
    pub(super) comparisons: [(Comparison, &'static str); 6],
    pub(super) and_or: [&'static str; 2],
    pub(super) variable: fn(usize) -> String,
}

impl Style {
    /// A number of thousandths: with and without point, zeros in front and behind.
    pub(super) fn number(thousandths: i32, random: &mut Random) -> String {
        let (whole, rest) = (thousandths.abs() / 1000, thousandths.abs() % 1000);
        let sign = if thousandths < 0 { "-" } else { "" };
        let digits = format!("{rest:03}");
        let short = digits.trim_end_matches('0');
        let text = match (rest, whole) {
            (0, _) if random.chance() => whole.to_string(),
            (0, _) => format!("{whole}."),
            (_, 0) if random.chance() => format!(".{short}"),
            _ if random.chance() => format!("{whole}.{digits}"),
            _ => format!("{whole}.{short}"),
        };
        format!("{sign}{text}")
    }

    pub(super) fn expression(&self, expression: &Expression, random: &mut Random) -> String {
        self.ranked(expression, 0, random)
    }

    /// Text that may stand where operators of `rank` and above need no brackets.
    fn ranked(&self, expression: &Expression, rank: u8, random: &mut Random) -> String {
        let [open, close] = self.brackets;
        match expression {
            Expression::Number(thousandths) => Style::number(*thousandths, random),
            Expression::Variable(variable) => (self.variable)(*variable),
            Expression::Minus(inner) => {
                // A sign binds an operand; behind an operator it gets brackets, which all languages read.
                let operand = match &**inner {
                    Expression::Variable(_) | Expression::Call(..) => self.ranked(inner, 3, random),
                    _ => format!("{open}{}{close}", self.ranked(inner, 0, random)),
                };
                if rank == 0 { format!("-{operand}") } else { format!("{open}-{operand}{close}") }
            }
            Expression::Call(function, inner) => {
                let (_, name) = self.functions.iter().find(|(known, _)| known == function).unwrap();
                format!("{name}{open}{}{close}", self.ranked(inner, 0, random))
            }
            Expression::Binary(operator, left, right) => {
                let own = match operator {
                    Operator::Add | Operator::Subtract => 1,
                    _ => 2,
                };
                let (_, sign) = self.operators.iter().find(|(known, _)| known == operator).unwrap();
                // From left to right among equals.
                let text = format!("{}{sign}{}", self.ranked(left, own, random), self.ranked(right, own + 1, random));
                let is_bracketed = own < rank || rank > 0 && random.between(0.0, 1.0) < 0.1;
                if is_bracketed { format!("{open}{text}{close}") } else { text }
            }
        }
    }

    /// A condition without its outer brackets.
    pub(super) fn condition(&self, condition: &Condition, random: &mut Random) -> String {
        let [open, close] = self.brackets;
        match condition {
            Condition::Compare(comparison, left, right) => {
                let (_, sign) = self.comparisons.iter().find(|(known, _)| known == comparison).unwrap();
                // A sign behind a comparison stands in brackets, too.
                format!("{}{sign}{}", self.ranked(left, 1, random), self.ranked(right, 1, random))
            }
            Condition::And(left, right) | Condition::Or(left, right) => {
                let [and, or] = self.and_or;
                let word = if matches!(condition, Condition::And(..)) { and } else { or };
                let (left, right) = (self.condition(left, random), self.condition(right, random));
                format!("{open}{left}{close}{word}{open}{right}{close}")
            }
        }
    }
}
