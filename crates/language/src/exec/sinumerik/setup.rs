//! Activates frame and tool.

use super::modal::Modal;
use crate::exec::core::motion_sink::MotionSink;
use crate::exec::core::standing::InForce;
use crate::exec::core::standing::{keep_pose, known_behind, lengthened};
use ncfix_base::geometry::RotationOrder;
use ncfix_base::geometry::{Axis, AxisSet};
use ncfix_machine::machine::Machine;
use std::sync::Arc;

/// Activates frame and tool. An axis along which the tool length changes is unknown until the program states it again. Whether and when a control
/// traverses the change is a setting (Sinumerik SD42940, SD42442).
pub(super) fn refresh_setup(modal: &mut Modal, standing: &mut InForce, outlet: &mut MotionSink<'_>) {
    let setup = modal.setup();
    keep_pose(&standing.setup, &setup, outlet.kinematics.as_deref(), &mut modal.position.command);
    let lost = lengthened(&standing.setup, &setup);
    modal.position.keep(modal.position.known.difference(lost));
    modal.moved_by_plane = modal.moved_by_plane.difference(lost);
    let (old, new) = (&standing.setup.frame, &setup.frame);
    if old.linear() != new.linear() {
        modal.position.keep(known_behind(modal.position.known, old, new));
        let is_other = |axis: &Axis| old.unapply_row(*axis) != new.unapply_row(*axis);
        modal.stale = modal.stale.union(AxisSet::XYZ.iter().filter(is_other).collect());
    }
    standing.setup = Arc::new(setup);
    standing.changed = true;
}

/// The order of rotation angles.
pub(super) fn rotation_order(machine: &Machine) -> RotationOrder {
    machine.control.rotation_order
}
