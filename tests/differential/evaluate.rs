//! What a tree does: its moves, by plain arithmetic and the rules of a language that its manual states. Where rounding in the last digits of a
//! control decides – a comparison of sums that nearly agree, a word between two increments – there is no answer, and the program is not used.

use super::tree::{ARGUMENTS, Comparison, Condition, Expression, Function, GLOBALS, Operator, Statement, Tree};

/// Statements after which a program is too long to be of use.
const MOST_STATEMENTS: u32 = 3000;
/// Positions beyond this are outside of every machine, mm.
const FARTHEST_MM: f64 = 1e5;

/// The rules in which the languages differ.
#[derive(Clone, Copy, Debug)]
pub(super) struct Rules {
    /// Numbers count as equal where they differ by less than this part of the larger one, for all six comparisons; 0 where the language says
    /// nothing of it.
    pub(super) relative_equality: f64,
    /// Words are put on multiples of this, mm, halves away from zero.
    pub(super) increment_mm: Option<f64>,
    /// ROUND in the value of an address rounds to its increment, and elsewhere to whole numbers.
    pub(super) rounds_to_increment: bool,
}

/// There is no answer, or the last digits decide it.
#[derive(Debug)]
pub(super) struct Unusable;

type Answer<T> = Result<T, Unusable>;

/// All positions in order.
pub(super) fn positions(tree: &Tree, rules: Rules) -> Answer<Vec<[f64; 3]>> {
    let mut run = Run {
        tree,
        rules,
        globals: [0.0; GLOBALS],
        at: [0.0; 3],
        found: Vec::new(),
        statements: 0,
        round_to: Some(1.0),
    };
    run.body(&tree.main, &mut [0.0; ARGUMENTS])?;
    Ok(run.found)
}

struct Run<'a> {
    tree: &'a Tree,
    rules: Rules,
    globals: [f64; GLOBALS],
    at: [f64; 3],
    found: Vec<[f64; 3]>,
    statements: u32,
    /// What ROUND rounds to at the moment; `None` where the language does not say it.
    round_to: Option<f64>,
}

impl Run<'_> {
    fn body(&mut self, statements: &[Statement], arguments: &mut [f64; ARGUMENTS]) -> Answer<()> {
        statements.iter().try_for_each(|statement| self.statement(statement, arguments))
    }

    fn set(&mut self, variable: usize, value: f64, arguments: &mut [f64; ARGUMENTS]) {
        match variable.checked_sub(GLOBALS) {
            Some(argument) => arguments[argument] = value,
            None => self.globals[variable] = value,
        }
    }

    fn statement(&mut self, statement: &Statement, arguments: &mut [f64; ARGUMENTS]) -> Answer<()> {
        self.statements += 1;
        if self.statements > MOST_STATEMENTS {
            return Err(Unusable);
        }
        match statement {
            Statement::Assign(variable, expression) => {
                let value = self.value(expression, arguments)?;
                self.set(*variable, value, arguments);
            }
            Statement::Move { is_incremental, words } => {
                for (axis, word) in words.iter().enumerate() {
                    let Some(word) = word else { continue };
                    if self.rules.rounds_to_increment {
                        self.round_to = self.rules.increment_mm;
                    }
                    let value = self.value(word, arguments);
                    self.round_to = Some(1.0);
                    let value = self.word(value?)?;
                    self.at[axis] = if *is_incremental { self.at[axis] + value } else { value };
                    if self.at[axis].abs() > FARTHEST_MM {
                        return Err(Unusable);
                    }
                }
                self.found.push(self.at);
            }
            Statement::If(condition, then, other) => {
                let chosen = if self.holds(condition, arguments)? { then } else { other };
                self.body(chosen, arguments)?;
            }
            Statement::While(condition, body) => {
                while self.holds(condition, arguments)? {
                    self.body(body, arguments)?;
                }
            }
            Statement::Until(body, condition) => loop {
                self.body(body, arguments)?;
                if self.holds(condition, arguments)? {
                    break;
                }
            },
            Statement::Count { variable, from, to, body } => {
                for value in *from..=*to {
                    self.set(*variable, f64::from(value), arguments);
                    self.body(body, arguments)?;
                }
                self.set(*variable, f64::from((*to + 1).max(*from)), arguments);
            }
            Statement::Repeat { more, body } => {
                for _ in 0..=*more {
                    self.body(body, arguments)?;
                }
            }
            Statement::Case(variable, cases, other) => {
                let value = self.value(&Expression::Variable(*variable), arguments)?;
                let value = edge(value)?.trunc();
                let chosen = cases.iter().find(|(constant, _)| f64::from(*constant) == value);
                self.body(chosen.map_or(other, |(_, body)| body), arguments)?;
            }
            Statement::Call(routine, expressions) => {
                let mut given = [0.0; ARGUMENTS];
                if self.rules.rounds_to_increment {
                    // An argument is an address, and has no increment.
                    self.round_to = None;
                }
                for (argument, expression) in given.iter_mut().zip(expressions) {
                    *argument = self.value(expression, arguments)?;
                }
                self.round_to = Some(1.0);
                let tree = self.tree;
                self.body(&tree.routines[*routine], &mut given)?;
            }
        }
        Ok(())
    }

    /// A value as the word of an address.
    fn word(&self, value: f64) -> Answer<f64> {
        let Some(increment) = self.rules.increment_mm else { return Ok(value) };
        let count = value / increment;
        if (count.fract().abs() - 0.5).abs() < 1e-5 {
            return Err(Unusable);
        }
        Ok(count.round() * increment)
    }

    fn holds(&self, condition: &Condition, arguments: &[f64; ARGUMENTS]) -> Answer<bool> {
        match condition {
            // Both sides are looked at: a language may do so, and what cannot be decided there is no answer.
            Condition::And(left, right) => Ok(self.holds(left, arguments)? & self.holds(right, arguments)?),
            Condition::Or(left, right) => Ok(self.holds(left, arguments)? | self.holds(right, arguments)?),
            Condition::Compare(comparison, left, right) => {
                let (left, right) = (self.value(left, arguments)?, self.value(right, arguments)?);
                let size = left.abs().max(right.abs());
                let distance = (left - right).abs();
                let limit = self.rules.relative_equality * size;
                let (decided, is_equal) = if self.rules.relative_equality > 0.0 {
                    (distance < 0.1 * limit || distance > 10.0 * limit || size == 0.0, distance <= limit)
                } else {
                    (left == right && left.fract() == 0.0 || distance > 1e-7 * size.max(1e-3), left == right)
                };
                if !decided {
                    return Err(Unusable);
                }
                Ok(match comparison {
                    Comparison::Equal => is_equal,
                    Comparison::NotEqual => !is_equal,
                    Comparison::Less => left < right && !is_equal,
                    Comparison::AtMost => left < right || is_equal,
                    Comparison::Greater => left > right && !is_equal,
                    Comparison::AtLeast => left > right || is_equal,
                })
            }
        }
    }

    fn value(&self, expression: &Expression, arguments: &[f64; ARGUMENTS]) -> Answer<f64> {
        let value = match expression {
            Expression::Number(thousandths) => f64::from(*thousandths) / 1000.0,
            Expression::Variable(variable) => match variable.checked_sub(GLOBALS) {
                Some(argument) => arguments[argument],
                None => self.globals[*variable],
            },
            Expression::Minus(inner) => -self.value(inner, arguments)?,
            Expression::Call(function, inner) => {
                let of = self.value(inner, arguments)?;
                match function {
                    Function::Sin => turned(of.to_radians().sin())?,
                    Function::Cos => turned(of.to_radians().cos())?,
                    Function::Sqrt if of < 0.0 => return Err(Unusable),
                    Function::Sqrt => of.sqrt(),
                    Function::Abs => of.abs(),
                    Function::Round => {
                        let unit = self.round_to.ok_or(Unusable)?;
                        let count = of / unit;
                        // How a half is rounded is a case of its own.
                        if (count.fract().abs() - 0.5).abs() < 1e-5 {
                            return Err(Unusable);
                        }
                        count.round() * unit
                    }
                    Function::Truncate => edge(of)?.trunc(),
                }
            }
            Expression::Binary(operator, left, right) => {
                let (left, right) = (self.value(left, arguments)?, self.value(right, arguments)?);
                match operator {
                    Operator::Add => left + right,
                    Operator::Subtract => left - right,
                    Operator::Multiply => left * right,
                    Operator::Divide | Operator::Modulo if right.abs() < 1e-6 => return Err(Unusable),
                    Operator::Divide => left / right,
                    Operator::Modulo => left % right,
                }
            }
        };
        if value.is_finite() && value.abs() < 1e7 { Ok(value) } else { Err(Unusable) }
    }
}

/// A sine or cosine: of quarters of a turn it depends on how radians are rounded whether it is nothing.
fn turned(value: f64) -> Answer<f64> {
    if value.abs() > 1e-9 { Ok(value) } else { Err(Unusable) }
}

/// A value that is a whole number or clearly none.
fn edge(value: f64) -> Answer<f64> {
    let distance = (value - value.round()).abs();
    if distance == 0.0 || distance > 1e-6 { Ok(value) } else { Err(Unusable) }
}
