//! SAVE: the modal state of the caller is restored at the return, and the output states it.

use super::channel::Channel;
use super::modal::Modal;
use super::setup;
use super::stated::MAX_STATEMENTS;
use super::stated::NO_FRAME;
use super::stated::NOT_MODAL;
use crate::exec::core::fault::Fault;
use crate::exec::core::fault::fault;
use crate::exec::core::settings::RunSettings;
use ncfix_base::diagnostic::Code;
use ncfix_base::geometry::Frame;
use ncfix_base::geometry::{AxisSet, AxisVector, Plane};
use ncfix_base::source::Span;
use ncfix_dialect::CodeEffect;
use ncfix_dialect::CodeTable;
use ncfix_machine::snc::{FrameKind, FrameStatement, FrameWords, Kind};

/// Records the codes that are active at the start according to the machine file.
pub(super) fn note_initial_codes(settings: &RunSettings<'_>, codes: &'static CodeTable, modal: &mut Modal) {
    let machine = settings.machine;
    let rows = machine.control.initial_codes.iter().filter_map(|word| codes.word(&word.to_ascii_uppercase()));
    for row in rows.filter(|row| row.effect == CodeEffect::Keep && !NOT_MODAL.contains(&row.group)) {
        modal.stated.codes.set(row.group, row.name);
    }
}

/// Passes a code through and records it as active.
pub(super) fn keep(channel: &mut Channel<'_>, word: &'static str) {
    if let Some(row) = channel.codes.word(word).filter(|row| !NOT_MODAL.contains(&row.group)) {
        channel.modal.stated.codes.set(row.group, word);
    }
    channel.push(Kind::Keep(word));
}

/// Passes a zero offset or frame through and records it as active.
pub(super) fn push_frame(channel: &mut Channel<'_>, words: FrameWords) {
    channel.modal.stated.add_frame(&words, channel.modal.modes.plane);
    channel.push(Kind::Frame(words));
}

/// Restores the modal state of a caller: codes, plane, units, frames. Positions, tool and feed stay.
pub(super) fn restore(channel: &mut Channel<'_>, saved: Modal) {
    let left = std::mem::replace(&mut channel.modal, saved);
    channel.modal.keep_position_of(&left);
    let codes = channel.modal.stated.codes.other_than(&left.stated.codes);
    if !codes.is_empty() {
        channel.outlet.begin_line();
        codes.into_iter().for_each(|word| channel.push(Kind::Keep(word)));
    }
    if left.stated.offset != channel.modal.stated.offset {
        channel.outlet.begin_line();
        channel.push(Kind::Frame(FrameWords::Settable(channel.modal.stated.offset.clone())));
    }
    let (before, after) = (&left.stated.frame, channel.modal.stated.frame.clone());
    let assigned = channel.modal.stated.assigned.clone();
    let is_other = *before != after || left.stated.assigned != assigned;
    let is_same_settable = left.settable == channel.modal.settable;
    let is_said = (is_other || left.programmable == channel.modal.programmable)
        && (is_same_settable || left.stated.offset != channel.modal.stated.offset);
    let is_whole = after.len() < MAX_STATEMENTS && before.len() < MAX_STATEMENTS;
    let in_plane = |(statement, plane): &(FrameStatement, Plane)| {
        let needs_plane = statement.in_plane_rad.is_some() || statement.kind == FrameKind::SolidAngles;
        !needs_plane || *plane == channel.modal.modes.plane
    };
    if !is_said || !is_whole || !after.iter().all(in_plane) || left.base != channel.modal.base {
        let message = "SAVE restores a frame at the end of this program that cannot be written as statements";
        let help = "program the frame again after the call, with TRANS, ROT, SCALE, MIRROR in the plane in force";
        channel.outlet.warnings.push(fault(Code::NOT_SUPPORTED, channel.outlet.origin.span, message, help));
    } else if is_other {
        if let Some(text) = assigned {
            channel.outlet.begin_line();
            channel.push(Kind::Verbatim(text));
        } else if after.is_empty() {
            channel.outlet.begin_line();
            channel.push(Kind::Frame(FrameWords::Statement(NO_FRAME)));
        }
        for (statement, _) in after {
            channel.outlet.begin_line();
            channel.push(Kind::Frame(FrameWords::Statement(statement)));
        }
    }
    setup::refresh_setup(&mut channel.modal, &mut channel.standing, &mut channel.outlet);
}

/// Writes the swivelled plane again, without programmable frame.
pub(super) fn restate(channel: &mut Channel<'_>, span: Span) -> Result<(), Fault> {
    let none = FrameStatement {
        kind: FrameKind::Translate,
        additive: false,
        values: AxisVector::ZERO,
        named: AxisSet::EMPTY,
        in_plane_rad: None,
    };
    let nothing_on_top = FrameStatement { additive: true, ..none };
    let statements = channel.modal.swivelled.as_ref().map_or([none, nothing_on_top], |swivelled| swivelled.statements);
    channel.modal.programmable = Frame::identity();
    channel.modal.fine = AxisVector::ZERO;
    setup::refresh_setup(&mut channel.modal, &mut channel.standing, &mut channel.outlet);
    if channel.standing.setup.frame.linear().iter().any(|part| !part.is_finite()) {
        return Err(refused(span, "the tilted plane does not give a valid frame".to_owned()));
    }
    for statement in statements.into_iter().filter(|statement| !(statement.additive && statement.named.is_empty())) {
        channel.outlet.begin_line();
        push_frame(channel, FrameWords::Statement(statement));
    }
    Ok(())
}

pub(super) fn refused(span: Span, message: String) -> Fault {
    let help = "program the plane with frame statements (AROT) and the rotary axes with their words";
    fault(Code::BAD_SWIVEL, span, message, help)
}
