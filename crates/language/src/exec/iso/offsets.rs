//! Zero offsets: G54 and related codes, G52 and G92.

use super::channel::Channel;
use super::channel::Warned;
use super::codes::{Group, name_of};
use super::forbidden;
use super::gathered::Gathered;
use super::haas_codes;
use super::modal::Modal;
use super::setup;
use super::target;
use super::text;
use super::zero_offset::System;
use crate::exec::core::fault::{Fault, bad_value, fault};
use crate::exec::core::motion_sink::MotionSink;
use crate::exec::core::settings::RunSettings;
use ncfix_base::diagnostic::Code;
use ncfix_base::geometry::AxisVector;
use ncfix_base::source::Span;
use ncfix_dialect::Language;
use ncfix_machine::machine::Machine;
use ncfix_machine::snc::{FrameWords, Kind};

/// Activates the zero offset without output.
pub(super) fn load_offset(channel: &mut Channel<'_>, span: Span) -> Result<(), Fault> {
    let (system, order) = (channel.modal.system, channel.settings.machine.control.rotation_order);
    let parts = target::offset_of(channel.settings.machine, &channel.written, system);
    channel.modal.offset_assumed = parts.is_none();
    let own = parts.unwrap_or_default().frame(order);
    let external = target::offset_of(channel.settings.machine, &channel.written, System::EXTERNAL)
        .unwrap_or_default()
        .frame(order);
    let (Some(own), Some(external)) = (own, external) else {
        let message = format!("the frame of {} cannot be undone", words_of(channel.settings.machine, system));
        return Err(fault(Code::NOT_COMPUTABLE, span, message, "check its factors"));
    };
    channel.modal.settable = external.compose(&own);
    let (machine, name) = (channel.settings.machine, system.words());
    if let Some(shown) = channel.written.shown.get(&system).cloned() {
        (channel.modal.zero, channel.modal.written_zero) = (shown.index, shown.written);
    } else {
        let own = channel.written.offsets.get(&system);
        channel.modal.written_zero =
            own.and_then(|own| channel.written.zeros.entry(machine.zero_offsets.len(), &name, own));
        channel.modal.zero = match (own, &channel.modal.written_zero) {
            (None, _) => machine.zero_index(&name),
            (Some(_), written) => written.as_ref().map(|written| written.index),
        };
    }
    setup::refresh_setup(channel);
    Ok(())
}

/// Reports an active zero offset without value: an error if it must not be assumed.
pub(super) fn check_offset(
    settings: &RunSettings<'_>,
    modal: &Modal,
    warned: &mut Warned,
    outlet: &mut MotionSink<'_>,
    span: Span,
) {
    if !modal.offset_assumed || warned.offset == Some(modal.system) {
        return;
    }
    warned.offset = Some(modal.system);
    let words = words_of(settings.machine, modal.system);
    let help = format!("add [zero_offset.\"{words}\"] there");
    // The motion continues nevertheless, so that one error is not repeated in every block.
    let (code, end) =
        if settings.requires_values { (Code::NO_OFFSET, "") } else { (Code::OFFSET_ASSUMED, "; zero is used") };
    let message = format!("{words} has no value in the machine file{end}");
    outlet.warnings.push(fault(code, span, message, help));
}

/// `G54` … `G59.3`, `G54.1 P`
pub(super) fn coordinates(channel: &mut Channel<'_>, gathered: &Gathered) -> Result<(), Fault> {
    let Some(code) = gathered.code(Group::Coordinates) else { return Ok(()) };
    let span = gathered.code_span(Group::Coordinates);
    forbidden::no_compensation(channel.language, &channel.modal, span, &name_of(code))?;
    if channel.modal.turned_zero.is_some() {
        let message = format!("{} while G254 is in force", name_of(code));
        return Err(fault(Code::FORBIDDEN_STATE, span, message, "program G255 before it, and G254 after it"));
    }
    let of_haas = haas_codes::system_of(code);
    let is_additional = matches!(code, 541 | 1540) || code == 540 && !channel.is_rs274() && p_is_of_offset(gathered);
    let system = if let Some(number) = of_haas {
        System(System::ADDITIONAL + number)
    } else if is_additional {
        match gathered.raw(b'P').map(f64::round).filter(|number| (1.0..=300.0).contains(number)) {
            Some(number) => System(System::ADDITIONAL + number as u16),
            None => {
                let help = "write for example G54.1 P1; there are at most 300";
                return Err(bad_value(span, "G54.1 needs P with the number of the offset", help));
            }
        }
    } else {
        System::of_code(code).unwrap_or(System::FIRST)
    };
    channel.modal.system = system;
    load_offset(channel, span)?;
    check_offset(&channel.settings, &channel.modal, &mut channel.warned, &mut channel.outlet, span);
    channel.push(Kind::Frame(FrameWords::Settable(words_of(channel.settings.machine, system))));
    Ok(())
}

/// The words of a zero offset in the output and in messages: `G154 P1` on a Haas.
pub(super) fn words_of(machine: &Machine, system: System) -> String {
    machine.shown_offset(&system.words())
}

/// `true` if the P of a block with G54 belongs to it: `G54 P3` is `G54.1 P3`.
fn p_is_of_offset(gathered: &Gathered) -> bool {
    gathered.has(b'P') && gathered.code(Group::Action).is_none()
}

/// G52, G92 and the codes that cancel them.
pub(super) fn axis_offsets(channel: &mut Channel<'_>, gathered: &Gathered, code: u16) -> Result<(), Fault> {
    let span = gathered.code_span(Group::Action);
    forbidden::no_compensation(channel.language, &channel.modal, span, &name_of(code))?;
    if matches!(code, 520 | 920) && gathered.axes.is_empty() {
        let message = format!("{} without axis words", name_of(code));
        return Err(bad_value(span, message, "program the axes that it applies to"));
    }
    let here = target::here(&channel.modal, &channel.standing);
    match code {
        520 if channel.is_rs274() => {
            for axis in gathered.axes.iter() {
                channel.modal.shift[axis] = target::axis_value(channel, gathered, axis)?;
            }
            channel.modal.stored_shift = channel.modal.shift;
        }
        520 => {
            for axis in gathered.axes.iter() {
                channel.modal.local[axis] = target::axis_value(channel, gathered, axis)?;
            }
        }
        920 => {
            for axis in gathered.axes.iter() {
                target::check_here(channel.settings.strict, &channel.modal, axis, gathered.span_of(axis.letter()))?;
                let value = target::axis_value(channel, gathered, axis)?;
                // The local shift of the axis is part of the position, and ends.
                let local = std::mem::take(&mut channel.modal.local[axis]);
                channel.modal.shift[axis] += here[axis] + local - value;
            }
            channel.modal.stored_shift = channel.modal.shift;
        }
        // The preset of Fanuc: each named axis returns to the coordinates of the zero offset alone, for any value.
        _ => {
            for axis in gathered.axes.iter() {
                target::axis_value(channel, gathered, axis)?;
                channel.modal.shift[axis] = 0.0;
                channel.modal.local[axis] = 0.0;
            }
        }
    }
    say_end(channel.language, &mut channel.outlet, gathered, code);
    setup::refresh_setup(channel);
    Ok(())
}

/// Emits codes that end a shift, as an earlier program may have left one active in the control: G52 with zeros, G92.1 of Fanuc.
fn say_end(language: Language, outlet: &mut MotionSink<'_>, gathered: &Gathered, code: u16) {
    let named = gathered.axes;
    if code == 920 || code == 520 && named.iter().any(|axis| gathered.raw(axis.letter()) != Some(0.0)) {
        return;
    }
    let mut text = name_of(code);
    for axis in named.iter() {
        text::append(language, &mut text, axis.letter(), 0.0);
    }
    outlet.push(Kind::Verbatim(text.into_bytes()));
}

/// G92.1, G92.2, G92.3 of RS274/NGC.
pub(super) fn shift_codes(channel: &mut Channel<'_>, gathered: &Gathered) -> Result<(), Fault> {
    let Some(code) = gathered.code(Group::Shift) else { return Ok(()) };
    forbidden::no_compensation(channel.language, &channel.modal, gathered.code_span(Group::Shift), &name_of(code))?;
    if code == 923 {
        channel.modal.shift = channel.modal.stored_shift;
    } else {
        channel.modal.shift = AxisVector::ZERO;
        // As for a shift of an earlier program.
        channel.push(Kind::Keep(if code == 921 { "G92.1" } else { "G92.2" }));
        if code == 921 {
            channel.modal.stored_shift = AxisVector::ZERO;
        }
    }
    setup::refresh_setup(channel);
    Ok(())
}
