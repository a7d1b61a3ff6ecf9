//! All functions of one axis on a grid of equal intervals, linear in between, for look-up in the cycle of a control (Spaan, ch. 6: 200 intervals between the
//! end switches).
//!
//! The six components of a grid point are adjacent in memory, so an evaluation reads two neighboring rows, whatever the number of functions. Values that
//! depend on the direction of the last motion are stored as mean and half difference, e = m(q) + s h(q) with s = −1, 0 or 1.

use super::{EntryFunction, Functions};
use ncfix_base::geometry::{Axis, AxisVector};
use ncfix_machine::machine::State;

/// Maximum deviation of the table from a function between its points, mm and rad: 0.02 µm, and the equivalent angle at an arm of 0.4 m. A function with a
/// larger deviation is not tabulated.
const LIMIT_MM: f64 = 2e-5;
const LIMIT_RAD: f64 = 5e-8;
/// Points within each interval at which the table is compared with the function. Seven of them detect a wave down to a quarter of an interval.
const PROBES: usize = 7;

/// Table of equal intervals.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Intervals {
    low: f64,
    per_unit: f64,
    /// EX EY EZ EA EB EC at each end of an interval, mm and rad: mean of both directions of motion.
    mean: Vec<[f64; 6]>,
    /// Addition after a positive motion; empty if nothing depends on the direction.
    half: Vec<[f64; 6]>,
}

impl Intervals {
    fn new([low, high]: [f64; 2], count: usize) -> Intervals {
        Intervals { low, per_unit: count as f64 / (high - low), mean: vec![[0.0; 6]; count + 1], half: Vec::new() }
    }

    /// Returns the components at a command and a direction of the last motion, mm and rad. Beyond its ends the table is extrapolated from its last interval:
    /// a correction leads slightly beyond the end of the travel.
    #[inline]
    pub(super) fn value(&self, command: f64, sense: i8) -> [f64; 6] {
        let place = (command - self.low) * self.per_unit;
        // The cast maps values below zero and NaN to the first row.
        let row = (place as usize).min(self.mean.len().saturating_sub(2));
        let share = place - row as f64;
        let mut components = between(&self.mean, row, share);
        if sense != 0 && !self.half.is_empty() {
            let half = between(&self.half, row, share);
            components.iter_mut().zip(half).for_each(|(sum, half)| *sum += f64::from(sense) * half);
        }
        components
    }

    /// Adds a function if the table represents it well enough. Returns false if not; nothing is added then.
    fn take(&mut self, axis: Axis, row: usize, function: &EntryFunction) -> bool {
        let at = |command: f64, sense: i8| {
            let mut commands = AxisVector::ZERO;
            commands[axis] = command;
            let mut state = State::default();
            state.direction[axis.slot()] = sense;
            function.value(axis, &commands, &state)
        };
        let parts = |command: f64| {
            let (positive, negative) = (at(command, 1), at(command, -1));
            [f64::midpoint(positive, negative), 0.5 * (positive - negative)]
        };
        let place = |place: f64| self.low + place / self.per_unit;
        let points: Vec<[f64; 2]> = (0..self.mean.len()).map(|index| parts(place(index as f64))).collect();
        let limit = if row < 3 { LIMIT_MM } else { LIMIT_RAD };
        let is_kept = points.windows(2).enumerate().all(|(index, ends)| {
            (1..=PROBES).all(|probe| {
                let share = probe as f64 / (PROBES + 1) as f64;
                let exact = parts(place(index as f64 + share));
                (0..2).all(|k| (ends[0][k] + share * (ends[1][k] - ends[0][k]) - exact[k]).abs() <= limit)
            })
        });
        if !is_kept {
            return false;
        }
        if self.half.is_empty() && points.iter().any(|point| point[1] != 0.0) {
            self.half = vec![[0.0; 6]; self.mean.len()];
        }
        self.mean.iter_mut().zip(&points).for_each(|(sum, point)| sum[row] += point[0]);
        self.half.iter_mut().zip(&points).for_each(|(sum, point)| sum[row] += point[1]);
        true
    }
}

/// Interpolates between two neighboring rows.
#[inline]
fn between(rows: &[[f64; 6]], row: usize, share: f64) -> [f64; 6] {
    let [low, high] =
        rows.get(row..row + 2).and_then(|rows| <&[[f64; 6]; 2]>::try_from(rows).ok()).unwrap_or(&[[0.0; 6]; 2]);
    let mut components = *low;
    components.iter_mut().zip(high).for_each(|(low, high)| *low += share * (high - *low));
    components
}

impl Functions {
    /// Returns the functions on `count` equal intervals over a range of commands, mm or rad. Functions of two axes, and those for which the grid is too
    /// coarse, stay unchanged.
    pub(crate) fn on_intervals(&self, axis: Axis, range: [f64; 2], count: usize) -> Functions {
        let mut table = Intervals::new(range, count);
        let mut rest = Functions::default();
        let mut functions = self.others.clone();
        let degrees = self.polynomial.len();
        for row in (0..6).filter(|&row| self.polynomial.iter().any(|powers| powers[row] != 0.0)) {
            let coefficients = (0..degrees).map(|power| self.polynomial[degrees - 1 - power][row]).collect();
            functions.push((row, EntryFunction::Polynomial(super::polynomial::Polynomial { coefficients })));
        }
        for (row, function) in functions {
            let is_own = function.with().is_none();
            if is_own && table.take(axis, row, &function) {
                rest.intervals.get_or_insert_with(|| Intervals::new(range, count));
                continue;
            }
            match &function {
                EntryFunction::Polynomial(polynomial) => rest.add_polynomial(row, &polynomial.coefficients),
                _ => rest.others.push((row, function)),
            }
        }
        if rest.intervals.is_some() {
            rest.intervals = Some(table);
        }
        rest
    }

    /// Returns the number of functions that are evaluated one by one.
    pub(crate) fn direct(&self) -> usize {
        let polynomials = (0..6).filter(|&row| self.polynomial.iter().any(|powers| powers[row] != 0.0)).count();
        polynomials + self.others.len()
    }
}

#[cfg(test)]
mod tests {
    use super::super::{MotionError, backlash, periodic, table};
    use super::*;
    use crate::name::{Direction, ErrorName};

    fn functions(own: Vec<(Direction, EntryFunction)>) -> Functions {
        let errors: Vec<MotionError> = own
            .into_iter()
            .map(|(direction, function)| MotionError { name: ErrorName::motion(direction, Axis::X), function })
            .collect();
        Functions::of(Axis::X, &errors).on_intervals(Axis::X, [-100.0, 300.0], 200)
    }

    fn at(functions: &Functions, command: f64, sense: i8) -> [f64; 6] {
        let (mut commands, mut state) = (AxisVector::ZERO, State::default());
        commands[Axis::X] = command;
        state.direction[0] = sense;
        functions.evaluate(Axis::X, &commands, &state)
    }

    #[test]
    fn linear_between_points_and_on_beyond_the_ends() {
        let points = table::ErrorTable { positions: vec![-100.0, 100.0, 300.0], values: vec![0.0, 4e-3, 0.0] };
        let reversal = EntryFunction::Backlash(backlash::Backlash::constant(6e-3));
        let on_grid = functions(vec![(Direction::X, EntryFunction::Table(points)), (Direction::X, reversal)]);
        assert_eq!(on_grid.direct(), 0);
        for (command, sense, value) in
            [(-100.0, 0, 0.0), (1.0, 1, 2.02e-3 + 3e-3), (100.0, -1, 1e-3), (299.0, 0, 2e-5), (301.0, 0, -2e-5)]
        {
            assert!((at(&on_grid, command, sense)[0] - value).abs() < 1e-15, "{command} {sense}");
        }
        assert!(at(&on_grid, f64::NAN, 0)[0].is_nan());
    }

    #[test]
    fn what_the_grid_is_too_coarse_for_stays() {
        // Intervals of 2 mm: the chord deviation of a wave of 10 µm is 10 (2π/20)² 2²/8 = 0.49 µm for a period of 20 mm, and 0.0012 µm for 400 mm.
        let wave = |period| EntryFunction::Periodic(periodic::Periodic { amplitude: 0.01, period, phase_rad: 0.3 });
        let on_grid = functions(vec![(Direction::Y, wave(20.0)), (Direction::Z, wave(400.0))]);
        assert_eq!(on_grid.direct(), 1);
        let direct = functions(Vec::new());
        assert!(direct.is_empty());
        for command in [-99.0, 0.4, 77.7] {
            let exact = |period: f64| {
                wave(period).value(
                    Axis::X,
                    &AxisVector([command, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]),
                    &State::default(),
                )
            };
            let found = at(&on_grid, command, 0);
            assert_eq!(found[1], exact(20.0));
            assert!((found[2] - exact(400.0)).abs() < 1.3e-6);
        }
    }
}
