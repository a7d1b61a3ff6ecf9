//! Random programs as trees: variables, expressions, conditions, jumps, loops, calls and moves, in no language.

use crate::bench_machine::Random;

/// Variables of the whole program; those behind them in a routine are its arguments.
pub(super) const GLOBALS: usize = 5;
/// The variable that routines assign and no loop counts with.
const FREE: usize = GLOBALS - 1;
/// Arguments of a routine.
pub(super) const ARGUMENTS: usize = 2;
/// Routines of a program; one calls only those behind it, so that calls end.
const ROUTINES: usize = 3;
/// Levels of statements in statements.
const DEEPEST: u32 = 3;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Operator {
    Add,
    Subtract,
    Multiply,
    Divide,
    Modulo,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Function {
    Sin,
    Cos,
    Sqrt,
    Abs,
    Round,
    Truncate,
}

#[derive(Clone, Debug)]
pub(super) enum Expression {
    /// Thousandths.
    Number(i32),
    Variable(usize),
    Minus(Box<Expression>),
    Call(Function, Box<Expression>),
    Binary(Operator, Box<Expression>, Box<Expression>),
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Comparison {
    Equal,
    NotEqual,
    Less,
    AtMost,
    Greater,
    AtLeast,
}

#[derive(Clone, Debug)]
pub(super) enum Condition {
    Compare(Comparison, Expression, Expression),
    And(Box<Condition>, Box<Condition>),
    Or(Box<Condition>, Box<Condition>),
}

#[derive(Clone, Debug)]
pub(super) enum Statement {
    Assign(usize, Expression),
    /// X, Y, Z; a word that is `None` is not written.
    Move {
        is_incremental: bool,
        words: [Option<Expression>; 3],
    },
    If(Condition, Vec<Statement>, Vec<Statement>),
    While(Condition, Vec<Statement>),
    Until(Vec<Statement>, Condition),
    /// A variable from a whole number to another one, by one; it is one more behind the loop.
    Count {
        variable: usize,
        from: i32,
        to: i32,
        body: Vec<Statement>,
    },
    /// Once, and so many times more.
    Repeat {
        more: u32,
        body: Vec<Statement>,
    },
    /// The whole part of a variable, constants with their statements, and what is done for all others.
    Case(usize, Vec<(i32, Vec<Statement>)>, Vec<Statement>),
    Call(usize, [Expression; ARGUMENTS]),
}

/// A main program and its routines.
#[derive(Debug)]
pub(super) struct Tree {
    pub(super) main: Vec<Statement>,
    pub(super) routines: Vec<Vec<Statement>>,
}

/// Draws a program.
pub(super) fn draw(random: &mut Random) -> Tree {
    let mut main: Vec<Statement> =
        (0..GLOBALS).map(|variable| Statement::Assign(variable, Expression::Number(number(random)))).collect();
    let all = [Some(Expression::Number(0)), Some(Expression::Number(0)), Some(Expression::Number(0))];
    main.push(Statement::Move { is_incremental: false, words: all });
    main.extend(Draw { variables: GLOBALS, routine: 0, locked: Vec::new() }.body(random, 0, 8));
    let routines = (0..ROUTINES)
        .map(|at| {
            let mut draw = Draw { variables: GLOBALS + ARGUMENTS, routine: at + 1, locked: Vec::new() };
            draw.body(random, 1, 3)
        })
        .collect();
    Tree { main, routines }
}

fn below(random: &mut Random, count: usize) -> usize {
    (random.between(0.0, count as f64) as usize).min(count - 1)
}

/// Thousandths: whole numbers, halves, tenths, and some with all digits.
fn number(random: &mut Random) -> i32 {
    match below(random, 4) {
        0 => 1000 * below(random, 12) as i32,
        1 => 500 * below(random, 40) as i32,
        2 => 100 * below(random, 90) as i32,
        _ => below(random, 20_000) as i32,
    }
}

struct Draw {
    variables: usize,
    /// Routines from this one on may be called.
    routine: usize,
    /// Variables that a loop counts with, which its body leaves alone.
    locked: Vec<usize>,
}

impl Draw {
    fn body(&mut self, random: &mut Random, depth: u32, most: usize) -> Vec<Statement> {
        (0..=below(random, most)).flat_map(|_| self.statement(random, depth)).collect()
    }

    /// A variable that may be assigned, if there is one. Routines leave what a loop of their caller may count with alone.
    fn free(&self, random: &mut Random) -> Option<usize> {
        let first = if self.routine == 0 { 0 } else { FREE };
        let is_free = |variable: &usize| *variable >= first && !self.locked.contains(variable);
        let free: Vec<usize> = (0..self.variables).filter(is_free).collect();
        (!free.is_empty()).then(|| free[below(random, free.len())])
    }

    /// One statement, or a loop with what starts it.
    fn statement(&mut self, random: &mut Random, depth: u32) -> Vec<Statement> {
        let kinds = if depth >= DEEPEST { 5 } else { 12 };
        match below(random, kinds) {
            0 | 1 => match self.free(random) {
                Some(variable) => vec![Statement::Assign(variable, self.expression(random, 0))],
                None => Vec::new(),
            },
            2..=4 => vec![self.motion(random)],
            5 | 6 => {
                let condition = self.condition(random, 0);
                let then = self.body(random, depth + 1, 3);
                let other = if random.chance() { self.body(random, depth + 1, 3) } else { Vec::new() };
                vec![Statement::If(condition, then, other)]
            }
            7 | 8 => self.counted(random, depth),
            9 => {
                let more = 1 + below(random, 3) as u32;
                vec![Statement::Repeat { more, body: self.body(random, depth + 1, 3) }]
            }
            10 => {
                let variable = below(random, self.variables);
                let cases = (0..3).map(|value| (2 * value, self.body(random, depth + 1, 2))).collect();
                vec![Statement::Case(variable, cases, self.body(random, depth + 1, 2))]
            }
            _ if self.routine < ROUTINES => {
                let routine = self.routine + below(random, ROUTINES - self.routine);
                vec![Statement::Call(routine, [self.expression(random, 1), self.expression(random, 1)])]
            }
            _ => vec![self.motion(random)],
        }
    }

    /// A loop that ends: its variable starts at a number, goes by a step and is compared with a bound that a sum of steps may just meet.
    fn counted(&mut self, random: &mut Random, depth: u32) -> Vec<Statement> {
        let Some(variable) = self.free(random).filter(|variable| *variable != FREE) else { return Vec::new() };
        self.locked.push(variable);
        let mut body = self.body(random, depth + 1, 3);
        self.locked.pop();
        if random.chance() {
            let from = below(random, 4) as i32 - 1;
            let to = from + below(random, 5) as i32 - 1;
            return vec![Statement::Count { variable, from, to, body }];
        }
        let step = [100, 250, 300, 1000][below(random, 4)];
        let (start, passes) = (100 * below(random, 10) as i32, 1 + below(random, 6) as i32);
        let is_falling = random.chance();
        let sign = if is_falling { -1 } else { 1 };
        // Half a step off in every second loop: there the rounding of the sums decides nothing.
        let bound = start + sign * passes * step + if random.chance() { step / 2 } else { 0 };
        let operator = if is_falling { Operator::Subtract } else { Operator::Add };
        let next =
            Expression::Binary(operator, Box::new(Expression::Variable(variable)), Box::new(Expression::Number(step)));
        body.push(Statement::Assign(variable, next));
        let compare =
            |comparison| Condition::Compare(comparison, Expression::Variable(variable), Expression::Number(bound));
        let is_strict = random.chance();
        let goes_on = match (is_falling, is_strict) {
            (true, true) => Comparison::Greater,
            (true, false) => Comparison::AtLeast,
            (false, true) => Comparison::Less,
            (false, false) => Comparison::AtMost,
        };
        let ends = match goes_on {
            Comparison::Greater => Comparison::AtMost,
            Comparison::AtLeast => Comparison::Less,
            Comparison::Less => Comparison::AtLeast,
            _ => Comparison::Greater,
        };
        let start = Statement::Assign(variable, Expression::Number(start));
        let turns = if random.chance() {
            Statement::While(compare(goes_on), body)
        } else {
            Statement::Until(body, compare(ends))
        };
        vec![start, turns]
    }

    fn motion(&mut self, random: &mut Random) -> Statement {
        let mut words = [None, None, None];
        let first = below(random, 3);
        for (slot, word) in words.iter_mut().enumerate() {
            if slot == first || random.chance() {
                *word = Some(self.expression(random, 0));
            }
        }
        Statement::Move { is_incremental: random.chance(), words }
    }

    fn condition(&mut self, random: &mut Random, depth: u32) -> Condition {
        if depth == 0 && below(random, 4) == 0 {
            let (left, right) = (Box::new(self.condition(random, 1)), Box::new(self.condition(random, 1)));
            return if random.chance() { Condition::And(left, right) } else { Condition::Or(left, right) };
        }
        let all = [
            Comparison::Equal,
            Comparison::NotEqual,
            Comparison::Less,
            Comparison::AtMost,
            Comparison::Greater,
            Comparison::AtLeast,
        ];
        Condition::Compare(all[below(random, 6)], self.expression(random, 1), self.expression(random, 2))
    }

    fn expression(&mut self, random: &mut Random, depth: u32) -> Expression {
        let kinds = if depth >= 3 { 4 } else { 10 };
        let boxed = |draw: &mut Self, random: &mut Random| Box::new(draw.expression(random, depth + 1));
        match below(random, kinds) {
            0 | 1 => Expression::Number(number(random)),
            2 | 3 => Expression::Variable(below(random, self.variables)),
            4 => Expression::Minus(boxed(self, random)),
            5 => {
                let all =
                    [Function::Sin, Function::Cos, Function::Sqrt, Function::Abs, Function::Round, Function::Truncate];
                Expression::Call(all[below(random, all.len())], boxed(self, random))
            }
            6 => {
                // Whole and not negative: what a remainder is of others is a question of its own.
                let size = Expression::Call(Function::Abs, boxed(self, random));
                let whole = Expression::Call(Function::Truncate, Box::new(size));
                let divisor = Expression::Number(1000 * (1 + below(random, 9) as i32));
                Expression::Binary(Operator::Modulo, Box::new(whole), Box::new(divisor))
            }
            _ => {
                let all = [Operator::Add, Operator::Subtract, Operator::Multiply, Operator::Divide];
                let operator = all[below(random, all.len())];
                Expression::Binary(operator, boxed(self, random), boxed(self, random))
            }
        }
    }
}
