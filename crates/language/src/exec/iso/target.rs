//! The current position of the channel, and the target of a block.

use super::channel::Channel;
use super::channel::WrittenData;
use super::codes::Group;
use super::gathered::Gathered;
use super::measure;
use super::modal::Modal;
use super::passed_axis;
use super::zero_offset::System;
use crate::exec::core::fault::Fault;
use crate::exec::core::fault::fault;
use crate::exec::core::position::unknown_start;
use crate::exec::core::rollover;
use crate::exec::core::standing::InForce;
use ncfix_base::diagnostic::Code;
use ncfix_base::geometry::Axis;
use ncfix_base::geometry::AxisSet;
use ncfix_base::geometry::AxisVector;
use ncfix_base::geometry::Frame;
use ncfix_base::geometry::FrameParts;
use ncfix_base::source::Span;
use ncfix_dialect::Language;
use ncfix_machine::machine::Machine;

/// The tool tip as in the control, in machine coordinates.
pub(super) fn tip(modal: &Modal, standing: &InForce) -> AxisVector {
    let mut tip = modal.position.command;
    tip.set_xyz(tip.xyz() + standing.setup.tool_mm);
    tip
}

/// The value of an axis word, mm or rad.
pub(super) fn axis_value(channel: &mut Channel<'_>, gathered: &Gathered, axis: Axis) -> Result<f64, Fault> {
    let value = if axis.is_rotary() {
        measure::angle(channel.settings.machine, channel.language, &mut channel.warned, gathered, axis.letter())?
    } else {
        measure::length(channel, gathered, axis.letter())?
    };
    Ok(value.unwrap_or_default())
}

/// The position for an absolute word, including its turns.
pub(super) fn absolute(
    machine: &Machine,
    modal: &Modal,
    gathered: &Gathered,
    axis: Axis,
    value: f64,
    here: f64,
) -> Result<f64, Fault> {
    let here = Some(here).filter(|_| modal.position.known.contains(axis));
    rollover::position(machine, axis, value, here, gathered.span_of(axis.letter()))
}

/// Rejects axes that the machine lacks.
pub(super) fn check_axes(
    language: Language,
    axes: AxisSet,
    machine: &Machine,
    gathered: &Gathered,
) -> Result<(), Fault> {
    if gathered.code(Group::Action) == Some(40) && language != Language::Rs274 {
        // The time of a dwell is not a position.
        return Ok(());
    }
    let axes = axes.union(passed_axis::passed_on(&machine.control, gathered));
    match gathered.axes.difference(axes).iter().next() {
        None => Ok(()),
        Some(axis) => {
            let message = format!("the machine has no axis {axis}");
            let help = "choose the right --machine, or add the axis to its file; if only the control moves it, name it in control.passed_on_axes";
            Err(fault(Code::NO_AXIS, gathered.span_of(axis.letter()), message, help))
        }
    }
}

/// The value of a zero offset; `None` if neither program nor machine file gives one.
pub(super) fn offset_of(machine: &Machine, written: &WrittenData, system: System) -> Option<FrameParts> {
    let own = written.offsets.get(&system).copied();
    own.or_else(|| machine.zero_offsets.get(&system.words()).copied())
}

/// Rejects motions that depend on an axis at a position the program has not stated.
pub(super) fn check_stated(strict: bool, modal: &Modal, axis: Axis, span: Span) -> Result<(), Fault> {
    if strict && !modal.position.known.contains(axis) {
        return Err(unknown_start(span, axis, &modal.position));
    }
    Ok(())
}

/// The current position in program coordinates.
pub(super) fn here(modal: &Modal, standing: &InForce) -> AxisVector {
    standing.setup.programmed(&modal.position.command)
}

/// The frame of a zero offset alone, including that of all systems.
pub(super) fn frame_of(machine: &Machine, written: &WrittenData, system: System) -> Frame {
    let order = machine.control.rotation_order;
    let frame =
        |system| offset_of(machine, written, system).unwrap_or_default().frame(order).unwrap_or_else(Frame::identity);
    frame(System::EXTERNAL).compose(&frame(system))
}
