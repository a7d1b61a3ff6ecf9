//! Puts frame and tool in force.

use super::channel::Channel;
use crate::exec::core::standing::{keep_pose, known_behind, lengthened};
use ncfix_base::geometry::RotationOrder;
use ncfix_base::geometry::{Axis, AxisSet};
use std::sync::Arc;

/// Puts frame and tool in force. An axis along which the tool length changes is taken as unknown until the program states it
/// again: how and when a control traverses the change is a setting of the control (Sinumerik SD42940, SD42442).
pub(super) fn refresh_setup(channel: &mut Channel<'_>) {
    let setup = channel.modal.setup();
    keep_pose(&channel.standing.setup, &setup, channel.outlet.kinematics.as_deref(), &mut channel.modal.command);
    let lost = lengthened(&channel.standing.setup, &setup);
    channel.modal.known = channel.modal.known.difference(lost);
    channel.modal.moved_by_plane = channel.modal.moved_by_plane.difference(lost);
    let (old, new) = (&channel.standing.setup.frame, &setup.frame);
    if old.linear() != new.linear() {
        channel.modal.known = known_behind(channel.modal.known, old, new);
        let is_other = |axis: &Axis| old.unapply_row(*axis) != new.unapply_row(*axis);
        channel.modal.stale = channel.modal.stale.union(AxisSet::XYZ.iter().filter(is_other).collect());
    }
    channel.standing.setup = Arc::new(setup);
    channel.standing.changed = true;
}

/// In which order the angles of a rotation turn.
pub(super) fn rotation_order(channel: &Channel<'_>) -> RotationOrder {
    channel.settings.machine.control.rotation_order
}
