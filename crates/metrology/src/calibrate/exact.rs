//! Measurements as they would be on an error-free machine.
//!
//! Exact dependences on such a machine, as between the length of a ball-bar and the gains of all axes, hold only to 1e-4 with machine errors, and
//! only to 1e-6 with positions on increments: the unknowns would seem identifiable. Identifiability is therefore judged with zero readings, and with
//! the linear axes at positions where the instrument reads zero: the tip at the ball, the bar at its length.

use crate::measure::data::{DataSet, Observation};
use crate::measure::kind::{Equation, Seen};
use ncfix_base::geometry::{Axis, Matrix, Vector};
use ncfix_machine::machine::{Condition, Machine};
use ncfix_model::{ErrorModel, Model};

/// Number of iterations to the position of zero reading: positions are off by errors of 1e-4, and each iteration reduces the error by about that
/// factor.
const STEPS: usize = 4;
/// Convergence limit, mm.
const THERE_MM: f64 = 1e-10;

/// The measurements with zero readings. Empty cells stay empty.
pub(super) fn exact(machine: &Machine, data: &[DataSet]) -> Vec<DataSet> {
    let model = Model::at(machine, &ErrorModel::default(), &Condition::default());
    let mut out = data.to_vec();
    for set in &mut out {
        let values = (set.kind.start)(set, &model);
        let mut observations = std::mem::take(&mut set.observations);
        for observation in &mut observations {
            observation.values = observation.values.map(|value| value.map(|_| 0.0));
            settle(machine, &model, set, &values, observation);
        }
        set.observations = observations;
    }
    out
}

/// Moves the linear axes to the position of zero reading.
fn settle(machine: &Machine, model: &Model, set: &DataSet, values: &[f64], observation: &mut Observation) {
    let tip = |row: &Observation| model.nominal(&row.reading.position, &row.reading.tool_mm).translation;
    let mut equations: Vec<Equation> = Vec::new();
    for _ in 0..STEPS {
        let seen = Seen::new(machine, model, &observation.reading, &observation.reading.tool_mm);
        equations.clear();
        (set.kind.equations)(set, observation, &seen, values, &mut equations);
        let mut shift = Vector::zeros();
        for equation in equations.iter().filter(|equation| !equation.is_angle) {
            let size = equation.by_tip.norm_squared();
            if size > 0.0 {
                shift += equation.by_tip * ((equation.residual - equation.by_tip.dot(&shift)) / size);
            }
        }
        if shift.norm() <= THERE_MM {
            return;
        }
        // The nominal tip is linear in the linear axes.
        let axes = [Axis::X, Axis::Y, Axis::Z];
        let here = tip(observation);
        let columns = axes.map(|axis| {
            let mut moved = *observation;
            moved.reading.position[axis] += 1.0;
            tip(&moved) - here
        });
        let Some(back) = Matrix::from_columns(&columns).try_inverse() else { return };
        for (axis, step) in axes.into_iter().zip((back * shift).iter()) {
            observation.reading.position[axis] += step;
        }
    }
}
