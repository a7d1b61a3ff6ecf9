//! Puts frame and tool in force.

use super::channel::Channel;
use super::modal::initial_zero_offset;
use super::save;
use super::transform;
use crate::exec::core::options::Options;
use crate::exec::core::standing::known_behind;
use ncfix_base::geometry::{Axis, AxisSet, Frame, LINEAR_AXES};
use ncfix_dialect::CodeTable;
use ncfix_machine::machine::Machine;
use std::sync::Arc;

/// Puts frame and tool in force. An axis along which the tool length changes is taken as unknown until the program states it
/// again: how and when a control traverses the change is a setting of the control (Sinumerik SD42940, SD42442).
pub(super) fn refresh_setup(channel: &mut Channel<'_>) {
    let setup = channel.modal.setup();
    transform::keep_pose(channel, &setup);
    for axis in LINEAR_AXES.into_iter().take(3) {
        if setup.tool_mm[axis.slot()] != channel.setup.tool_mm[axis.slot()] {
            channel.modal.known.remove(axis);
            channel.modal.moved_by_plane.remove(axis);
        }
    }
    let (old, new) = (&channel.setup.frame, &setup.frame);
    if old.linear() != new.linear() {
        channel.modal.known = known_behind(channel.modal.known, old, new);
        let is_other = |axis: &Axis| old.unapply_row(*axis) != new.unapply_row(*axis);
        channel.modal.stale = channel.modal.stale.union(AxisSet::XYZ.iter().filter(is_other).collect());
    }
    channel.setup = Arc::new(setup);
    channel.setup_changed = true;
}

/// A channel as it is when a program starts.
pub(super) fn begin<'a>(machine: &'a Machine, options: &Options, codes: &'static CodeTable) -> Channel<'a> {
    let mut channel = Channel::new(machine, options, codes);
    let order = machine.control.rotation_order;
    channel.modal.base = channel.system.frames.base(order).unwrap_or_else(Frame::identity);
    if let Some(offset) = machine.zero_offsets.get(initial_zero_offset(machine)) {
        channel.modal.settable = offset.frame(order).unwrap_or_else(Frame::identity);
    }
    refresh_setup(&mut channel);
    save::note_initial_codes(&mut channel);
    channel.modal.programmed = channel.setup.programmed(&channel.modal.command);
    channel
}
