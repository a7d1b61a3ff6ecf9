//! Accumulator: adds the contributions of all error sources to the location and motion errors of the axes.
//!
//! Sources do not depend on each other; the chain ([`super::link`]), correction and prediction use only the sum (Spaan 1995, ch. 2 and 6).

use ncfix_base::geometry::{AXIS_COUNT, Axis, AxisVector, Vector};
use ncfix_machine::machine::{Branch, Condition, Machine, State};

use super::motion::{EntryFunction, MotionError};
use super::name::{Carrier, DIRECTIONS, Direction, ErrorKind, ErrorName};
use super::source::Effect;
use super::{ErrorModel, Model};

/// Errors of a machine in one condition.
#[derive(Clone, Debug)]
pub struct Accumulator<'a> {
    machine: &'a Machine,
    /// Location errors of the axes by slot: EX EY EZ (mm), EA EB EC (rad).
    location: [[f64; 6]; AXIS_COUNT],
    spindle: [f64; 6],
    motion: Vec<MotionError>,
    /// Sign of the current contribution: −1 if it is subtracted.
    sign: f64,
}

impl<'a> Accumulator<'a> {
    /// Sums the effects of a model that are `wanted`.
    ///
    /// Drifting effects count from the condition in which the zero point was set, if it is known. If the pose is known, too, only the displacement of the tip
    /// at that pose is subtracted.
    #[must_use]
    pub fn sum(
        machine: &'a Machine,
        errors: &ErrorModel,
        condition: &Condition,
        wanted: impl Fn(&dyn Effect) -> bool,
    ) -> Accumulator<'a> {
        let mut sum = Accumulator::gathered(machine, errors, condition, &wanted);
        let Some(zero) = condition.zero() else { return sum };
        let drifts = |effect: &dyn Effect| wanted(effect) && effect.drifts();
        if let Some(pose) = condition.zero_pose() {
            // The zero offset compensates the drift at the position of the tool; the drift elsewhere, and of the direction, remains.
            let then = Model::summed(&Accumulator::gathered(machine, errors, zero, &drifts));
            let moved = then.deviation(&pose.command, &pose.tool_mm, &State::default());
            sum.add_offset(&-moved.translation);
        } else {
            sum.sign = -1.0;
            errors.effects().filter(|&effect| drifts(effect)).for_each(|effect| effect.contribute(zero, &mut sum));
            sum.sign = 1.0;
        }
        sum
    }

    /// Returns the sum in a condition, without the condition in which the zero point was set.
    fn gathered(
        machine: &'a Machine,
        errors: &ErrorModel,
        condition: &Condition,
        wanted: &dyn Fn(&dyn Effect) -> bool,
    ) -> Accumulator<'a> {
        let mut sum =
            Accumulator { machine, location: [[0.0; 6]; AXIS_COUNT], spindle: [0.0; 6], motion: Vec::new(), sign: 1.0 };
        errors.effects().filter(|&effect| wanted(effect)).for_each(|effect| effect.contribute(condition, &mut sum));
        sum
    }

    /// Returns the machine.
    #[must_use]
    pub fn machine(&self) -> &'a Machine {
        self.machine
    }

    /// Adds to a location error, mm or rad. Errors of axes that the machine lacks have no effect.
    pub fn add_location(&mut self, name: ErrorName, value: f64) {
        let components = match name.carrier {
            Carrier::Axis(axis) => &mut self.location[axis.slot()],
            Carrier::Spindle => &mut self.spindle,
        };
        components[name.direction.index()] += self.sign * value;
    }

    /// Adds a function (mm or rad, deviation of the body that the axis moves, along and about F) multiplied by a factor to a motion error.
    pub fn add_motion(&mut self, name: ErrorName, function: &EntryFunction, factor: f64) {
        let factor = self.sign * factor;
        if factor != 0.0 && !function.is_zero() {
            let function = if factor == 1.0 { function.clone() } else { function.scaled(factor) };
            self.motion.push(MotionError { name, function });
        }
    }

    /// Adds a displacement of the tool relative to the workpiece along the axes of F, constant over all positions, mm.
    pub fn add_offset(&mut self, offset_mm: &Vector) {
        // The axis on the foundation displaces everything that it carries, and no rotary axis rotates this displacement.
        let topology = &self.machine.topology;
        let (axis, sense) = match (topology.tool.first(), topology.workpiece.first()) {
            (Some(&axis), _) => (axis, 1.0),
            (None, Some(&axis)) => (axis, -1.0),
            (None, None) => return,
        };
        for (direction, value) in DIRECTIONS.into_iter().zip(offset_mm.iter()) {
            self.add_location(ErrorName::location(direction, axis), sense * value);
        }
    }

    /// Adds a displacement of the tool relative to the workpiece along an axis of F that depends on the position of an axis, mm.
    pub fn add_relative(&mut self, direction: Direction, over: Axis, function: &EntryFunction) {
        let sense = if self.machine.topology.branch(over) == Some(Branch::Workpiece) { -1.0 } else { 1.0 };
        self.add_motion(ErrorName::motion(direction, over), function, sense);
    }

    /// Returns the value of a component at a pose, mm or rad.
    #[must_use]
    pub fn value(&self, name: ErrorName, command: &AxisVector, state: &State) -> f64 {
        match (name.kind, name.axis()) {
            (ErrorKind::Motion, Some(axis)) => {
                let own = self.motion.iter().filter(|error| error.name == name);
                own.map(|error| error.function.value(axis, command, state)).sum()
            }
            _ => self.location(name.carrier)[name.direction.index()],
        }
    }

    /// Returns all contributions: location errors with their values, motion errors with their functions. Components may occur more than once.
    #[must_use]
    pub fn parts(&self) -> Vec<(ErrorName, Option<&EntryFunction>, f64)> {
        let axes = self.machine.axes.iter().flatten().map(|data| Carrier::Axis(data.axis));
        let places = axes.chain([Carrier::Spindle]).flat_map(|carrier| {
            let values = self.location(carrier);
            DIRECTIONS.into_iter().map(move |direction| {
                let name = ErrorName { direction, carrier, kind: ErrorKind::Location };
                (name, None, values[direction.index()])
            })
        });
        let motion = self.motion.iter().map(|error| (error.name, Some(&error.function), 1.0));
        places.filter(|&(_, _, value)| value != 0.0).chain(motion).collect()
    }

    /// Returns the location errors of a carrier: EX EY EZ (mm), EA EB EC (rad).
    pub(super) fn location(&self, carrier: Carrier) -> [f64; 6] {
        match carrier {
            Carrier::Axis(axis) => self.location[axis.slot()],
            Carrier::Spindle => self.spindle,
        }
    }

    /// Returns the motion errors; entries of one component add up.
    pub(super) fn motion(&self) -> &[MotionError] {
        &self.motion
    }
}
