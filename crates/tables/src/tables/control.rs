//! Evaluation of tables as in a control: the correction added to a set-point.

use super::{ErrorTables, Multiplication, Tables};
use ncfix_base::geometry::{Axis, AxisVector, LINEAR_AXES, Vector};
use ncfix_machine::machine::{ActiveCompensation, ActiveTables, Machine, State};
use ncfix_model::location::LocationError;
use ncfix_model::motion::{EntryFunction, MotionError, table};
use ncfix_model::name::DIRECTIONS;
use ncfix_model::{ErrorModel, ErrorName, Model, Solve};

/// Points of several tables that are nearer than this are one point: files round positions, and an error of 1 µm/mm changes by 1 nm over 1 µm.
const NEAR_MM: f64 = 1e-3;
/// Same distance of a rotary axis: 1 µm at an arm of 1 m.
const NEAR_RAD: f64 = 1e-6;

/// A control with its tables, ready for evaluation.
#[derive(Clone, Debug)]
pub struct Control {
    tables: Tables,
    /// Kinematics of the control with these error functions.
    kinematics: Option<Model>,
}

impl Control {
    /// Creates a control of a machine; the machine gives the kinematics for error functions.
    #[must_use]
    pub fn new(machine: &Machine, tables: &Tables) -> Control {
        // The control has its tables once: active tables are not part of its kinematics.
        let kinematics = tables.errors.as_ref().map(|errors| {
            let bare = Machine { active_tables: ActiveTables::default(), ..machine.clone() };
            Model::new(&bare, &error_model(errors))
        });
        Control { tables: tables.clone(), kinematics }
    }

    /// Correction added to the axis commands at a set-point, mm and rad. The set-point is uncompensated; `state` has the directions of motion.
    /// `tool_mm` leads from the gauge point to the tip, in F at the zero pose; only error functions depend on it.
    ///
    /// A control with error functions corrects the tip position with the linear axes and leaves the tool direction unchanged.
    #[must_use]
    pub fn correction(&self, command: &AxisVector, tool_mm: &Vector, state: &State) -> AxisVector {
        let mut sum = self.looked_up(command, state);
        if let Some(grid) = &self.tables.grid {
            grid.axes.iter().zip(grid.at(command)).for_each(|(&axis, value)| sum[axis] += value);
        }
        if let Some(matrix) = &self.tables.matrix {
            for (row, &axis) in matrix.iter().zip(&LINEAR_AXES[..3]) {
                let motor: f64 = row.iter().zip(&LINEAR_AXES[..3]).map(|(factor, &axis)| factor * command[axis]).sum();
                sum[axis] += motor - command[axis];
            }
        }
        if let Some(model) = &self.kinematics {
            // If the tip cannot be brought to its place, the control leaves it unchanged.
            if let Ok(solved) = model.solve(command, tool_mm, state, command, Solve::PositionOnly) {
                sum = sum + (solved - *command);
            }
        }
        sum
    }

    /// The sum of the tables of one axis and their products.
    fn looked_up(&self, command: &AxisVector, state: &State) -> AxisVector {
        let mut sum = AxisVector::default();
        let lookups = &self.tables.lookups;
        for one in lookups {
            let own = one.at(command, state);
            let value = match one.factor.and_then(|factor| lookups.get(factor)) {
                None => own,
                Some(factor) => {
                    let product = own * factor.at(command, state);
                    if self.tables.multiplication == Multiplication::Beside { own + product } else { product }
                }
            };
            sum[one.output] += if one.output.is_rotary() { value.to_radians() } else { value };
        }
        sum
    }
}

impl ActiveCompensation for Control {
    fn correction(&self, command: &AxisVector, tool_mm: &Vector, state: &State) -> AxisVector {
        Control::correction(self, command, tool_mm, state)
    }

    fn knots(&self, axis: Axis) -> Vec<f64> {
        let mut knots = Vec::new();
        for one in self.tables.lookups.iter().filter(|one| one.input == axis) {
            knots.extend((0..one.nodes.count()).map(|index| one.nodes.position(index)));
        }
        if let Some(grid) = &self.tables.grid
            && let Some(i) = grid.axes.iter().position(|&one| one == axis)
        {
            knots.extend((0..grid.count[i]).map(|node| grid.start[i] + grid.step[i] * node as f64));
        }
        for one in self.tables.errors.iter().flat_map(|errors| &errors.axes).filter(|one| one.axis == axis) {
            knots.extend(&one.positions);
        }
        if axis.is_rotary() {
            knots.iter_mut().for_each(|knot| *knot = knot.to_radians());
        }
        knots.sort_by(f64::total_cmp);
        let near = if axis.is_rotary() { NEAR_RAD } else { NEAR_MM };
        knots.dedup_by(|next, last| *next - *last < near);
        knots
    }

    fn has_senses(&self, axis: Axis) -> bool {
        self.tables.lookups.iter().any(|one| one.input == axis && one.sense != super::Sense::Both)
    }
}

/// Error functions as an error model.
fn error_model(errors: &ErrorTables) -> ErrorModel {
    let location = errors.location.iter().map(|&(name, value)| LocationError { name, value }).collect();
    let mut motion = Vec::new();
    for one in &errors.axes {
        let scale = if one.axis.is_rotary() { f64::to_radians } else { |value| value };
        let positions: Vec<f64> = one.positions.iter().map(|&position| scale(position)).collect();
        for (index, direction) in DIRECTIONS.into_iter().enumerate() {
            let values: Vec<f64> = one.values.iter().map(|row| row[index]).collect();
            if values.iter().any(|&value| value != 0.0) {
                let function = EntryFunction::Table(table::ErrorTable { positions: positions.clone(), values });
                motion.push(MotionError { name: ErrorName::motion(direction, one.axis), function });
            }
        }
    }
    ErrorModel { location, motion, ..ErrorModel::default() }
}
