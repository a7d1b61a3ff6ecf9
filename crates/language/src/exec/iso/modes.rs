//! Modal codes: plane, units, dimensions.

use super::channel::Channel;
use super::channel::Cycles;
use super::codes::G80;
use super::codes::{Group, name_of};
use super::direction;
use super::forbidden;
use super::gathered::Gathered;
use super::modal::Modal;
use super::setup;
use super::text;
use crate::exec::core::fault::{Fault, fault};
use ncfix_base::diagnostic::Code;
use ncfix_base::geometry::Plane;
use ncfix_dialect::Language;
use ncfix_machine::machine::Machine;
use ncfix_machine::snc::Kind;

pub(super) fn plane(channel: &mut Channel<'_>, gathered: &Gathered) -> Result<(), Fault> {
    let Some(code) = gathered.code(Group::Plane) else { return Ok(()) };
    let Some(plane) = u8::try_from(code / 10).ok().and_then(Plane::from_number) else { return Ok(()) };
    if plane != channel.modal.modes.plane {
        if channel.is_rs274() {
            forbidden::no_compensation(
                channel.language,
                &channel.modal,
                gathered.code_span(Group::Plane),
                "another plane",
            )?;
        }
        channel.modal.modes.plane = plane;
        setup::refresh_setup(channel);
    }
    channel.push(Kind::Keep(match plane.number() {
        17 => "G17",
        18 => "G18",
        _ => "G19",
    }));
    Ok(())
}

pub(super) fn units(
    machine: &Machine,
    language: Language,
    modal: &mut Modal,
    gathered: &Gathered,
) -> Result<(), Fault> {
    let Some(code) = gathered.code(Group::Units) else { return Ok(()) };
    if matches!(code, 700 | 710) && gathered.has_any(b"DEPQ") {
        let message = format!("{} (cycle of a lathe) is not supported", name_of(code));
        let help = "program its moves one by one; without other words it selects the unit, as G20 and G21 do";
        return Err(fault(Code::NOT_SUPPORTED, gathered.code_span(Group::Units), message, help));
    }
    modal.modes.inch = matches!(code, 200 | 700);
    match machine.control.output_inch {
        Some(inch) if inch != modal.modes.inch && language != Language::Rs274 => {
            let message = "the program is in inches in one part and in millimeters in another";
            let help =
                "correct them as two programs: the control interprets tool and zero offsets in the unit in force";
            Err(fault(Code::MIXED_UNITS, gathered.code_span(Group::Units), message, help))
        }
        _ => Ok(()),
    }
}

pub(super) fn distance(modal: &mut Modal, gathered: &Gathered) {
    if let Some(code) = gathered.code(Group::Distance) {
        modal.modes.incremental = code == 910;
    }
    if let Some(code) = gathered.code(Group::ArcDistance) {
        modal.codes.set(Group::ArcDistance, code);
    }
}

pub(super) fn retract(modal: &mut Modal, gathered: &Gathered) {
    if let Some(code) = gathered.code(Group::Retract) {
        modal.codes.set(Group::Retract, code);
    }
}

/// The motion code of a block, in tenths. A Fanuc ends its cycles with any other motion, and G80 restores the motion mode before them.
pub(super) fn code_of_motion(language: Language, cycles: &Cycles, gathered: &Gathered) -> Option<u16> {
    let code = gathered.code(Group::Motion);
    if language == Language::Rs274 {
        return code;
    }
    code.or_else(|| match gathered.code(Group::Cycle) {
        Some(G80) => Some(cycles.line),
        cycle => cycle,
    })
}

/// Restores the path control of the program after a cycle, or drops it if the block names one.
pub(super) fn leave_exact_stops(channel: &mut Channel<'_>, is_named: bool) {
    if std::mem::take(&mut channel.cycles.is_exact) && !is_named {
        restore_path_control(channel);
    }
}

/// Emits the path control of the program.
pub(super) fn restore_path_control(channel: &mut Channel<'_>) {
    match (channel.modal.code(Group::Control), channel.modal.path_tolerance_mm) {
        (611, _) => channel.push(Kind::Keep("G61.1")),
        (_, [None, None]) => channel.push(Kind::Keep("G64")),
        (_, tolerance_mm) => {
            let text = blending(channel.settings.machine, channel.language, tolerance_mm);
            channel.push(Kind::Verbatim(text.into_bytes()));
        }
    }
}

/// `G64` with its P and Q.
pub(super) fn blending(machine: &Machine, language: Language, tolerance_mm: [Option<f64>; 2]) -> String {
    let mut text = "G64".to_owned();
    for (letter, value) in b"PQ".iter().zip(tolerance_mm) {
        if let Some(value) = value {
            text::append_length(machine, language, &mut text, *letter, value);
        }
    }
    text
}

/// The motion mode of a block that names a motion code or has words for the active one.
pub(super) fn motion_of(language: Language, modal: &Modal, cycles: &Cycles, gathered: &Gathered) -> Option<u16> {
    if let Some(code) = code_of_motion(language, cycles, gathered) {
        return Some(code);
    }
    let is_arc = matches!(modal.modes.motion, 20 | 30) || direction::has_directions(modal);
    let moves = !gathered.axes.is_empty() || gathered.has_any(b"@^") || is_arc && gathered.has_any(b"IJKR");
    moves.then_some(modal.modes.motion)
}
