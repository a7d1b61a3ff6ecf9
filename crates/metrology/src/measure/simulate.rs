//! Simulated readings of instruments on a machine with errors: the inverse of the equations of a calibration.
//!
//! A predicted reading uses [`Kind::equations`](super::kind::Instrument::equations), so that there is one formula for both. Unknowns of a set-up have their
//! described values. For a kind that reads positions (probing), the linear axes move until its equations are satisfied.

use ncfix_base::geometry::{Axis, AxisVector, Matrix, Vector};
use ncfix_machine::machine::Machine;
use ncfix_model::{ErrorModel, Model};

use super::data::{DataSet, Observation};
use super::kind::{Equation, Seen};

/// Residual of the equations at which the axes are in place, mm.
const LIMIT_MM: f64 = 1e-8;
/// Maximum number of iterations; each divides errors of 1e-4 by about 1e3.
const MAX_STEPS: usize = 30;

/// Result of reading a row.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ReadValue {
    /// Values as in [`Observation::values`], mm or rad.
    Values([Option<f64>; 3]),
    /// Positions of the axes, mm and rad.
    Position(AxisVector),
}

/// The row has no reading: the linear axes cannot bring the tip to its place.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct OutOfReach;

/// A planned measurement on a machine.
#[derive(Debug)]
pub struct Simulation<'a> {
    machine: &'a Machine,
    errors: &'a ErrorModel,
    /// For the condition of this index.
    model: Model,
    condition: usize,
    data: &'a DataSet,
    /// Values of the unknowns of the set-ups.
    values: Vec<f64>,
}

impl<'a> Simulation<'a> {
    /// Balls are at their described positions, otherwise at the mean of the nominal tips of their rows.
    #[must_use]
    pub fn new(machine: &'a Machine, errors: &'a ErrorModel, data: &'a DataSet) -> Simulation<'a> {
        let model = Model::new(machine, errors);
        let mut values = Vec::new();
        let has_places = data.observations.iter().any(reads_positions);
        for (number, label) in data.targets.iter().enumerate().filter(|_| has_places) {
            let given = data.balls.iter().find(|(name, _)| name == label).map(|&(_, place)| place);
            let place = given.unwrap_or_else(|| {
                let own = data.observations.iter().filter(|row| row.target == Some(number));
                let tips: Vec<Vector> =
                    own.map(|row| model.nominal(&row.reading.position, &row.reading.tool_mm).translation).collect();
                tips.iter().sum::<Vector>() / tips.len().max(1) as f64
            });
            values.extend(place.iter());
        }
        Simulation { machine, errors, model, condition: usize::MAX, data, values }
    }

    /// Creates a simulation with these values of the unknowns, in the order of the kind.
    #[must_use]
    pub fn with_unknowns(
        machine: &'a Machine,
        errors: &'a ErrorModel,
        data: &'a DataSet,
        values: Vec<f64>,
    ) -> Simulation<'a> {
        let model = Model::new(machine, errors);
        Simulation { machine, errors, model, condition: usize::MAX, data, values }
    }

    /// The simulated reading of a row of the plan, in the condition of the row.
    ///
    /// # Errors
    /// [`OutOfReach`].
    pub fn read(&mut self, row: &Observation) -> Result<ReadValue, OutOfReach> {
        if self.condition != row.condition {
            self.condition = row.condition;
            self.model = Model::at(self.machine, self.errors, self.data.condition(row));
        }
        if reads_positions(row) {
            self.position(row).map(ReadValue::Position)
        } else {
            Ok(ReadValue::Values(self.values_of(row)))
        }
    }

    /// Residuals of the equations of a row.
    fn residuals(&self, row: &Observation) -> Vec<f64> {
        let seen = Seen::new(self.machine, &self.model, &row.reading, &row.reading.tool_mm);
        let mut equations: Vec<Equation> = Vec::new();
        (self.data.kind.equations)(self.data, row, &seen, &self.values, &mut equations);
        equations.iter().map(|equation| equation.residual).collect()
    }

    fn values_of(&self, row: &Observation) -> [Option<f64>; 3] {
        let at = |value: f64| self.residuals(&Observation { values: row.values.map(|old| old.map(|_| value)), ..*row });
        // A residual is the reading minus the prediction, times an optional factor of the kind for its unit.
        let (zero, one) = (at(0.0), at(1.0));
        let mut predicted = zero.iter().zip(&one).map(|(zero, one)| -zero / (one - zero));
        row.values.map(|value| value.and_then(|_| predicted.next()))
    }

    fn position(&self, row: &Observation) -> Result<AxisVector, OutOfReach> {
        let mut now = *row;
        let tip = |command: &AxisVector| self.model.nominal(command, &row.reading.tool_mm).translation;
        let axes = [Axis::X, Axis::Y, Axis::Z];
        // The nominal tip is linear in the linear axes. Residuals are along the directions of F.
        let to_f = Seen::new(self.machine, &self.model, &row.reading, &row.reading.tool_mm).to_f;
        let columns = axes.map(|axis| {
            let mut moved = row.reading.position;
            moved[axis] += 1.0;
            to_f * (tip(&moved) - tip(&row.reading.position))
        });
        let back = Matrix::from_columns(&columns).try_inverse().ok_or(OutOfReach)?;
        for _ in 0..MAX_STEPS {
            let residuals = self.residuals(&now);
            let [x, y, z] = residuals.as_slice() else { return Err(OutOfReach) };
            let off = Vector::new(*x, *y, *z);
            let step = back * off;
            for (axis, step) in axes.into_iter().zip(step.iter()) {
                now.reading.position[axis] += step;
            }
            if off.norm() < LIMIT_MM {
                return Ok(now.reading.position);
            }
        }
        Err(OutOfReach)
    }
}

/// `true` if the row reads positions: it has no values.
fn reads_positions(row: &Observation) -> bool {
    row.values.iter().all(Option::is_none)
}
