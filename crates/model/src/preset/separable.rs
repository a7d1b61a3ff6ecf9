//! Which parameters can be told apart by readings of the tool tip's place on a workpiece, whatever the poses.
//!
//! Rows are three displacements at poses all over the chain's range; columns are the sensitivities to the parameters, behind
//! those to what the set-up leaves unknown. Columns are taken in turn: one that is a combination of those before it is left out.

use crate::{ErrorModel, ErrorName, Model, ParameterName};
use ncfix_base::geometry::{AXES, AxisVector, Vector};
use ncfix_machine::machine::{Machine, State};

/// Poses, many more than a third of the parameters.
const POSES: usize = 120;
/// Commands of linear axes lie within ± this, mm.
const LINEAR_REACH_MM: f64 = 300.0;
/// Commands of rotary axes lie within ± this, rad.
const ROTARY_REACH_RAD: f64 = 2.0;
/// Length of the tool, mm.
const TOOL_MM: f64 = 150.0;
/// What is left of a column of length 1 that counts as independent of those before it.
const LEAST_REMAINDER: f64 = 1e-7;

/// What is unknown beside the parameters and the place of the workpiece, which always is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum SetUp {
    /// Tool length. The artefact has a known length, and the tool's offset was told from the spindle's by indexing the spindle.
    ToolLength,
    /// All of the tool vector, and the size of the artefact.
    ToolAndSize,
}

/// A pose at which the tip is read, and the senses in which it was reached.
struct Reading {
    command: AxisVector,
    senses: State,
}

/// A machine and the readings on it.
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

    /// Displacement of the tip per mm or rad of a component at a pose, in the tool frame.
    fn sensitivity(&self, component: ErrorName, reading: &Reading) -> Vector {
        self.model.sensitivity(component, &reading.command, &self.tool_mm).translation
    }

    /// Whether a component moves the tip by the same everywhere: a displacement, or a rotation with a constant arm.
    pub(super) fn is_constant(&self, component: ErrorName) -> bool {
        let mut effects = self.readings.iter().map(|reading| self.sensitivity(component, reading));
        let first = effects.next().unwrap_or_default();
        effects.all(|effect| (effect - first).norm() <= LEAST_REMAINDER * TOOL_MM)
    }

    /// The candidates that are no combination of the set-up and of candidates before them.
    pub(super) fn separable(&self, candidates: &[ParameterName], set_up: SetUp) -> Vec<ParameterName> {
        let mut basis = Basis::default();
        for column in self.set_up_columns(set_up) {
            basis.take(column);
        }
        candidates.iter().filter(|parameter| basis.take(self.effect(parameter))).copied().collect()
    }

    /// The column of a parameter.
    fn effect(&self, parameter: &ParameterName) -> Vec<f64> {
        let mut column = Vec::with_capacity(3 * POSES);
        for reading in &self.readings {
            let weight = parameter.weight(&reading.command, &reading.senses);
            column.extend((self.sensitivity(parameter.component, reading) * weight).iter());
        }
        column
    }

    /// What the set-up leaves unknown, seen in the tool frame as the parameters are.
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

/// The pose of a number: multiples of irrational numbers fill the range evenly, and the same each time.
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

/// Columns at right angles to each other (Gram–Schmidt).
#[derive(Default)]
struct Basis(Vec<Vec<f64>>);

impl Basis {
    /// Takes a column in; `false` where it is a combination of those in it.
    fn take(&mut self, mut column: Vec<f64>) -> bool {
        if !normalize(&mut column, f64::MIN_POSITIVE) {
            return false;
        }
        // A second round takes away what rounding has left of the first.
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

/// Scales a column to length 1; `false` where it is no longer than `least`.
fn normalize(column: &mut [f64], least: f64) -> bool {
    let length = column.iter().map(|entry| entry * entry).sum::<f64>().sqrt();
    column.iter_mut().for_each(|entry| *entry /= length);
    length > least
}
