//! Activates frame and tool.

use super::channel::Channel;
use crate::exec::core::fault::Fault;
use crate::exec::core::fault::fault;
use crate::exec::core::standing::{keep_pose, known_behind, lengthened};
use ncfix_base::diagnostic::Code;
use ncfix_base::geometry::Vector;
use ncfix_base::source::Span;
use std::sync::Arc;

/// Activates frame and tool. On a Fanuc, an axis along which the tool length changes is unknown until the program states it again: whether the
/// control moves it immediately is a parameter.
pub(super) fn refresh_setup(channel: &mut Channel<'_>) {
    let (setup, shown) = (channel.modal.setup(), channel.modal.shown());
    keep_pose(
        &channel.standing.setup,
        &setup,
        channel.outlet.kinematics.as_deref(),
        &mut channel.modal.position.command,
    );
    if !channel.is_rs274() {
        let has_parameter = !channel.settings.machine.control.iso.is_haas();
        channel.modal.position.forget_by_length(lengthened(&channel.standing.setup, &setup), has_parameter);
    }
    let (old, new) = (&channel.standing.setup.frame, &setup.frame);
    if old.linear() != new.linear() {
        channel.modal.position.keep(known_behind(channel.modal.position.known, old, new));
    }
    if *channel.standing.shown != shown {
        channel.standing.shown = Arc::new(shown);
        channel.standing.changed = true;
    }
    channel.standing.setup =
        if setup == *channel.standing.shown { Arc::clone(&channel.standing.shown) } else { Arc::new(setup) };
}

/// Activates a length.
pub(super) fn put_length(channel: &mut Channel<'_>, length_mm: Vector, assumed: bool) {
    channel.modal.tool.length_mm = length_mm;
    channel.modal.tool.assumed = assumed;
    refresh_setup(channel);
}

/// The control rotates the length with the coordinates, while the tool keeps its orientation.
pub(super) fn turned_length(span: Span) -> Fault {
    let message = "tool length compensation and a rotation in space (G68 I J K) together";
    fault(Code::NOT_SUPPORTED, span, message, "use G68.2 and G53.1, or program without G43")
}
