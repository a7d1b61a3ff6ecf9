//! Puts frame and tool in force.

use super::channel::Channel;
use super::motion::known_behind;
use super::offsets;
use super::tip;
use crate::exec::core::options::Options;
use crate::exec::core::outlet::HasOutlet;
use ncfix_base::geometry::{AxisSet, LINEAR_AXES};
use ncfix_base::source::Span;
use ncfix_dialect::Dialect;
use ncfix_machine::machine::Machine;
use std::sync::Arc;

/// Puts frame and tool in force. Of a Fanuc an axis along which the tool length changes is taken as unknown until the program
/// states it again: whether the control moves it at once is a parameter.
pub(super) fn refresh_setup(channel: &mut Channel<'_>) {
    let (setup, shown) = (channel.modal.setup(), channel.modal.shown());
    tip::keep_pose(channel, &setup);
    for axis in LINEAR_AXES.into_iter().take(3) {
        if !channel.is_rs274() && setup.tool_mm[axis.slot()] != channel.setup.tool_mm[axis.slot()] {
            channel.modal.known.remove(axis);
        }
    }
    let (old, new) = (&channel.setup.frame, &setup.frame);
    if old.linear() != new.linear() {
        channel.modal.known = known_behind(channel.modal.known, old, new);
    }
    if *channel.shown != shown {
        channel.shown = Arc::new(shown);
        channel.setup_changed = true;
    }
    channel.setup = if setup == *channel.shown { Arc::clone(&channel.shown) } else { Arc::new(setup) };
}

/// A channel as it is when a program starts.
pub(super) fn begin<'a>(machine: &'a Machine, options: &Options, dialect: &'static Dialect) -> Channel<'a> {
    let mut channel = Channel::new(machine, options, dialect);
    // G54 is in force when a program starts.
    if let Err(found) = offsets::load_offset(&mut channel, Span::default()) {
        channel.outlet.warnings.push(found);
    }
    channel.modal.known = if options.start.is_some() { channel.axes } else { AxisSet::EMPTY };
    channel
}
