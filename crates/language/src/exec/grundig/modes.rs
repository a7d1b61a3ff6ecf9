//! Modal codes: motion, plane, unit, dimensions, positioning; and codes that are passed through.

use super::channel::Channel;
use super::gathered::{Gathered, name};
use super::modal::{GEOMETRY, Modal, MotionKind, SPINDLE};
use super::setup;
use crate::exec::core::fault::{Fault, bad_value, fault};
use crate::exec::core::motion_sink::MotionSink;
use ncfix_base::diagnostic::Code;
use ncfix_base::geometry::{Axis, AxisSet, Plane};
use ncfix_base::source::Span;
use ncfix_dialect::CodeTable;
use ncfix_dialect::{CodeEffect, CodeEntry};
use ncfix_machine::snc::{FeedUnit, Kind};

/// Modal codes without motion that the control needs.
const KEPT: &[(u16, &str)] = &[(25, "G25"), (26, "G26"), (27, "G27"), (94, "G94"), (95, "G95")];

/// Codes that do not affect positions: display codes are dropped with their words, others passed through with theirs.
pub(super) fn passed_codes(
    codes: &'static CodeTable,
    modal: &mut Modal,
    outlet: &mut MotionSink<'_>,
    gathered: &mut Gathered,
) {
    let mut at = 0;
    while let Some(&code) = gathered.codes.get(at) {
        let is_passed = |entry: &&CodeEntry| {
            matches!(entry.effect, CodeEffect::Display | CodeEffect::Keep)
                && KEPT.iter().all(|kept| kept.0 != code.number)
        };
        let Some(entry) = codes.g(usize::from(code.number)).filter(is_passed) else {
            at += 1;
            continue;
        };
        gathered.codes.remove(at);
        if let 96 | 97 = code.number {
            modal.codes.set(SPINDLE, code.number);
        }
        let mut text = format!("G{}", code.number);
        for item in gathered.take_used_by(entry) {
            text.push_str(&format!(" {}{}", name(item.letter, item.index), item.value));
        }
        if entry.effect == CodeEffect::Keep {
            outlet.push(Kind::Verbatim(text.into_bytes()));
        }
    }
}

/// Activates modal codes.
pub(super) fn modal_codes(channel: &mut Channel<'_>, gathered: &mut Gathered) -> Result<(), Fault> {
    let motions = [MotionKind::Rapid, MotionKind::Line, MotionKind::Clockwise, MotionKind::CounterClockwise];
    for (number, kind) in (0..).zip(motions) {
        if gathered.take_code(number).is_some() {
            channel.modal.modes.motion = kind;
        }
    }
    for (number, word) in [(17, "G17"), (18, "G18"), (19, "G19")] {
        let Some(span) = gathered.take_code(number) else { continue };
        channel.outlet.push(Kind::Keep(word));
        let plane = u8::try_from(number).ok().and_then(Plane::from_number).unwrap_or_default();
        if plane != channel.modal.modes.plane {
            if channel.modal.contour.compensates() {
                let message = "the plane changes while radius compensation is on";
                return Err(fault(Code::NOT_SUPPORTED, span, message, "end the compensation with G40 first"));
            }
            channel.modal.modes.plane = plane;
            setup::refresh_setup(channel)?;
        }
    }
    for (number, inch) in [(70, true), (71, false)] {
        if gathered.take_code(number).is_some() {
            channel.modal.modes.inch = inch;
        }
    }
    for (number, incremental) in [(90, false), (91, true)] {
        if gathered.take_code(number).is_some() {
            channel.modal.modes.incremental = incremental;
        }
    }
    for number in [63, 64] {
        if gathered.take_code(number).is_some() {
            channel.modal.codes.set(GEOMETRY, number);
        }
    }
    for &(number, word) in KEPT {
        if gathered.take_code(number).is_some() {
            channel.outlet.push(Kind::Keep(word));
            match number {
                27 => channel.modal.positioning_logic = true,
                94 => channel.modal.modes.select_feed_unit(FeedUnit::PerMinute),
                95 => channel.modal.modes.select_feed_unit(FeedUnit::PerTurn),
                _ => {}
            }
        }
    }
    // The cylinder is never developed here.
    gathered.take_code(180);
    if let Some(span) = gathered.take_code(28) {
        positioning_words(&mut channel.modal, &mut channel.outlet, gathered, span)?;
    }
    Ok(())
}

/// G74: axes move at rapid to a machine position that only the control knows, or that is not in program coordinates. The block is passed through;
/// afterwards the position of the axes is unknown.
pub(super) fn reference(
    codes: &'static CodeTable,
    modal: &mut Modal,
    outlet: &mut MotionSink<'_>,
    gathered: &mut Gathered,
    span: Span,
) -> Result<(), Fault> {
    if modal.contour.compensates() {
        let message = "G74 while radius compensation is on";
        return Err(fault(Code::BAD_COMPENSATION, span, message, "program G40 with a motion in the plane before it"));
    }
    let mut text = "G74".to_owned();
    let mut lost = AxisSet::EMPTY;
    let words = codes.g(74).map(|entry| gathered.take_used_by(entry)).unwrap_or_default();
    for item in words {
        let axis = Axis::from_letter(item.letter);
        axis.into_iter().for_each(|axis| lost.insert(axis));
        let is_length = item.index.is_none() && axis.is_some_and(|axis| !axis.is_rotary());
        let value = if is_length { item.value * modal.modes.scale() } else { item.value };
        text.push_str(&format!(" {}{}", name(item.letter, item.index), (value * 1e9).round() / 1e9));
    }
    if lost.is_empty() {
        return Err(bad_value(span, "G74 has no axis word", "write for example G74 Z-1 L1"));
    }
    modal.position.keep(modal.position.known.difference(lost));
    outlet.push(Kind::Verbatim(text.into_bytes()));
    outlet.push(Kind::Lost(lost));
    Ok(())
}

/// G174: the tool is withdrawn along its own axis, to a position that only the control knows. The block is passed through.
pub(super) fn withdraw(
    codes: &'static CodeTable,
    modal: &mut Modal,
    outlet: &mut MotionSink<'_>,
    gathered: &mut Gathered,
    span: Span,
) -> Result<(), Fault> {
    if modal.contour.compensates() || modal.turning.is_some() {
        let message = "G174 while radius compensation is on";
        return Err(fault(Code::FORBIDDEN_STATE, span, message, "program G40 before it"));
    }
    let mut text = "G174".to_owned();
    for item in codes.g(174).map(|entry| gathered.take_used_by(entry)).unwrap_or_default() {
        let value = item.value * modal.modes.scale();
        text.push_str(&format!(" {}{}", name(item.letter, item.index), (value * 1e9).round() / 1e9));
    }
    modal.position.keep(modal.position.known.difference(AxisSet::XYZ));
    outlet.push(Kind::Verbatim(text.into_bytes()));
    outlet.push(Kind::Lost(AxisSet::XYZ));
    Ok(())
}

/// G28: positioning settings, passed through with their values.
fn positioning_words(
    modal: &mut Modal,
    outlet: &mut MotionSink<'_>,
    gathered: &mut Gathered,
    span: Span,
) -> Result<(), Fault> {
    let mut text = "G28".to_owned();
    for index in 1..=9 {
        let Some((value, at)) = gathered.once(b'I', Some(index))? else { continue };
        if index == 5 {
            modal.positioning_logic = match value {
                0.0 => true,
                1.0 => false,
                _ => return Err(bad_value(at, format!("I5={value} is neither 0 nor 1"), "write I5=0 or I5=1")),
            };
        }
        text.push_str(&format!(" I{index}={value}"));
    }
    if text.len() == 3 {
        return Err(bad_value(span, "G28 needs at least one of I3= to I7=", "write for example G28 I5=1"));
    }
    outlet.push(Kind::Verbatim(text.into_bytes()));
    Ok(())
}
