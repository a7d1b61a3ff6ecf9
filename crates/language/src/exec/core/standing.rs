//! Active frame, tool length and plane, and the part of them that the control knows when it runs the output.

use std::sync::Arc;

use ncfix_base::geometry::{AxisSet, AxisVector, Frame, LINEAR_AXES};
use ncfix_machine::machine::Kinematics;
use ncfix_machine::snc::Setup;

/// The active setup.
#[derive(Debug, Default)]
pub(in crate::exec) struct InForce {
    /// The transformation between programmed positions and axis commands.
    pub(in crate::exec) setup: Arc<Setup>,
    /// The part of it that the output keeps; the same `Arc` if there is no difference.
    pub(in crate::exec) shown: Arc<Setup>,
    /// `true` if the change is not emitted yet.
    pub(in crate::exec) changed: bool,
}

/// The linear axes along which the tool length changes.
pub(in crate::exec) fn lengthened(old: &Setup, new: &Setup) -> AxisSet {
    let changes = |axis: &ncfix_base::geometry::Axis| new.tool_mm[axis.slot()] != old.tool_mm[axis.slot()];
    LINEAR_AXES.into_iter().take(3).filter(changes).collect()
}

/// The stated axes of a new frame, given those of the old frame in `known`.
pub(in crate::exec) fn known_behind(known: AxisSet, old: &Frame, new: &Frame) -> AxisSet {
    new.known_across(old.known_across(known, false), true)
}

/// Keeps the machine position when frame or tool change: under a transformation the tip position `command` follows from it.
pub(in crate::exec) fn keep_pose(old: &Setup, new: &Setup, kinematics: Option<&Kinematics>, command: &mut AxisVector) {
    let (Some(_), Some(kinematics)) = (old.transform.and(new.transform), kinematics) else { return };
    if new.tool_mm != old.tool_mm
        && let Some(pose) = kinematics.command_on_workpiece(command, &old.tool_mm)
    {
        *command = kinematics.on_workpiece(&pose, &new.tool_mm);
    }
}
