//! The kernel: the error model of a machine in one condition, prepared for the cycle of a control.

use ncfix_base::geometry::{AXES, AXIS_COUNT, Axis, AxisSet, AxisVector, Vector};
use ncfix_machine::machine::{Machine, State};
use ncfix_model::{Model, Solve};

/// Intervals between the end switches of every axis (Spaan 1995, ch. 6).
pub const INTERVALS: usize = 200;

/// Primes whose digits spread poses evenly over the travel (Halton's sequence).
const BASES: [u32; AXIS_COUNT] = [2, 3, 5, 7, 11, 13, 17, 19, 23];

/// Model, tool and travel limits in the form for the cycle.
#[derive(Clone, Debug)]
pub struct Kernel {
    model: Model,
    tool_mm: Vector,
    mode: Solve,
    axes: AxisSet,
    /// mm or rad, by slot; infinite for an axis without limits.
    travel: [[f64; 2]; AXIS_COUNT],
}

/// Agreement of a kernel with its model.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Agreement {
    /// Number of compared poses.
    pub poses: usize,
    /// Largest distance between the tips for both corrections, on the model itself, mm.
    pub position_mm: f64,
    /// Largest angle between the directions of the tool, rad.
    pub direction_rad: f64,
    /// Number of poses for which the model has a correction and the kernel has none: it then holds the last one.
    pub unequal: usize,
    /// Number of poses for which the model has no correction.
    pub unsolved: usize,
    /// Largest correction of a linear axis, mm.
    pub largest_mm: f64,
}

impl Kernel {
    /// Prepares a model. `tool_mm` leads from the spindle gauge point to the tip, in F at the zero pose; the mode determines whether rotary axes are
    /// corrected too.
    #[must_use]
    pub fn new(machine: &Machine, model: &Model, tool_mm: &Vector, mode: Solve) -> Kernel {
        let unlimited = [f64::NEG_INFINITY, f64::INFINITY];
        Kernel {
            model: model.on_intervals(machine, INTERVALS),
            tool_mm: *tool_mm,
            mode,
            axes: machine.axis_set(),
            travel: AXES.map(|axis| machine.axis(axis).and_then(|data| data.travel).unwrap_or(unlimited)),
        }
    }

    /// The axes of the machine.
    #[must_use]
    pub fn axes(&self) -> AxisSet {
        self.axes
    }

    /// Number of functions of an axis that are evaluated directly, because they depend on two axes or bend too much for the intervals.
    #[must_use]
    pub fn direct_functions(&self, axis: Axis) -> usize {
        self.model.direct_functions(axis)
    }

    /// Correction to add to a set-point, mm and rad, for the last directions of motion; `None` if no command brings the tip to its place.
    #[must_use]
    pub fn correction(&self, set_point: &AxisVector, state: &State) -> Option<AxisVector> {
        Some(self.model.solve_in_cycle(set_point, &self.tool_mm, state, self.mode)? - *set_point)
    }

    /// Clamps a set-point to the travel. Returns the axes that were beyond it.
    pub(super) fn clamp(&self, set_point: &mut AxisVector) -> AxisSet {
        let mut beyond = AxisSet::EMPTY;
        for axis in self.axes.iter() {
            let [low, high] = self.travel[axis.slot()];
            let value = set_point[axis];
            if !(low..=high).contains(&value) {
                set_point[axis] = value.max(low).min(high);
                beyond.insert(axis);
            }
        }
        beyond
    }

    /// Compares the kernel with the iterated solution of its model, at poses over the whole travel and for both directions of motion. Not for use in
    /// the cycle.
    #[must_use]
    pub fn agreement(&self, machine: &Machine, model: &Model, poses: usize) -> Agreement {
        let mut found = Agreement { poses, ..Agreement::default() };
        for number in 1..=poses {
            let nominal = self.pose(number);
            let direction = AXES.map(|axis| if (number >> axis.slot()) & 1 == 0 { 1 } else { -1 });
            let state = State { direction, ..State::default() };
            let exact = model.solve(&nominal, &self.tool_mm, &state, &nominal, self.mode).ok();
            let fast = self.correction(&nominal, &state).map(|correction| nominal + correction);
            let (Some(exact), Some(fast)) = (exact, fast) else {
                found.unequal += usize::from(exact.is_some());
                found.unsolved += usize::from(exact.is_none());
                continue;
            };
            let [exact_pose, fast_pose] = [exact, fast].map(|command| model.actual(&command, &self.tool_mm, &state));
            let apart = (exact_pose.translation - fast_pose.translation).norm();
            let turned = (exact_pose.rotation - fast_pose.rotation) * machine.spindle.axis;
            let linear = (exact - nominal).0.iter().take(6).fold(0.0, |most: f64, value| most.max(value.abs()));
            found.position_mm = found.position_mm.max(apart);
            found.direction_rad = found.direction_rad.max(turned.norm());
            found.largest_mm = found.largest_mm.max(linear);
        }
        found
    }

    /// A pose of Halton's sequence within the travel; axes without limits use ±1000 mm or ±180°.
    fn pose(&self, number: usize) -> AxisVector {
        let mut pose = AxisVector::ZERO;
        for axis in self.axes.iter() {
            let reach = if axis.is_rotary() { std::f64::consts::PI } else { 1e3 };
            let [low, high] = self.travel[axis.slot()];
            let [low, high] = [low.max(high.min(reach) - 2.0 * reach), high.min(low.max(-reach) + 2.0 * reach)];
            pose[axis] = low + (high - low) * radical_inverse(number, BASES[axis.slot()]);
        }
        pose
    }
}

/// The radical inverse of a number: its digits in reverse order after the point.
fn radical_inverse(mut number: usize, base: u32) -> f64 {
    let (mut value, mut weight) = (0.0, 1.0 / f64::from(base));
    while number > 0 {
        value += weight * (number % base as usize) as f64;
        number /= base as usize;
        weight /= f64::from(base);
    }
    value
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn digits_are_reversed() {
        // 6 = 110 in base 2 gives 0.011, 5 = 12 in base 3 gives 0.21.
        assert_eq!(radical_inverse(6, 2), 0.375);
        assert!((radical_inverse(5, 3) - 7.0 / 9.0).abs() < 1e-15);
    }
}
