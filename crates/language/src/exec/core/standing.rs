//! Frame, tool length and plane in force, and what of them the control that runs the output knows.

use std::sync::Arc;

use ncfix_base::geometry::{AxisSet, AxisVector, Frame, LINEAR_AXES};
use ncfix_machine::machine::Kinematics;
use ncfix_machine::snc::Setup;

/// What is in force.
#[derive(Debug, Default)]
pub(in crate::exec) struct InForce {
    /// All that lies between programmed positions and axis commands.
    pub(in crate::exec) setup: Arc<Setup>,
    /// The part of it that the output keeps; the same one where there is nothing else.
    pub(in crate::exec) shown: Arc<Setup>,
    /// Whether the output has not been told yet.
    pub(in crate::exec) changed: bool,
}

/// The linear axes along which another tool length is in force.
pub(in crate::exec) fn lengthened(old: &Setup, new: &Setup) -> AxisSet {
    let changes = |axis: &ncfix_base::geometry::Axis| new.tool_mm[axis.slot()] != old.tool_mm[axis.slot()];
    LINEAR_AXES.into_iter().take(3).filter(changes).collect()
}

/// Which axes of a new frame are stated, where those in `known` of an old one are.
pub(in crate::exec) fn known_behind(known: AxisSet, old: &Frame, new: &Frame) -> AxisSet {
    new.known_across(old.known_across(known, false), true)
}

/// The machine stands where it stood when frame or tool change: under a transformation the place of the tip, `command`, follows from it.
pub(in crate::exec) fn keep_pose(old: &Setup, new: &Setup, kinematics: Option<&Kinematics>, command: &mut AxisVector) {
    let (Some(_), Some(kinematics)) = (old.transform.and(new.transform), kinematics) else { return };
    if new.tool_mm != old.tool_mm
        && let Some(pose) = kinematics.command_on_workpiece(command, &old.tool_mm)
    {
        *command = kinematics.on_workpiece(&pose, &new.tool_mm);
    }
}
