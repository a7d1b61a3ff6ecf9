//! Zero offsets and programmable frames.

use super::address::Named;
use super::channel::Channel;
use super::frame_store;
use super::frame_store::settable_number;
use super::gathered;
use super::gathered::Gathered;
use super::modal::Modal;
use super::save;
use super::setup;
use crate::exec::core::fault::{Fault, bad_value, fault};
use ncfix_base::diagnostic::Code;
use ncfix_base::geometry::{AxisSet, AxisVector, Frame};
use ncfix_base::source::Span;
use ncfix_machine::machine::Machine;
use ncfix_machine::snc::{FrameKind, FrameStatement, FrameWords};

pub(super) fn offset(channel: &mut Channel<'_>, gathered: &Gathered) -> Result<(), Fault> {
    let Some((name, span)) = &gathered.offset else { return Ok(()) };
    if let Some(swivelled) = channel.modal.swivelled.as_ref().filter(|_| *name != channel.modal.stated.offset()) {
        let message = format!("{name} in a plane that {} has tilted", swivelled.source());
        return Err(fault(Code::BAD_SWIVEL, *span, message, swivelled.way_out()));
    }
    let order = setup::rotation_order(channel.settings.machine);
    let parts =
        settable_number(name).and_then(|number| channel.system.frames.settable(channel.settings.machine, number));
    let missing = parts.is_none();
    if missing && channel.settings.requires_values {
        return Err(frame_store::no_offset(name, *span));
    }
    if missing {
        channel.outlet.warnings.push(fault(
            Code::OFFSET_ASSUMED,
            *span,
            format!("{name} has no value in the machine file; zero is used"),
            format!("add [zero_offset.{name}] there"),
        ));
    }
    let settable = parts.unwrap_or_default().frame(order);
    let frames = &mut channel.system.frames;
    frames.activate_bases();
    let (Some(settable), Some(base)) = (settable, frames.base(order)) else {
        return Err(fault(
            Code::NOT_COMPUTABLE,
            *span,
            format!("the frame of {name} cannot be undone"),
            "check its factors",
        ));
    };
    let own = settable_number(name).and_then(|number| frames.settable.get(&number));
    let first = channel.settings.machine.zero_offsets.len();
    channel.modal.written_zero = own.and_then(|own| frames.zeros.entry(first, name, own));
    channel.modal.zero = match (own, &channel.modal.written_zero) {
        (None, _) => channel.settings.machine.zero_index(name),
        (Some(_), written) => written.as_ref().map(|written| written.index),
    };
    channel.modal.settable = settable;
    channel.modal.base = base;
    channel.modal.offset_assumed = missing;
    setup::refresh_setup(&mut channel.modal, &mut channel.standing, &mut channel.outlet);
    save::push_frame(channel, FrameWords::Settable(name.clone()));
    Ok(())
}

/// Executes `TRANS`, `ROT`, `SCALE`, `MIRROR` and related statements.
pub(super) fn frame_statement(
    channel: &mut Channel<'_>,
    gathered: &Gathered,
    (kind, additive, span): (FrameKind, bool, Span),
) -> Result<(), Fault> {
    if gathered::shares_its_block(gathered) || gathered.addresses.iter().any(|value| value.address.moves()) {
        return Err(fault(
            Code::MUST_STAND_ALONE,
            span,
            "a frame statement allows only axis words in its block",
            "move the other words to another block",
        ));
    }
    let in_plane = gathered.named(Named::Rpl);
    if let Some(angle) = in_plane
        && (kind != FrameKind::Rotate || !gathered.named.is_empty())
    {
        let help = "program ROT or AROT with RPL, or with angles about axes";
        return Err(bad_value(angle.span, "RPL must be the only word after ROT or AROT", help));
    }
    let mut values = AxisVector::ZERO;
    for axis in gathered.named.iter() {
        let unit = match kind {
            FrameKind::Scale | FrameKind::Mirror => 1.0,
            FrameKind::Rotate | FrameKind::SolidAngles => 1_f64.to_radians(),
            _ if axis.is_rotary() => 1_f64.to_radians(),
            _ => channel.modal.modes.scale(),
        };
        values[axis] = gathered.axes[axis] * unit;
        let is_space = AxisSet::XYZ.contains(axis);
        if !is_space && !matches!(kind, FrameKind::Translate | FrameKind::Coarse | FrameKind::Fine) {
            let message = format!("{axis} can be shifted, but not rotated, scaled or mirrored");
            return Err(bad_value(gathered.axis_spans[axis.slot()], message, "program X, Y or Z"));
        }
    }
    let in_plane_rad = in_plane.map(|angle| angle.value.to_radians());
    let statement = FrameStatement { kind, additive, values, named: gathered.named, in_plane_rad };
    if channel.modal.swivelled.is_some() && !additive {
        return replace_swivelled(channel, &statement, span);
    }
    apply_statement(channel, &statement, span)?;
    save::push_frame(channel, FrameWords::Statement(statement));
    Ok(())
}

/// Replaces the programmable frame above a swivelled plane, which the output has in the same place.
fn replace_swivelled(channel: &mut Channel<'_>, statement: &FrameStatement, span: Span) -> Result<(), Fault> {
    if matches!(statement.kind, FrameKind::Coarse | FrameKind::Fine) {
        let message = "G58 and G59 in a tilted plane are not supported";
        return Err(fault(Code::NOT_SUPPORTED, span, message, "program the shift with TRANS or ATRANS"));
    }
    save::restate(channel, span)?;
    if statement.named.is_empty() && statement.in_plane_rad.is_none() {
        return Ok(());
    }
    let added = FrameStatement { additive: true, ..*statement };
    apply_statement(channel, &added, span)?;
    channel.outlet.begin_line();
    save::push_frame(channel, FrameWords::Statement(added));
    Ok(())
}

/// Activates a statement.
fn apply_statement(channel: &mut Channel<'_>, statement: &FrameStatement, span: Span) -> Result<(), Fault> {
    if matches!(statement.kind, FrameKind::Coarse | FrameKind::Fine) {
        shift_part(channel.settings.machine, &mut channel.modal, statement, span)?;
    } else {
        let added = frame_store::frame_of(statement, channel.modal.modes.plane, &channel.settings.machine.control)
            .ok_or_else(|| {
                bad_value(
                    span,
                    "this statement does not define a valid frame",
                    "scale by factors above 0, tilt by less than 90 degrees",
                )
            })?;
        let is_fine = channel.settings.machine.control.fine_shift && statement.kind == FrameKind::Translate;
        if !statement.additive {
            channel.modal.fine = AxisVector::ZERO;
            channel.modal.programmable = added;
        } else {
            if is_fine {
                channel.modal.fine = channel.modal.fine + *added.offset();
            }
            channel.modal.programmable = channel.modal.programmable.compose(&added);
        }
    }
    setup::refresh_setup(&mut channel.modal, &mut channel.standing, &mut channel.outlet);
    let frame = &channel.standing.setup.frame;
    let machine = channel.settings.machine;
    let lacking = AxisSet::XYZ.iter().find(|&axis| {
        let slot = axis.slot();
        let is_mixed = (0..3).any(|k| k != slot && frame.linear()[(slot, k)].abs() > 1e-12);
        machine.axis(axis).is_none() && is_mixed
    });
    match lacking {
        Some(axis) => {
            let message = format!("the frame rotates into {axis}, which the machine does not have");
            Err(fault(Code::NO_AXIS, span, message, "check the topology in the machine file, or the program"))
        }
        None => Ok(()),
    }
}

/// `G58`, `G59`: the two parts of the programmable shift, axis by axis.
fn shift_part(machine: &Machine, modal: &mut Modal, statement: &FrameStatement, span: Span) -> Result<(), Fault> {
    if !machine.control.fine_shift {
        let message = "G58 and G59 need a control with fine shifts";
        let help = "set control.fine_shift = true if the control has them (Sinumerik MD24000)";
        return Err(fault(Code::NOT_SUPPORTED, span, message, help));
    }
    if !modal.programmable.is_translation() {
        let message = "G58 and G59 on a frame that is rotated, scaled or mirrored are not supported";
        return Err(fault(Code::NOT_SUPPORTED, span, message, "program the shift with TRANS or ATRANS"));
    }
    let mut offset = *modal.programmable.offset();
    for axis in statement.named.iter() {
        let (fine, value) = (modal.fine[axis], statement.values[axis]);
        if statement.kind == FrameKind::Fine {
            offset[axis] += value - fine;
            modal.fine[axis] = value;
        } else {
            offset[axis] = value + fine;
        }
    }
    modal.programmable = Frame::translation(offset);
    Ok(())
}

/// Rejects words of frame statements in other blocks.
pub(super) fn without_statement(gathered: &Gathered) -> Result<(), Fault> {
    match gathered.named(Named::Rpl) {
        Some(angle) => Err(bad_value(angle.span, "RPL belongs to ROT or AROT", "program them together")),
        None => Ok(()),
    }
}
