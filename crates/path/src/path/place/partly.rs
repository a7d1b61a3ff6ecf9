//! Positions for moves of only some output axes: rapid moves that are not an approach to a cut.

use super::{CommandSolver, Placed, SHORT_MM};
use crate::path::standing::PathState;
use ncfix_base::geometry::{AXES, Axis, AxisSet, AxisVector, Vector};

impl CommandSolver<'_> {
    /// The position with the output axes in `moving` at `target`, on the grid, and the others unchanged.
    pub(in crate::path) fn partly(
        &self,
        target: &AxisVector,
        standing: &PathState,
        moving: AxisSet,
        known: AxisSet,
    ) -> Placed {
        let wanted = self.programmed(target);
        let mut programmed = self.programmed(&standing.command);
        let mut counts = standing.counts;
        // The machine file states where a rotary axis is before the first motion.
        let begins = |axis: Axis| axis.is_rotary() && known.contains(axis) && !standing.known.contains(axis);
        for axis in AXES {
            let slot = axis.slot();
            if moving.contains(axis) || begins(axis) {
                counts[slot] = self.increments.count(axis, wanted[axis]);
                programmed[axis] = self.increments.position(axis, counts[slot]);
            } else if !standing.written.contains(axis) {
                counts[slot] = self.increments.count(axis, programmed[axis]);
            }
        }
        let mut command = self.command(&programmed);
        let is_parallel = self.is_parallel();
        for axis in AXES {
            if !known.contains(axis) {
                command[axis] = target[axis];
            } else if !moving.contains(axis) && !begins(axis) && (is_parallel || axis.slot() > 2) {
                command[axis] = standing.command[axis];
            }
        }
        Placed { counts, command, failure: None, is_held_back: false }
    }

    /// The output axes that a rapid move moves: those that it names, and those whose end position differs.
    pub(in crate::path) fn moving(&self, named: AxisSet, known: AxisSet, [start, end]: [&AxisVector; 2]) -> AxisSet {
        let [start, end] = [start, end].map(|command| self.programmed(command));
        let changes = |&axis: &Axis| known.contains(axis) && (end[axis] - start[axis]).abs() > SHORT_MM;
        AXES.into_iter().filter(changes).collect::<AxisSet>().union(named)
    }

    /// Rise of the tip from one command to another, along the tool, mm.
    pub(in crate::path) fn height_mm(&self, from: &AxisVector, to: &AxisVector) -> f64 {
        let tip = |command: &AxisVector| self.kinematics.tip_mm(command, &self.setup.tool_mm);
        (tip(to) - tip(from)).dot(&self.kinematics.direction(to))
    }

    /// The direction of the tool at a command, from the tip to the spindle in the workpiece, and the height of its tip along it, mm.
    pub(in crate::path) fn height_at(&self, command: &AxisVector) -> (Vector, f64) {
        let direction = self.kinematics.direction(command);
        (direction, self.kinematics.tip_mm(command, &self.setup.tool_mm).dot(&direction))
    }

    /// `true` if a rapid move of these output axes is along the tool.
    pub(in crate::path) fn is_along_tool(&self, moving: AxisSet, [start, end]: [&AxisVector; 2]) -> bool {
        if moving.iter().any(Axis::is_rotary) {
            return false;
        }
        let normal = self.setup.plane.axes()[2].dimension();
        if moving.iter().all(|axis| axis.dimension() == normal) {
            return true;
        }
        let tip = |command: &AxisVector| self.kinematics.tip_mm(command, &self.setup.tool_mm);
        let way = tip(end) - tip(start);
        // Positions are written in increments.
        way.cross(&self.kinematics.direction(end)).norm() <= 2.0 * self.increments.linear_mm
    }
}
