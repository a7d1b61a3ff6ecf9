//! Blocks that name one axis of the plane directly after the beginning or end of a rotation, scaling or mirror.
//!
//! The motion of the other axis depends on a parameter of the control (Fanuc 11600, bit 5): to its previously programmed value in the new
//! coordinates, or none. Once the program has stated both axes, both cases are equal.

use super::channel::Channel;
use super::channel::Doubt;
use super::channel::Special;
use super::frames::Transforms;
use super::gathered::Gathered;
use super::modal::Modal;
use super::target;
use crate::exec::core::fault::{Fault, fault};
use crate::exec::core::standing::InForce;
use ncfix_base::diagnostic::Code;
use ncfix_base::geometry::{Axis, AxisSet, AxisVector};
use ncfix_base::source::Span;
use ncfix_machine::machine::OneAxis;

/// Values nearer to each other than this are equal, mm.
const SAME_MM: f64 = 1e-6;

/// Records a change of rotation, scaling or mirroring; `before` is the previous state, `here` the tool position in it.
pub(super) fn note_turn(
    modal: &Modal,
    special: &mut Special,
    standing: &InForce,
    before: &Transforms,
    here: &AxisVector,
    known: AxisSet,
) {
    let now = target::here(modal, standing);
    let transforms = &modal.transforms;
    let is_in_space = before.is_in_space() || transforms.is_in_space();
    let plane: AxisSet = modal.modes.plane.axes().into_iter().take(2).collect();
    let group = if is_in_space { AxisSet::XYZ } else { plane };
    let mut values = *here;
    if let Some(old) = &special.doubt {
        old.open.iter().for_each(|axis| values[axis] = old.values[axis]);
    }
    let is_tilted = before.tilt().is_some() || transforms.tilt().is_some();
    let differs = |axis: &Axis| known.contains(*axis) && (values[*axis] - now[*axis]).abs() > SAME_MM;
    let open: AxisSet = group.iter().filter(differs).collect();
    let has_ended = transforms.is_empty();
    special.doubt = (!is_tilted && !open.is_empty()).then_some(Doubt { values, open, group, has_ended });
}

/// Records motion to positions outside program coordinates.
pub(super) fn settle_axes(special: &mut Special, named: AxisSet) {
    if let Some(doubt) = &mut special.doubt {
        doubt.open = doubt.open.difference(named);
        if doubt.open.is_empty() {
            special.doubt = None;
        }
    }
}

/// Values of axes that a block with the axes `named` moves without naming them.
pub(super) fn other_axes(
    channel: &mut Channel<'_>,
    gathered: &Gathered,
    named: AxisSet,
) -> Result<Option<(AxisSet, AxisVector)>, Fault> {
    let Some(mut doubt) = channel.special.doubt.filter(|doubt| !doubt.group.intersection(named).is_empty()) else {
        return Ok(None);
    };
    let moved = doubt.group.intersection(named);
    let span = moved.iter().next().map_or(gathered.span, |axis| gathered.span_of(axis.letter()));
    let setting = channel.settings.machine.control.iso.one_axis_in_rotation;
    if channel.modal.modes.incremental {
        if !doubt.has_ended {
            // The path is identical under both rules: the tool rotates about its current position.
            for axis in moved.iter() {
                doubt.values[axis] += target::axis_value(channel, gathered, axis)?;
            }
            channel.special.doubt = Some(doubt);
            return Ok(None);
        }
        if setting == Some(OneAxis::Place) {
            return Ok(None);
        }
        let message =
            "an incremental motion directly after the end of a rotation, scaling or mirror: its start is not defined";
        return Err(in_doubt(span, message, "program all axes of the plane with G90 first"));
    }
    let open = doubt.open.difference(named);
    let polar_lacks = channel.special.polar.is_some() && !doubt.group.difference(named).is_empty();
    if open.is_empty() && !polar_lacks {
        channel.special.doubt = None;
        return Ok(None);
    }
    match setting {
        Some(OneAxis::Place) => {}
        Some(OneAxis::Value) if !doubt.has_ended && !polar_lacks => {
            channel.special.doubt = None;
            return Ok(Some((open, doubt.values)));
        }
        _ => {
            let other = open.iter().next().unwrap_or(Axis::X);
            let message = format!(
                "{other} is not programmed in the first block after a rotation, scaling or mirror: whether it \
                 moves depends on a parameter of the control ({other} {:.3} or {:.3})",
                doubt.values[other],
                target::here(&channel.modal, &channel.standing)[other]
            );
            let help = format!(
                "program {other} too, or set control.one_axis_in_rotation to the behavior of the control (Fanuc parameter 11600, bit 5)"
            );
            return Err(in_doubt(span, message, help));
        }
    }
    channel.special.doubt = None;
    Ok(None)
}

fn in_doubt(span: Span, message: impl Into<String>, help: impl Into<String>) -> Fault {
    fault(Code::AXIS_IN_DOUBT, span, message, help)
}
