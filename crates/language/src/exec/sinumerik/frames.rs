//! Zero offsets and programmable frames.

use super::address::Named;
use super::channel::Channel;
use super::frame_store::settable_number;
use super::gathered::Gathered;
use super::save;
use super::setup;
use super::swivel;
use super::system_write;
use crate::exec::core::fault::{Fault, bad_value, fault};
use ncfix_base::diagnostic::Code;
use ncfix_base::geometry::{Axis, AxisSet, AxisVector, Frame, Plane, Vector, about, by_solid_angles};
use ncfix_base::source::Span;
use ncfix_machine::machine::Control;
use ncfix_machine::snc::{FrameKind, FrameStatement, FrameWords};

pub(super) fn offset(channel: &mut Channel<'_>, gathered: &Gathered) -> Result<(), Fault> {
    let Some((name, span)) = &gathered.offset else { return Ok(()) };
    if channel.modal.swivelled.is_some() && *name != channel.modal.stated.offset() {
        let message = format!("{name} in a plane that CYCLE800 has swivelled");
        return Err(fault(Code::BAD_SWIVEL, *span, message, "end the swivel with CYCLE800() first"));
    }
    let order = system_write::rotation_order(channel);
    let parts = settable_number(name).and_then(|number| channel.system.frames.settable(channel.machine, number));
    let missing = parts.is_none();
    if missing && channel.strict {
        return Err(no_offset(name, *span));
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
    channel.modal.settable = settable;
    channel.modal.base = base;
    channel.modal.offset_assumed = missing;
    setup::refresh_setup(channel);
    save::push_frame(channel, FrameWords::Settable(name.clone()));
    Ok(())
}

/// `TRANS`, `ROT`, `SCALE`, `MIRROR` and their kin.
pub(super) fn frame_statement(
    channel: &mut Channel<'_>,
    gathered: &Gathered,
    (kind, additive, span): (FrameKind, bool, Span),
) -> Result<(), Fault> {
    if shares_its_block(gathered) || gathered.addresses.iter().any(|value| value.address.moves()) {
        return Err(fault(
            Code::MUST_STAND_ALONE,
            span,
            "a frame statement shares its block with nothing but axis words",
            "move the other words to another block",
        ));
    }
    let in_plane = gathered.named(Named::Rpl);
    if let Some(angle) = in_plane
        && (kind != FrameKind::Rotate || !gathered.named.is_empty())
    {
        let help = "program ROT or AROT with RPL, or with angles about axes";
        return Err(bad_value(angle.span, "RPL stands alone behind ROT or AROT", help));
    }
    let mut values = AxisVector::ZERO;
    for axis in gathered.named.iter() {
        let unit = match kind {
            FrameKind::Scale | FrameKind::Mirror => 1.0,
            FrameKind::Rotate | FrameKind::SolidAngles => 1_f64.to_radians(),
            _ if axis.is_rotary() => 1_f64.to_radians(),
            _ => channel.modal.scale(),
        };
        values[axis] = gathered.axes[axis] * unit;
        let is_space = AxisSet::XYZ.contains(axis);
        if !is_space && !matches!(kind, FrameKind::Translate | FrameKind::Coarse | FrameKind::Fine) {
            let message = format!("{axis} can be shifted, but not turned, scaled or mirrored");
            return Err(bad_value(gathered.axis_spans[axis.slot()], message, "name X, Y or Z"));
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

/// A statement that replaces the programmable frame above a swivelled plane, which the output has in the same place.
fn replace_swivelled(channel: &mut Channel<'_>, statement: &FrameStatement, span: Span) -> Result<(), Fault> {
    if matches!(statement.kind, FrameKind::Coarse | FrameKind::Fine) {
        let message = "G58 and G59 in a swivelled plane are not supported";
        return Err(fault(Code::NOT_SUPPORTED, span, message, "program the shift with TRANS or ATRANS"));
    }
    swivel::restate(channel, span)?;
    if statement.named.is_empty() && statement.in_plane_rad.is_none() {
        return Ok(());
    }
    let added = FrameStatement { additive: true, ..*statement };
    apply_statement(channel, &added, span)?;
    channel.outlet.begin_line();
    save::push_frame(channel, FrameWords::Statement(added));
    Ok(())
}

/// Puts a statement in force.
fn apply_statement(channel: &mut Channel<'_>, statement: &FrameStatement, span: Span) -> Result<(), Fault> {
    if matches!(statement.kind, FrameKind::Coarse | FrameKind::Fine) {
        shift_part(channel, statement, span)?;
    } else {
        let added = frame_of(statement, channel.modal.plane, &channel.machine.control).ok_or_else(|| {
            bad_value(span, "this statement makes no frame", "scale by factors above 0, tilt by less than 90 degrees")
        })?;
        let is_fine = channel.machine.control.fine_shift && statement.kind == FrameKind::Translate;
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
    setup::refresh_setup(channel);
    let frame = &channel.setup.frame;
    let machine = channel.machine;
    let lacking = AxisSet::XYZ.iter().find(|&axis| {
        let slot = axis.slot();
        let is_mixed = (0..3).any(|k| k != slot && frame.linear()[(slot, k)].abs() > 1e-12);
        machine.axis(axis).is_none() && is_mixed
    });
    match lacking {
        Some(axis) => {
            let message = format!("the frame turns into {axis}, which the machine lacks");
            Err(fault(Code::NO_AXIS, span, message, "check the topology in the machine file, or the program"))
        }
        None => Ok(()),
    }
}

/// `G58`, `G59`: the two parts of the programmable shift, axis by axis.
fn shift_part(channel: &mut Channel<'_>, statement: &FrameStatement, span: Span) -> Result<(), Fault> {
    if !channel.machine.control.fine_shift {
        let message = "G58 and G59 need a control that keeps a fine part of its shifts";
        let help = "set control.fine_shift = true where it does (Sinumerik MD24000)";
        return Err(fault(Code::NOT_SUPPORTED, span, message, help));
    }
    if !channel.modal.programmable.is_translation() {
        let message = "G58 and G59 on a frame that is turned, scaled or mirrored are not supported";
        return Err(fault(Code::NOT_SUPPORTED, span, message, "program the shift with TRANS or ATRANS"));
    }
    let mut offset = *channel.modal.programmable.offset();
    for axis in statement.named.iter() {
        let (fine, value) = (channel.modal.fine[axis], statement.values[axis]);
        if statement.kind == FrameKind::Fine {
            offset[axis] += value - fine;
            channel.modal.fine[axis] = value;
        } else {
            offset[axis] = value + fine;
        }
    }
    channel.modal.programmable = Frame::translation(offset);
    Ok(())
}

/// Whether a block has words that no frame statement and no pole may stand beside.
pub(super) fn shares_its_block(gathered: &Gathered) -> bool {
    gathered.center.iter().any(Option::is_some)
        || gathered.feed.is_some()
        || gathered.tool.is_some()
        || gathered.motion.is_some()
        || gathered.offset.is_some()
        || gathered.dwell.is_some()
        || !gathered.after.is_empty()
        || !gathered.before.is_empty()
        || !gathered.as_incremental.is_empty()
}

/// Refuses words of frame statements in other blocks.
pub(super) fn without_statement(gathered: &Gathered) -> Result<(), Fault> {
    match gathered.named(Named::Rpl) {
        Some(angle) => Err(bad_value(angle.span, "RPL belongs to ROT or AROT", "program them together")),
        None => Ok(()),
    }
}

/// The frame of a statement by itself; `None` where it cannot be undone.
pub(super) fn frame_of(statement: &FrameStatement, plane: Plane, control: &Control) -> Option<Frame> {
    let values = &statement.values;
    let xyz = [values[Axis::X], values[Axis::Y], values[Axis::Z]];
    let is_sound = values.0.iter().chain(&statement.in_plane_rad).all(|value| value.is_finite() && value.abs() < 1e9);
    if !is_sound {
        return None;
    }
    match statement.kind {
        FrameKind::Translate | FrameKind::Coarse | FrameKind::Fine => Some(Frame::translation(*values)),
        FrameKind::Rotate => Some(Frame::rotation(match statement.in_plane_rad {
            Some(angle_rad) => {
                let applicate = plane.axes()[2];
                about(&Vector::ith(applicate.slot(), 1.0), angle_rad)
            }
            None => control.rotation_order.matrix(xyz),
        })),
        FrameKind::SolidAngles => {
            let named = |axis: Axis| statement.named.contains(axis);
            let pair = match (named(Axis::X), named(Axis::Y), named(Axis::Z)) {
                (true, true, true) => return None,
                (_, true, true) => Axis::Y,
                (true, _, true) => Axis::Z,
                (true, _, _) => Axis::X,
                (_, true, _) => Axis::Y,
                _ => Axis::Z,
            };
            let angle = |steps: usize| xyz[(pair.slot() + steps) % 3];
            by_solid_angles(pair, angle(0), angle(1)).map(Frame::rotation)
        }
        FrameKind::Scale => {
            let factor = |axis: Axis| if statement.named.contains(axis) { values[axis] } else { 1.0 };
            let factors = [Axis::X, Axis::Y, Axis::Z].map(factor);
            let is_positive = factors.iter().all(|factor| (1e-6..1e6).contains(factor));
            if is_positive { Frame::scale(factors.into()) } else { None }
        }
        FrameKind::Mirror => {
            let is_on = |axis: &Axis| control.mirror_toggles || values[*axis] != 0.0;
            Some(Frame::mirror(statement.named.iter().filter(is_on).collect()))
        }
    }
}

/// A settable frame without value where one is needed.
pub(super) fn no_offset(name: &str, span: Span) -> Fault {
    let help = format!("add [zero_offset.{name}] there or in a file given with --setup");
    fault(Code::NO_OFFSET, span, format!("{name} has no value in the machine file"), help)
}
