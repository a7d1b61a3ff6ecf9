//! Determines the parameters that are separable by tip positions on a workpiece, for any choice of poses.
//!
//! Rows are three displacements at poses all over the range of the chain. Columns are the sensitivities to the unknowns of the set-up, followed by those to
//! the parameters. Columns are taken in turn; one that is a combination of those before it is omitted.

use crate::{ErrorModel, ErrorName, Model, ParameterName};
use ncfix_base::geometry::{AXES, AxisVector, Vector};
use ncfix_machine::machine::{Machine, State};

/// Number of poses, well above a third of the number of parameters.
const POSES: usize = 120;
/// Range of the commands of linear axes, ± mm.
const LINEAR_REACH_MM: f64 = 300.0;
/// Range of the commands of rotary axes, ± rad.
const ROTARY_REACH_RAD: f64 = 2.0;
/// Length of the tool, mm.
const TOOL_MM: f64 = 150.0;
/// Smallest residual of a column of length 1 that counts as independent of those before it.
const LEAST_REMAINDER: f64 = 1e-7;

/// Unknowns in addition to the parameters and the position of the workpiece, which is always unknown.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum SetUp {
    /// Tool length. The artifact has a known length, and the offset of the tool was separated from that of the spindle by indexing the spindle.
    ToolLength,
    /// The whole tool vector, and the size of the artifact.
    ToolAndSize,
}

/// Pose at which the tip is measured, and the directions from which it was reached.
struct Reading {
    command: AxisVector,
    senses: State,
}

/// Machine with the planned readings.
pub(super) struct ReadingPlan {
    model: Model,
    spindle: Vector,
    tool_mm: Vector,
    readings: Vec<Reading>,
}

impl ReadingPlan {
    pub(super) fn of(machine: &Machine) -> ReadingPlan {
        ReadingPlan {
            model: Model::new(machine, &ErrorModel::default()),
            spindle: machine.spindle.axis,
            tool_mm: machine.spindle.axis * -TOOL_MM,
            readings: (1..=POSES).map(reading).collect(),
        }
    }

    /// Returns the displacement of the tip per mm or rad of a component at a pose, in the tool frame.
    fn sensitivity(&self, component: ErrorName, reading: &Reading) -> Vector {
        self.model.sensitivity(component, &reading.command, &self.tool_mm).translation
    }

    /// True if the effect of a component on the tip is constant: a displacement, or a rotation with a constant arm.
    pub(super) fn is_constant(&self, component: ErrorName) -> bool {
        let mut effects = self.readings.iter().map(|reading| self.sensitivity(component, reading));
        let first = effects.next().unwrap_or_default();
        effects.all(|effect| (effect - first).norm() <= LEAST_REMAINDER * TOOL_MM)
    }

    /// Returns the candidates that are not a combination of the set-up and of earlier candidates.
    pub(super) fn separable(&self, candidates: &[ParameterName], set_up: SetUp) -> Vec<ParameterName> {
        let mut basis = Basis::default();
        for column in self.set_up_columns(set_up) {
            basis.take(column);
        }
        candidates.iter().filter(|parameter| basis.take(self.effect(parameter))).copied().collect()
    }

    /// Returns the column of a parameter.
    fn effect(&self, parameter: &ParameterName) -> Vec<f64> {
        let mut column = Vec::with_capacity(3 * POSES);
        for reading in &self.readings {
            let weight = parameter.weight(&reading.command, &reading.senses);
            column.extend((self.sensitivity(parameter.component, reading) * weight).iter());
        }
        column
    }

    /// Returns the columns of the unknowns of the set-up, in the tool frame like the parameters.
    fn set_up_columns(&self, set_up: SetUp) -> Vec<Vec<f64>> {
        let units = [0, 1, 2].map(|row| Vector::ith(row, 1.0));
        let count = if set_up == SetUp::ToolAndSize { 10 } else { 7 };
        let mut columns = vec![Vec::new(); count];
        for reading in &self.readings {
            let pose = self.model.nominal(&reading.command, &self.tool_mm);
            let back = pose.rotation.transpose();
            let placed = units.map(|unit| back * unit);
            let turned = units.map(|unit| back * unit.cross(&pose.translation));
            let rest = match set_up {
                SetUp::ToolLength => vec![self.spindle],
                SetUp::ToolAndSize => vec![units[0], units[1], units[2], back * pose.translation],
            };
            for (column, effect) in columns.iter_mut().zip(placed.into_iter().chain(turned).chain(rest)) {
                column.extend(effect.iter());
            }
        }
        columns
    }
}

/// Returns the pose with this number. Multiples of irrational numbers fill the range evenly and reproducibly.
fn reading(number: usize) -> Reading {
    let fraction = |prime: f64| (number as f64 * prime.sqrt()).fract() * 2.0 - 1.0;
    let mut senses = State::default();
    let primes = [2.0, 3.0, 5.0, 7.0, 11.0, 13.0, 17.0, 19.0, 23.0];
    for (sense, prime) in senses.direction.iter_mut().zip(primes) {
        *sense = if fraction(prime + 24.0) < 0.0 { -1 } else { 1 };
    }
    let mut command = AxisVector::ZERO;
    for (axis, prime) in AXES.into_iter().zip(primes) {
        command[axis] = fraction(prime) * if axis.is_rotary() { ROTARY_REACH_RAD } else { LINEAR_REACH_MM };
    }
    Reading { command, senses }
}

/// Orthonormal columns (Gram–Schmidt).
#[derive(Default)]
struct Basis(Vec<Vec<f64>>);

impl Basis {
    /// Adds a column; returns `false` if it is a combination of the existing ones.
    fn take(&mut self, mut column: Vec<f64>) -> bool {
        if !normalize(&mut column, f64::MIN_POSITIVE) {
            return false;
        }
        // A second pass removes the rounding errors of the first.
        for _ in 0..2 {
            for unit in &self.0 {
                let along: f64 = unit.iter().zip(&column).map(|(a, b)| a * b).sum();
                for (entry, unit) in column.iter_mut().zip(unit) {
                    *entry -= along * unit;
                }
            }
        }
        let is_new = normalize(&mut column, LEAST_REMAINDER);
        if is_new {
            self.0.push(column);
        }
        is_new
    }
}

/// Scales a column to length 1; returns `false` if it is no longer than `least`.
fn normalize(column: &mut [f64], least: f64) -> bool {
    let length = column.iter().map(|entry| entry * entry).sum::<f64>().sqrt();
    column.iter_mut().for_each(|entry| *entry /= length);
    length > least
}
