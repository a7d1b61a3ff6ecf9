//! Tools: T with M6, M66 or M67, allowances (G39), direction (G66, G67), and radius compensation (G40 to G44).

use super::channel::Channel;
use super::gathered::Gathered;
use super::modal::Modal;
use super::setup;
use crate::exec::core::contour::{FeedAt, Reach, Side};
use crate::exec::core::fault::{Fault, bad_value, fault};
use crate::exec::core::tool::{ToolSize, without_value};
use ncfix_base::diagnostic::Code;
use ncfix_base::source::Span;
use ncfix_machine::snc::{Kind, WordValue};

/// M functions that activate the selected tool, and `true` if the machine moves to change it.
const CHANGES: &[(u16, bool)] = &[(6, true), (66, true), (67, false)];

pub(super) fn tool(channel: &mut Channel<'_>, gathered: &mut Gathered) -> Result<(), Fault> {
    if let Some((number, span)) = gathered.once(b'T', None)? {
        if !(0.0..1e8).contains(&number) {
            return Err(bad_value(
                span,
                format!("T{number} is not a valid tool number"),
                "write a number, 0 or larger",
            ));
        }
        channel.modal.tool.selected = Some(number);
        channel.outlet.push(Kind::Tool(WordValue::Number(number)));
    }
    for &(number, moves) in CHANGES {
        let Some(code) = gathered.functions.iter().find(|code| code.number == number).copied() else { continue };
        if moves {
            if channel.modal.contour.compensates() {
                let message = format!("a tool change (M{number}) while radius compensation is on");
                let help = "program G40 with a motion in the plane before it";
                return Err(fault(Code::BAD_COMPENSATION, code.span, message, help));
            }
            if channel.modal.turning.is_some() {
                let message = format!("a tool change (M{number}) under G141");
                return Err(fault(Code::FORBIDDEN_STATE, code.span, message, "end G141 with G40 before it"));
            }
            if channel.settings.machine.control.tool_change_moves() {
                channel.modal.position.forget_by_change();
            }
        }
        activate(channel, code.span)?;
    }
    if let Some(span) = gathered.take_code(39) {
        allowances(channel, gathered, span)?;
    }
    for (number, word, reversed) in [(66, "G66", true), (67, "G67", false)] {
        if gathered.take_code(number).is_some() {
            channel.modal.tool_reversed = reversed;
            // The control itself adds the length, and must know its direction.
            channel.outlet.push(Kind::Keep(word));
            setup::refresh_setup(channel)?;
        }
    }
    Ok(())
}

/// Activates the selected tool.
fn activate(channel: &mut Channel<'_>, span: Span) -> Result<(), Fault> {
    let help = "add a [[tool]] entry there, or give the tool memory of the control with --setup";
    let Some(selected) = channel.modal.tool.selected else {
        let message = "a tool change without a programmed T";
        if channel.settings.requires_values {
            return Err(fault(Code::NO_TOOL, span, message, "program T before it or in the block"));
        }
        channel.outlet.warnings.push(fault(Code::TOOL_ASSUMED, span, message, "program T before it"));
        return Ok(());
    };
    channel.modal.tool.change();
    let (number, edge) = place(selected);
    let size = channel.tools.size(channel.settings.machine, number, edge);
    // With T0 the spindle has no tool, and no data are needed.
    let size = size.or_else(|| (number == 0).then(ToolSize::default));
    channel.modal.tool.put_size(size.map(|size| (size.length_mm[0], size.radius_mm)));
    setup::refresh_setup(channel)?;
    if !channel.modal.tool.assumed {
        return Ok(());
    }
    let message = format!("T{selected} has no value in the machine file");
    without_value(channel.settings.requires_values, &mut channel.outlet.warnings, span, &message, "length 0", help)
}

/// `G39 L R`: allowances on length and radius until changed.
fn allowances(channel: &mut Channel<'_>, gathered: &mut Gathered, span: Span) -> Result<(), Fault> {
    let scale = channel.modal.modes.scale();
    let words = [gathered.once(b'L', None)?, gathered.once(b'R', None)?];
    if words.iter().all(Option::is_none) {
        return Err(bad_value(span, "G39 needs L or R", "write G39 L… R…; G39 L0 R0 ends it"));
    }
    for (place, word) in channel.modal.allowance_mm.iter_mut().zip(words) {
        if let Some((value, _)) = word {
            *place = value * scale;
        }
    }
    if words[0].is_some() {
        // The control itself adds the length; the radius affects the path.
        let length = (channel.modal.allowance_mm[0] * 1e9).round() / 1e9;
        channel.outlet.push(Kind::Verbatim(format!("G39 L{length}").into_bytes()));
    }
    setup::refresh_setup(channel)
}

/// G40 to G44, and F1= for their feed on arcs.
pub(super) fn compensation_codes(strict: bool, modal: &mut Modal, gathered: &mut Gathered) -> Result<(), Fault> {
    for (number, side) in [(40, Side::Off), (41, Side::Left), (42, Side::Right)] {
        let Some(span) = gathered.take_code(number) else { continue };
        let contour = &mut modal.contour;
        contour.reach = Reach::End;
        contour.side = side;
        if side == Side::Off {
            continue;
        }
        contour.activation += 1;
        if modal.tool.selected.is_none() && strict {
            return Err(no_tool(number, span));
        }
        if modal.tool.assumed && strict {
            let message = "the radius of the tool has no value in the machine file";
            return Err(fault(Code::NO_TOOL, span, message, "add a [[tool]] entry there"));
        }
    }
    for (number, reach) in [(43, Reach::To), (44, Reach::Past)] {
        let Some(span) = gathered.take_code(number) else { continue };
        if modal.contour.compensates() {
            let message = format!("G{number} while radius compensation is on");
            return Err(fault(Code::NOT_SUPPORTED, span, message, "end the compensation with G40 first"));
        }
        if modal.tool.selected.is_none() && strict {
            return Err(no_tool(number, span));
        }
        modal.contour.reach = reach;
    }
    if let Some((value, span)) = gathered.once(b'F', Some(1))? {
        modal.contour.feed_at = match value {
            0.0 => FeedAt::Center,
            1.0 => FeedAt::InnerContour(0),
            2.0 => FeedAt::Contour,
            _ => return Err(bad_value(span, format!("F1={value} is not supported"), "write F1=0, 1 or 2")),
        };
    }
    Ok(())
}

/// Compensation by the radius of a tool that only the control knows.
fn no_tool(code: u16, span: Span) -> Fault {
    let message = format!("G{code} without T: the radius would be that of the tool of an earlier program");
    fault(Code::BAD_COMPENSATION, span, message, "program T and M6 before it")
}

/// Number and edge of a T word: the hundredths of `T5.01` are a further edge.
pub(super) fn place(word: f64) -> (u32, u32) {
    let further = (word.fract() * 100.0).round();
    // Both within range: the caller has checked the number.
    (word.trunc() as u32, 1 + further as u32)
}
