//! Activates frame and tool.

use super::channel::Channel;
use crate::exec::core::fault::{Fault, bad_value};
use crate::exec::core::motion_sink::MotionSink;
use crate::exec::core::options::Options;
use crate::exec::core::standing::InForce;
use crate::exec::core::standing::{known_behind, lengthened};
use ncfix_base::geometry::{AxisSet, Frame, Vector};
use ncfix_dialect::CodeTable;
use ncfix_machine::machine::{Kinematics, Machine};
use ncfix_machine::snc::{Kind, Setup};
use std::sync::Arc;

/// Activates frame and tool. The position along an axis whose tool length changes is no longer stated.
pub(super) fn refresh_setup(channel: &mut Channel<'_>) -> Result<(), Fault> {
    let span = channel.outlet.origin.span;
    let flat = || bad_value(span, "this frame cannot be undone", "check the factors of the zero offset");
    let frames = &channel.modal.frames;
    let stored = frames.shown(&channel.settings.machine.control).ok_or_else(flat)?;
    let below = stored.compose(&frames.programmed(&channel.settings.machine.control.grundig).ok_or_else(flat)?);
    let tool = &channel.modal.tool;
    let mut tool_mm = Vector::zeros();
    let length = tool.length_mm + channel.modal.allowance_mm[0];
    if length != 0.0 {
        tool_mm[channel.modal.modes.plane.axes()[2].slot()] =
            if channel.modal.tool_reversed { length } else { -length };
    }
    let assumed = frames.assumed || tool.assumed;
    let plane = channel.modal.modes.plane;
    let transform = channel.modal.turning;
    let zero = frames.settable.as_deref().and_then(|name| channel.settings.machine.zero_index(name));
    let frame = match &mut channel.modal.tilted {
        None => below,
        Some(tilted) => {
            let kinematics = Kinematics::of_head(channel.settings.machine, channel.modal.tool.head);
            tilted.frame(&kinematics, &below, &tool_mm).ok_or_else(|| {
                bad_value(span, "the linear axes cannot place the tool in the plane of G7", "check the topology")
            })?
        }
    };
    let head = channel.modal.tool.head;
    let setup = Setup { frame, tool_mm, plane, transform, assumed, zero, written_zero: None, head };
    let lost = lengthened(&channel.standing.setup, &setup);
    if !lost.is_empty() {
        // The length in the control may differ: no move may rely on the tip position for this length.
        channel.modal.position.keep(channel.modal.position.known.difference(lost));
        channel.outlet.push(Kind::Lost(lost));
    }
    if setup.frame.linear() != channel.standing.setup.frame.linear() {
        channel.modal.position.known =
            known_behind(channel.modal.position.known, &channel.standing.setup.frame, &setup.frame);
    }
    let shown = Setup { frame: stored, ..setup.clone() };
    if shown != *channel.standing.shown {
        channel.standing.shown = Arc::new(shown);
        channel.standing.changed = true;
    }
    if setup != *channel.standing.setup {
        channel.standing.setup = Arc::new(setup);
    }
    Ok(())
}

/// Emits the active setup, if it has changed.
pub(super) fn show_setup(standing: &mut InForce, outlet: &mut MotionSink<'_>) {
    if std::mem::take(&mut standing.changed) {
        outlet.push(Kind::Setup(Arc::clone(&standing.shown)));
    }
}

/// Converts axes of the program to axes of the output.
pub(super) fn shown_axes(standing: &InForce, axes: AxisSet, moving: bool) -> AxisSet {
    let (own, shown): (&Frame, &Frame) = (&standing.setup.frame, &standing.shown.frame);
    if own.is_translation() && shown.is_translation() {
        return axes;
    }
    if moving {
        return shown.inverse().mixed_with(own.mixed_with(axes));
    }
    shown.known_across(own.known_across(axes, false), true)
}

/// A channel in its state at the start of a program.
pub(super) fn begin<'a>(machine: &'a Machine, options: &Options, codes: &'static CodeTable) -> Channel<'a> {
    let mut channel = Channel::new(machine, options, codes);
    // The machine file rejects offsets without inverse.
    let refreshed = refresh_setup(&mut channel);
    channel.outlet.warnings.extend(refreshed.err());
    channel
}
