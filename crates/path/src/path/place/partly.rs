//! Positions to which only some axes of the output go: rapid moves that are no approach to a cut.

use super::{Placed, Placer, SHORT_MM};
use crate::path::standing::PathState;
use ncfix_base::geometry::{AXES, Axis, AxisSet, AxisVector, Vector};

impl Placer<'_> {
    /// The axes of the output that are in `moving` where they are at `target`, on the grid; the others where they stand.
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
        for axis in AXES {
            let slot = axis.slot();
            if moving.contains(axis) {
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
            } else if !moving.contains(axis) && (is_parallel || axis.slot() > 2) {
                command[axis] = standing.command[axis];
            }
        }
        Placed { counts, command, failure: None, is_held_back: false }
    }

    /// The axes of the output that a rapid move moves: those that it names, and those whose place is another at its end.
    pub(in crate::path) fn moving(&self, named: AxisSet, known: AxisSet, [start, end]: [&AxisVector; 2]) -> AxisSet {
        let [start, end] = [start, end].map(|command| self.programmed(command));
        let changes = |&axis: &Axis| known.contains(axis) && (end[axis] - start[axis]).abs() > SHORT_MM;
        AXES.into_iter().filter(changes).collect::<AxisSet>().union(named)
    }

    /// By how much the tip is higher at one command than at another, along the tool, mm.
    pub(in crate::path) fn height_mm(&self, from: &AxisVector, to: &AxisVector) -> f64 {
        let tip = |command: &AxisVector| self.kinematics.tip_mm(command, &self.setup.tool_mm);
        (tip(to) - tip(from)).dot(&self.kinematics.direction(to))
    }

    /// The direction of the tool at a command, from the tip to the spindle in the workpiece, and how high its tip is along it, mm.
    pub(in crate::path) fn height_at(&self, command: &AxisVector) -> (Vector, f64) {
        let direction = self.kinematics.direction(command);
        (direction, self.kinematics.tip_mm(command, &self.setup.tool_mm).dot(&direction))
    }

    /// Whether a rapid move that moves these axes of the output goes along the tool.
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
